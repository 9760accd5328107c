#include "livemvs/pipeline/seed_pool.h"

#include <gtest/gtest.h>

#include <array>

namespace livemvs {
namespace {

// A pool in which seed number n carries n in all of its columns.
class SeedPoolTest : public ::testing::Test {
 protected:
  void Add(int n) {
    std::array<std::uint8_t, 8 * kPatchSize> image{};
    for (int r = 0; r < kPatchSize; ++r) {
      for (int c = 0; c < kPatchSize; ++c) {
        image[r * 8 + c] = static_cast<std::uint8_t>(n + r * kPatchSize + c);
      }
    }
    const auto f = static_cast<float>(n);
    const NewSeed seed = {{f + 1, f + 2}, f + 3, f + 4, &image[kPatchRadius * 8 + kPatchRadius], 8};
    pool_.Add(seed, {f + 5, f + 6, f + 7, f + 8});
  }

  void ExpectSeed(std::size_t i, int n) const {
    const SeedColumns& s = pool_.columns();
    const auto f = static_cast<float>(n);
    EXPECT_EQ(s.c0[i], f + 1);
    EXPECT_EQ(s.c1[i], f + 2);
    EXPECT_EQ(s.bearing_x[i], f + 3);
    EXPECT_EQ(s.bearing_y[i], f + 4);
    EXPECT_EQ(s.mu[i], f + 5);
    EXPECT_EQ(s.sigma2[i], f + 6);
    EXPECT_EQ(s.a[i], f + 7);
    EXPECT_EQ(s.b[i], f + 8);
    EXPECT_EQ(s.fate[i], Fate::kAlive);
    for (int k = 0; k < kPatchPixels; ++k) EXPECT_EQ(s.patch[i * kPatchPixels + k], n + k);
  }

  void Begin(std::int64_t frame) { pool_.BeginReference(frame, 0, Camera{}, Rigid3d{}); }

  SeedPool pool_{10};
};

TEST_F(SeedPoolTest, KeepsOrderAndGroupsWhenGapsClose) {
  Begin(3);
  for (int n = 0; n < 4; ++n) Add(n);
  Begin(5);
  for (int n = 4; n < 6; ++n) Add(n);
  Begin(8);
  for (int n = 6; n < 10; ++n) Add(n);
  EXPECT_EQ(pool_.size(), 10U);
  EXPECT_EQ(pool_.free_slots(), 0U);
  for (const std::size_t i : {0, 2, 4, 5, 9}) pool_.Remove(i);
  EXPECT_EQ(pool_.size(), 5U);
  EXPECT_EQ(pool_.free_slots(), 5U);
  pool_.Compact();
  EXPECT_EQ(pool_.free_slots(), 5U);
  ASSERT_EQ(pool_.references().size(), 2U) << "the group without seeds is gone";
  EXPECT_EQ(pool_.references()[0].frame_index, 3);
  EXPECT_EQ(pool_.references()[0].begin, 0U);
  EXPECT_EQ(pool_.references()[0].end, 2U);
  EXPECT_EQ(pool_.references()[1].frame_index, 8);
  EXPECT_EQ(pool_.references()[1].begin, 2U);
  EXPECT_EQ(pool_.references()[1].end, 5U);
  const int expected[] = {1, 3, 6, 7, 8};
  for (std::size_t i = 0; i < 5; ++i) ExpectSeed(i, expected[i]);
  Begin(9);
  Add(40);
  ExpectSeed(5, 40);
  EXPECT_EQ(pool_.size(), 6U);
}

TEST_F(SeedPoolTest, EmptiesAndFillsAgain) {
  for (int round = 0; round < 3; ++round) {
    Begin(round);
    for (int n = 0; n < 10; ++n) Add(n);
    for (std::size_t i = 0; i < 10; ++i) pool_.Remove(i);
    pool_.Compact();
    EXPECT_EQ(pool_.size(), 0U);
    EXPECT_EQ(pool_.free_slots(), 10U);
    EXPECT_TRUE(pool_.references().empty());
  }
}

TEST_F(SeedPoolTest, NewSeedsHaveMetNoFrame) {
  Begin(0);
  Add(1);
  EXPECT_EQ(pool_.columns().counts[0].age, 0);
  EXPECT_EQ(pool_.columns().counts[0].views, 0);
  EXPECT_EQ(pool_.columns().counts[0].unseen, 0);
}

}  // namespace
}  // namespace livemvs
