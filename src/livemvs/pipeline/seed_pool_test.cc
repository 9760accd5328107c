#include "livemvs/pipeline/seed_pool.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cpu/host_seeds.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

constexpr std::size_t kCapacity = 10;

// Plants as many seeds as it is told, which carry their number as bearing; they end when told to.
class ToldBackend final : public Backend {
 public:
  std::string name() const override { return "told"; }
  std::size_t capacity() const override { return seeds_.capacity(); }
  void SetFrame(std::span<const ImageView<std::uint8_t>> /*pyramid*/) override {}
  UpdateStatistics Update(std::span<const SeedGroup> /*groups*/, CameraModel /*model*/) override {
    return {};
  }
  std::span<const EndedSeed> TakeEnded() override { return seeds_.TakeEnded(); }
  void Compact() override { seeds_.Compact(); }
  std::vector<std::size_t> Plant(const Planting& /*planting*/) override {
    const std::array<std::uint8_t, kPatchPixels> patch{};
    for (std::size_t l = told.size(); l-- > 0;) {
      for (std::size_t n = 0; n < told[l]; ++n) {
        const auto number = static_cast<float>(next_++);
        seeds_.Append({{0.5F, 1.5F}, number, 0, &patch[kPatchPixels / 2], kPatchSize},
                      {0.5F, 0.04F, 5, 5});
      }
    }
    return told;
  }
  void ForgetPoints() override {}
  std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) override {
    return seeds_.Read(begin, end, step);
  }
  std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) override {
    return seeds_.ReadPatches(begin, end);
  }

  void End(std::size_t slot) { seeds_.columns().fate[slot] = Fate::kUnseen; }

  std::vector<std::size_t> told;  // how many to plant next, by level

 private:
  HostSeeds seeds_{kCapacity};
  int next_ = 0;
};

// Seeds are numbered in the order of their birth.
class SeedPoolTest : public ::testing::Test {
 protected:
  void Plant(std::int64_t frame, const std::vector<std::size_t>& by_level) {
    backend().told = by_level;
    std::size_t all = 0;
    for (const std::size_t n : by_level) all += n;
    EXPECT_EQ(pool_.Plant(frame, {{scene_.camera, Rigid3d{}}, nullptr, {}, {}}),
              static_cast<std::int64_t>(all));
  }

  void End(std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) backend().End(slot);
  }

  std::vector<std::pair<std::int64_t, int>> TakeEnded() {
    std::vector<std::pair<std::int64_t, int>> ended;
    pool_.TakeEnded([&](const ReferenceFrame& reference, const EndedSeed& e) {
      EXPECT_EQ(e.seed.fate, Fate::kUnseen);
      ended.emplace_back(reference.frame_index, static_cast<int>(e.seed.bearing_x));
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

  ToldBackend& backend() { return static_cast<ToldBackend&>(pool_.backend()); }

  testing_support::PlaneScene scene_;
  SeedPool pool_{std::make_unique<ToldBackend>()};
};

TEST_F(SeedPoolTest, KeepsOrderAndGroupsWhenGapsClose) {
  Plant(3, {4});
  Plant(5, {2});
  Plant(8, {4});
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
  Plant(9, {1});
  EXPECT_EQ(Alive().back(), (std::pair<std::int64_t, int>{9, 10}));
  EXPECT_EQ(pool_.size(), 6U);
}

TEST_F(SeedPoolTest, EmptiesAndFillsAgain) {
  for (int round = 0; round < 3; ++round) {
    Plant(round, {10});
    End(0, 10);
    EXPECT_EQ(TakeEnded().size(), 10U);
    pool_.Compact();
    EXPECT_EQ(pool_.size(), 0U);
    EXPECT_EQ(pool_.free_slots(), 10U);
    EXPECT_TRUE(pool_.references().empty());
  }
}

TEST_F(SeedPoolTest, AGroupWithoutSeedsIsNone) {
  Plant(1, {0, 0});
  EXPECT_TRUE(pool_.references().empty());
}

TEST_F(SeedPoolTest, EachLevelIsAGroupTheCoarsestFirst) {
  Plant(4, {5, 0, 2});
  ASSERT_EQ(pool_.references().size(), 2U);
  const ReferenceFrame& coarse = pool_.references()[0];
  const ReferenceFrame& fine = pool_.references()[1];
  EXPECT_EQ(coarse.level, 2);
  EXPECT_EQ(coarse.begin, 0U);
  EXPECT_EQ(coarse.end, 2U);
  EXPECT_EQ(coarse.camera.width, scene_.camera.width / 4);
  EXPECT_EQ(fine.level, 0);
  EXPECT_EQ(fine.begin, 2U);
  EXPECT_EQ(fine.end, 7U);
  EXPECT_EQ(fine.alive, 5U);
  EXPECT_EQ(fine.frame_index, 4);
  EXPECT_EQ(pool_.size(), 7U);
}

// A camera whose centre is at (x, 0, 0) and that looks somewhere.
Rigid3d CameraAt(double x) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return {rotation, -(rotation * Eigen::Vector3d(x, 0, 0))};
}

TEST_F(SeedPoolTest, SeedsMeetFramesThatTheCameraMovedFor) {
  Plant(0, {1});
  const struct {
    double x;
    bool meets;
    const char* why;
  } frames[] = {{0, false, "still at its own frame"},
                {1, true, "away from its own frame"},
                {1.11, false, "0.11 is less than a tenth of 1.11"},
                {1.12, true, "moved by 0.12 since 1"},
                {1.12, false, "rests"},
                {-0.5, true, "on the other side"},
                {-0.46, false, "0.04 is less than a tenth of 0.46"},
                {0, true, "back at its own place"}};
  for (const auto& f : frames) {
    EXPECT_EQ(pool_.Meet(CameraAt(f.x), 1, 0.1).size(), f.meets ? 1U : 0U) << f.why;
  }
}

TEST_F(SeedPoolTest, WhereTheCameraRestsSeedsMeetEveryEighthFrame) {
  Plant(0, {1});
  for (int frame = 1; frame <= 40; ++frame) {
    EXPECT_EQ(pool_.Meet(CameraAt(0), 1, 0.1).size(), frame % (kMostLeftOut + 1) == 0 ? 1U : 0U)
        << frame;
  }
}

TEST_F(SeedPoolTest, EachReferenceFrameMeetsByItsOwnBaseline) {
  Plant(0, {1});
  pool_.Meet(CameraAt(1), 1, 0.1);
  backend().told = {2};
  pool_.Plant(1, {{scene_.camera, CameraAt(1)}, nullptr, {}, {}});
  const std::vector<ReferenceFrame> met = pool_.Meet(CameraAt(1.05), 1, 0.1);
  ASSERT_EQ(met.size(), 1U) << "0.05 is much for the second, and little for the first";
  EXPECT_EQ(met[0].frame_index, 1);
  EXPECT_EQ(met[0].begin, 1U);
  EXPECT_EQ(met[0].end, 3U);
  EXPECT_EQ(pool_.Meet(CameraAt(1.05), 1, 0).size(), 2U) << "0: every frame";
}

TEST_F(SeedPoolTest, APictureThatIsTooSmallForALevelIsNotMet) {
  Plant(0, {1, 0, 1});
  EXPECT_EQ(pool_.Meet(CameraAt(1), 1, 0.1).size(), 1U);
  const std::vector<ReferenceFrame> met = pool_.Meet(CameraAt(1.01), 3, 0.1);
  ASSERT_EQ(met.size(), 1U) << "what the small picture did not show counts for its level alone";
  EXPECT_EQ(met[0].level, 2);
}

}  // namespace
}  // namespace livemvs
