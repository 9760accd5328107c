#include "livemvs/pipeline/seed_pool.h"

#include <gtest/gtest.h>

#include <array>

#include "livemvs/backend/backend.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

constexpr std::size_t kCapacity = 10;

Options SmallPool() {
  Options options = testing_support::TestOptions();
  options.max_seeds = kCapacity;
  options.max_unseen = 1;
  return options;
}

// A pool whose seeds carry their number as bearing.
class SeedPoolTest : public ::testing::Test {
 protected:
  void Plant(std::int64_t frame, int first, int end) {
    pool_.BeginReference(frame, 0, scene_.camera, Rigid3d{});
    for (int n = first; n < end; ++n) {
      pool_.Add({{0.5F, 1.5F},
                 static_cast<float>(n),
                 0,
                 &image_[kPatchRadius * kPatchSize + kPatchRadius],
                 kPatchSize});
    }
    pool_.EndReference({0.5F, 0.04F, 5, 5});
  }

  // Ends the seeds in slots [begin, end): they meet a frame that sees none of them.
  void End(std::size_t begin, std::size_t end) {
    const Rigid3d away{Eigen::Matrix3d::Identity(), {0, 0, -10}};
    SeedGroup group{};
    group.begin = begin;
    group.end = end;
    group.view = MakeRelativeView<float>(scene_.camera, Rigid3d{}, scene_.camera, away);
    group.pixel_width = 1e-3F;
    const Image<std::uint8_t> grey(scene_.camera.width, scene_.camera.height);
    const ImageView<std::uint8_t> pyramid[] = {grey.view()};
    const UpdateStatistics statistics =
        pool_.backend().Update({group}, scene_.camera.model, pyramid);
    EXPECT_EQ(statistics.out_of_view, static_cast<std::int64_t>(end - begin));
  }

  std::vector<std::pair<std::int64_t, int>> TakeEnded() {
    std::vector<std::pair<std::int64_t, int>> ended;
    pool_.TakeEnded([&](const ReferenceFrame& reference, const SeedState& seed) {
      EXPECT_EQ(seed.fate, Fate::kUnseen);
      ended.emplace_back(reference.frame_index, static_cast<int>(seed.bearing_x));
    });
    return ended;
  }

  std::vector<std::pair<std::int64_t, int>> Alive(std::size_t step = 1) const {
    std::vector<std::pair<std::int64_t, int>> alive;
    pool_.ForEachAlive(step, [&](const ReferenceFrame& reference, const SeedState& seed) {
      alive.emplace_back(reference.frame_index, static_cast<int>(seed.bearing_x));
    });
    return alive;
  }

  using Seeds = std::vector<std::pair<std::int64_t, int>>;

  testing_support::PlaneScene scene_;
  std::array<std::uint8_t, kPatchPixels> image_{};
  SeedPool pool_{MakeCpuBackend(SmallPool())};
};

TEST_F(SeedPoolTest, KeepsOrderAndGroupsWhenGapsClose) {
  Plant(3, 0, 4);
  Plant(5, 4, 6);
  Plant(8, 6, 10);
  EXPECT_EQ(pool_.size(), 10U);
  EXPECT_EQ(pool_.free_slots(), 0U);
  End(1, 3);
  End(4, 7);
  EXPECT_EQ(TakeEnded(), (Seeds{{3, 1}, {3, 2}, {5, 4}, {5, 5}, {8, 6}}));
  EXPECT_TRUE(TakeEnded().empty());
  EXPECT_EQ(pool_.size(), 5U);
  EXPECT_EQ(pool_.free_slots(), 5U);
  const Seeds left = {{3, 0}, {3, 3}, {8, 7}, {8, 8}, {8, 9}};
  EXPECT_EQ(Alive(), left);
  pool_.Compact();
  EXPECT_EQ(Alive(), left);
  EXPECT_EQ(Alive(2), (Seeds{{3, 0}, {8, 7}, {8, 9}}));
  ASSERT_EQ(pool_.references().size(), 2U) << "the group without seeds is gone";
  EXPECT_EQ(pool_.references()[0].begin, 0U);
  EXPECT_EQ(pool_.references()[0].end, 2U);
  EXPECT_EQ(pool_.references()[1].begin, 2U);
  EXPECT_EQ(pool_.references()[1].end, 5U);
  Plant(9, 40, 41);
  EXPECT_EQ(Alive().back(), (std::pair<std::int64_t, int>{9, 40}));
  EXPECT_EQ(pool_.size(), 6U);
}

TEST_F(SeedPoolTest, EmptiesAndFillsAgain) {
  for (int round = 0; round < 3; ++round) {
    Plant(round, 0, 10);
    End(0, 10);
    EXPECT_EQ(TakeEnded().size(), 10U);
    pool_.Compact();
    EXPECT_EQ(pool_.size(), 0U);
    EXPECT_EQ(pool_.free_slots(), 10U);
    EXPECT_TRUE(pool_.references().empty());
  }
}

TEST_F(SeedPoolTest, AGroupWithoutSeedsIsNone) {
  Plant(1, 0, 0);
  EXPECT_TRUE(pool_.references().empty());
}

}  // namespace
}  // namespace livemvs
