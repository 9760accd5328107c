// Planting, seed by seed, against a plain version of it that shares no rule with the backends but
// those of core/ and the part of the picture that is looked at.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "livemvs/backend/backend_test_util.h"
#include "livemvs/backend/planting.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::Shrunk;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

struct Planted {
  std::vector<std::size_t> by_level;
  std::vector<SeedState> seeds;  // in the order of their slots
  std::vector<std::uint8_t> patches;

  void Add(const NewSeed& seed, const Options& options) {
    seeds.push_back(
        {seed.interval, seed.bearing_x, seed.bearing_y, PriorOf(options), {0, 0, 0}, Fate::kAlive});
    for (int v = -kPatchRadius; v <= kPatchRadius; ++v) {
      const std::uint8_t* row = seed.patch + v * seed.stride - kPatchRadius;
      patches.insert(patches.end(), row, row + kPatchSize);
    }
  }
};

// A picture with its halves.
class Levels {
 public:
  Levels(const PosedFrame& frame, int levels) : views_{frame.picture->grey.view()} {
    for (int l = 1; l < levels; ++l) {
      halves_.push_back(Shrunk(l == 1 ? frame.picture->grey : halves_.back(), 2));
    }
    for (const Image<std::uint8_t>& half : halves_) views_.push_back(half.view());
  }

  std::span<const ImageView<std::uint8_t>> views() const { return views_; }

 private:
  std::vector<Image<std::uint8_t>> halves_;
  std::vector<ImageView<std::uint8_t>> views_;
};

// Step 1 of Algorithm 1, word by word.
class PlainPlanting {
 public:
  // `seeds` are those of the planting's groups, by slot.
  PlainPlanting(const Options& options,
                const Planting& planting,
                std::span<const ImageView<std::uint8_t>> pyramid,
                const std::vector<SeedState>& seeds)
      : options_(options),
        planting_(planting),
        pyramid_(pyramid),
        params_(MakeCameraParams<float>(planting.frame.camera)) {
    for (const auto& grey : pyramid) {
      projectors_.emplace_back(AtLevel(planting.frame.camera, static_cast<int>(marks_.size())));
      marks_.emplace_back(grey.width, grey.height);
    }
    for (const SeedGroup& group : planting.groups) {
      for (std::size_t i = group.begin; i < group.end; ++i) MarkSeed(group, seeds[i]);
    }
    for (const Point& point : planting.points) MarkPoint(point);
  }

  const Image<std::uint8_t>& marks(int level) const { return marks_[level]; }

  Planted Plant(std::size_t free) const {
    Planted planted;
    planted.by_level.resize(pyramid_.size());
    for (int l = static_cast<int>(pyramid_.size()) - 1; l >= 0; --l) {
      const std::size_t before = planted.seeds.size();
      PlantLevel(l, free, &planted);
      planted.by_level[l] = planted.seeds.size() - before;
    }
    return planted;
  }

 private:
  struct Candidate {
    int x, y, phase;
    bool offered;
  };

  void MarkSeed(const SeedGroup& group, const SeedState& s) {
    if (s.fate != Fate::kAlive) return;
    VisitModel(planting_.frame.camera.model, [&](auto model) {
      const Projection<float> p = ProjectSeed<decltype(model)>(
          group.view, options_.coordinate, s.interval, s.bearing_x, s.bearing_y, s.posterior.mu);
      if (!p.visible || p.x < 0 || p.y < 0) return;
      if (p.x > group.view.width - 1 || p.y > group.view.height - 1) return;
      marks_[group.level](static_cast<int>(p.x + 0.5F), static_cast<int>(p.y + 0.5F)) = 1;
    });
  }

  void MarkPoint(const Point& point) {
    const Camera& camera = planting_.frame.camera;
    const Rigid3d& pose = planting_.frame.cam_from_world;
    const Eigen::Vector3f p =
        pose.rotation.cast<float>() * point.position + pose.translation.cast<float>();
    const float x = p.x() / p.z(), y = p.y() / p.z();
    if (p.z() <= 0 || x * x + y * y > params_.r2_max) return;
    float u = 0, v = 0;
    VisitModel(camera.model, [&](auto model) {
      const auto distorted = decltype(model)::Distort(params_.k, x, y);
      u = params_.fx * distorted.x + params_.cx;
      v = params_.fy * distorted.y + params_.cy;
    });
    if (u < 0 || v < 0 || u >= static_cast<float>(camera.width)) return;
    if (v >= static_cast<float>(camera.height)) return;
    const float cosine = std::cos(options_.cover_angle_deg * static_cast<float>(M_PI / 180));
    const Eigen::Vector3f towards = pose.Center().cast<float>() - point.position;
    if (towards.dot(point.normal) <= cosine * p.norm()) return;
    for (std::size_t l = 0; l < marks_.size(); ++l) {
      const auto pixels = static_cast<float>(1 << l);  // of level 0 across one of this
      const float pixel = static_cast<float>(1 / camera.FocalLength());
      const int column = static_cast<int>(std::floor((u + 0.5F) / pixels));
      const int row = static_cast<int>(std::floor((v + 0.5F) / pixels));
      if (column >= marks_[l].width() || row >= marks_[l].height()) continue;
      if (point.footprint <= 1.5F * p.norm() * pixel * pixels) marks_[l](column, row) = 1;
    }
  }

  bool IsCandidate(int level, int x, int y) const {
    if (x % options_.seed_spacing_px != 0 || y % options_.seed_spacing_px != 0) return false;
    for (int v = y - options_.cover_radius_px; v <= y + options_.cover_radius_px; ++v) {
      for (int u = x - options_.cover_radius_px; u <= x + options_.cover_radius_px; ++u) {
        if (u < 0 || v < 0 || u >= marks_[level].width() || v >= marks_[level].height()) continue;
        if (marks_[level](u, v) != 0) return false;
      }
    }
    double sum = 0, squares = 0;
    for (int k = 0; k < kPatchPixels; ++k) {
      const double v =
          pyramid_[level](x + k % kPatchSize - kPatchRadius, y + k / kPatchSize - kPatchRadius);
      sum += v;
      squares += v * v;
    }
    const double least = level > 0 ? options_.min_coarse_stddev : options_.min_patch_stddev;
    // Whole numbers: exact.
    return kPatchPixels * squares - sum * sum >= kPatchPixels * kPatchPixels * least * least;
  }

  std::vector<Candidate> Candidates(int level) const {
    static constexpr int kBayer[4][4] = {
        {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const PixelRect rect = MakeCandidateRule(options_, planting_, level).rect;
    const int spacing = options_.seed_spacing_px;
    std::vector<Candidate> found;
    for (int y = rect.y0; y < rect.y1; ++y) {
      for (int x = rect.x0; x < rect.x1; ++x) {
        if (!IsCandidate(level, x, y)) continue;
        found.push_back({x, y, kBayer[y / spacing % 4][x / spacing % 4], false});
      }
    }
    return found;
  }

  bool SeedOf(int level, const Candidate& c, NewSeed* seed) const {
    const ImageView<std::uint8_t>& grey = pyramid_[level];
    const float noise2 = NoiseVariance(options_, level);
    if (!CanMatch(options_, noise2, &grey(c.x, c.y), grey.stride)) return false;
    const float most = level > 0 ? 0 : options_.max_texture_offset_px;
    if (!IsCentred(most, noise2, &grey(c.x, c.y), grey.stride)) return false;
    const auto ray = projectors_[level].Unproject({c.x, c.y});
    if (!ray) return false;
    const Rigid3d& pose = planting_.frame.cam_from_world;
    const Eigen::Vector3d direction = pose.rotation.transpose() * (*ray / ray->norm());
    const auto depths = planting_.range->Along(pose.Center(), direction, 1 / ray->norm());
    if (!depths || depths->second - depths->first < 0.01 * depths->second) return false;
    const auto coordinate = [&](double z) {
      return static_cast<float>(options_.coordinate == DepthCoordinate::kDepth ? z : 1 / z);
    };
    *seed = {{coordinate(depths->first), coordinate(depths->second)},
             static_cast<float>(ray->x()),
             static_cast<float>(ray->y()),
             &grey(c.x, c.y),
             grey.stride};
    return true;
  }

  // One round: of the first phases all, of the next one an even share.
  std::size_t Offer(int level,
                    std::size_t wanted,
                    std::size_t free,
                    std::vector<Candidate>* candidates,
                    Planted* planted) const {
    std::size_t count[17] = {};
    for (const Candidate& c : *candidates) count[c.phase] += !c.offered;
    int whole = 0;
    while (whole < 16 && count[whole] <= wanted) wanted -= count[whole++];
    std::size_t carry = 0, offered = 0;
    for (Candidate& c : *candidates) {
      if (c.offered || c.phase > whole || planted->seeds.size() == free) continue;
      if (c.phase == whole) {
        carry += wanted;
        if (carry < count[whole]) continue;
        carry -= count[whole];
      }
      c.offered = true;
      ++offered;
      NewSeed seed;
      if (SeedOf(level, c, &seed)) planted->Add(seed, options_);
    }
    return offered;
  }

  // `free` counts the seeds of the levels before.
  void PlantLevel(int level, std::size_t free, Planted* planted) const {
    std::vector<Candidate> candidates = Candidates(level);
    double offers_per_seed = 1;
    while (planted->seeds.size() < free) {
      const std::size_t before = planted->seeds.size();
      const auto left = static_cast<double>(free - before);
      const std::size_t offered = Offer(
          level, static_cast<std::size_t>(offers_per_seed * left), free, &candidates, planted);
      if (offered == 0) return;
      const auto taken = static_cast<double>(planted->seeds.size() - before);
      offers_per_seed =
          taken > 0 ? 0.8 * static_cast<double>(offered) / taken : 8 * offers_per_seed;
      offers_per_seed = std::clamp(offers_per_seed, 1.0, 1e6);
    }
  }

  const Options& options_;
  const Planting& planting_;
  std::span<const ImageView<std::uint8_t>> pyramid_;
  CameraParams<float> params_;
  std::vector<Image<std::uint8_t>> marks_;
  std::vector<Projector> projectors_;
};

struct Case {
  std::string name;
  PlaneScene scene;
  Options options;
  SceneRange range;
};

std::vector<Case> Cases() {
  Case plain{"room for all", {}, TestOptions(), {}};
  plain.options.levels = 3;
  plain.options.seed_spacing_px = 1;
  plain.options.max_seeds = 60'000;
  plain.options.max_age = 1;  // most end in the first frame that they meet
  plain.options.min_views = 200;
  plain.range.near = 0.5;
  plain.range.far = 2;
  std::vector<Case> cases = {plain};
  const auto vary = [&](const std::string& name, const auto& f) {
    cases.push_back(plain);
    cases.back().name = name;
    f(&cases.back());
  };
  vary("a share of the pixels", [](Case* c) { c->options.max_seeds = 7001; });
  vary("a few slots", [](Case* c) {
    c->options.max_seeds = 300;
    c->options.levels = 1;
    c->options.seed_spacing_px = 3;
    c->options.cover_radius_px = 2;
  });
  vary("covered or not", [](Case* c) { c->options.cover_radius_px = -1; });
  vary("a box in the picture", [](Case* c) {
    c->range.near = 0.2;
    c->range.far = 5;
    c->range.box = Box{{-0.2, -0.15, 0.8}, {0.25, 0.2, 1.3}};
    c->range.margin = 0.01;
    c->options.coordinate = DepthCoordinate::kDepth;
  });
  vary("a box about the camera, which most rays leave early", [](Case* c) {
    c->range.box = Box{{-0.3, -0.3, -0.5}, {0.01, 0.005, 1.3}};
    c->options.max_seeds = 400;
  });
  vary("a box in a corner, which hardly any ray meets", [](Case* c) {
    c->range.box = Box{{-0.6, -0.5, -0.5}, {-0.42, -0.3, 1}};
    c->options.max_seeds = 20;
    c->options.levels = 1;
  });
  vary("ramps, which cannot be matched", [](Case* c) {
    c->options.min_patch_stddev = 0;
    c->options.image_noise = 12;
    c->options.max_seeds = 5000;
  });
  vary("a lens", [](Case* c) {
    c->scene.camera.model = CameraModel::kBrownConrady;
    c->scene.camera.distortion = {-0.25, 0.06, -0.003, 4e-4};
    c->options.max_seeds = 9000;
  });
  vary("a fisheye", [](Case* c) {
    c->scene.camera.model = CameraModel::kKannalaBrandt;
    c->scene.camera.distortion = {-0.02, 0.006, -0.003, 4e-4};
  });
  return cases;
}

// Points on the plane and elsewhere, of all widths, that face all ways.
PointCloud SomePoints() {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(-1, 1);
  PointCloud points(3000);
  for (Point& p : points) {
    const float x = 0.6F * uniform(random), y = 0.5F * uniform(random);
    const float z = 1 + 0.3F * x + 0.2F * y + 0.1F * uniform(random);
    p.position = {x, y, uniform(random) < -0.9F ? -z : z};
    const Eigen::Vector3f off(uniform(random), uniform(random), uniform(random));
    p.normal = (off - p.position.normalized()).normalized();
    p.footprint = 0.002F + 0.02F * std::abs(uniform(random));
  }
  return points;
}

void ExpectSame(const Planted& want, const Planted& have) {
  EXPECT_EQ(want.by_level, have.by_level);
  ASSERT_EQ(want.seeds.size(), have.seeds.size());
  for (std::size_t i = 0; i < want.seeds.size(); ++i) {
    const SeedState &a = want.seeds[i], &b = have.seeds[i];
    ASSERT_EQ(a.bearing_x, b.bearing_x) << i;
    ASSERT_EQ(a.bearing_y, b.bearing_y) << i;
    ASSERT_EQ(a.interval.c0, b.interval.c0) << i;
    ASSERT_EQ(a.interval.c1, b.interval.c1) << i;
    ASSERT_EQ(a.posterior.mu, b.posterior.mu) << i;
    ASSERT_EQ(a.posterior.sigma2, b.posterior.sigma2) << i;
    ASSERT_EQ(a.posterior.a, b.posterior.a) << i;
    ASSERT_EQ(a.posterior.b, b.posterior.b) << i;
    ASSERT_EQ(a.counts.age + a.counts.views + a.counts.unseen, 0) << i;
    ASSERT_EQ(a.fate, b.fate) << i;
  }
  EXPECT_TRUE(want.patches == have.patches);
}

class PlantingBitsTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const std::string trouble = testing_support::TroubleWith(GetParam());
    if (!trouble.empty()) GTEST_SKIP() << trouble;
  }

  // Plants behind the seeds in slots [0, begin).
  static Planted PlantOn(const Planting& planting, std::size_t begin, Backend* backend) {
    Planted planted{backend->Plant(planting), {}, {}};
    const std::size_t end =
        std::accumulate(planted.by_level.begin(), planted.by_level.end(), begin);
    planted.seeds = backend->Read(begin, end, 1);
    planted.patches = backend->ReadPatches(begin, end);
    return planted;
  }
};

// The seeds of one planting, by level, as they lie to another frame.
std::vector<SeedGroup> GroupsOf(const std::vector<std::size_t>& by_level,
                                const PosedFrame& ref,
                                const PosedFrame& cur) {
  std::vector<SeedGroup> groups;
  std::size_t end = 0;
  for (int l = static_cast<int>(by_level.size()) - 1; l >= 0; --l) {
    const std::size_t begin = end;
    end += by_level[static_cast<std::size_t>(l)];
    const Camera camera = AtLevel(ref.camera, l);
    groups.push_back({begin,
                      end,
                      l,
                      MakeRelativeView<float>(
                          camera, ref.cam_from_world, AtLevel(cur.camera, l), cur.cam_from_world),
                      static_cast<float>(1 / camera.FocalLength())});
  }
  return groups;
}

// How many of the seeds of each level are alive.
std::vector<std::size_t> CountAlive(const std::vector<SeedGroup>& groups,
                                    const std::vector<SeedState>& seeds) {
  std::vector<std::size_t> alive(groups.size());
  for (const SeedGroup& group : groups) {
    for (std::size_t i = group.begin; i < group.end; ++i) {
      alive[group.level] += seeds[i].fate == Fate::kAlive;
    }
  }
  return alive;
}

TEST_P(PlantingBitsTest, GivesTheSeedsOfThePlainVersion) {
  const PointCloud points = SomePoints();
  std::size_t ended = 0, planted_anew = 0;
  for (const Case& c : Cases()) {
    SCOPED_TRACE(c.name);
    // A GPU's library rounds the functions of a fisheye in its own way.
    const bool fisheye = c.scene.camera.model == CameraModel::kKannalaBrandt;
    if (fisheye && GetParam() == testing_support::kCuda) continue;
    const std::vector<PosedFrame> frames = c.scene.Render(SidewaysPath(2, 0.05));
    const auto slots = static_cast<std::size_t>(c.options.max_seeds);
    const auto backend = testing_support::MakeBackendOf(GetParam(), c.options);

    const Levels first(frames[0], c.options.levels), second(frames[1], c.options.levels);
    Planting planting = {
        {frames[0].camera, frames[0].cam_from_world}, &c.range, {}, {points.data(), 700}};
    backend->SetFrame(first.views());
    const Planted before = PlantOn(planting, 0, backend.get());
    EXPECT_GE(before.seeds.size(), std::min<std::size_t>(slots, 100));
    ExpectSame(PlainPlanting(c.options, planting, first.views(), {}).Plant(slots), before);

    backend->SetFrame(second.views());
    std::vector<SeedGroup> groups = GroupsOf(before.by_level, frames[0], frames[1]);
    backend->Update(groups, frames[1].camera.model);
    ended += backend->TakeEnded().size();
    const std::vector<std::size_t> left =
        CountAlive(groups, backend->Read(0, before.seeds.size(), 1));
    backend->Compact();
    groups = GroupsOf(left, frames[0], frames[1]);
    const std::size_t alive = std::accumulate(left.begin(), left.end(), std::size_t{0});
    planting = {{frames[1].camera, frames[1].cam_from_world}, &c.range, groups, points};
    const PlainPlanting plain(c.options, planting, second.views(), backend->Read(0, alive, 1));
    const Planted after = PlantOn(planting, alive, backend.get());
    planted_anew += after.seeds.size();
    ExpectSame(plain.Plant(slots - alive), after);
  }
  EXPECT_GT(ended, 1000U) << "too little to compare";
  EXPECT_GT(planted_anew, 1000U);
}

// As a device plants: cell by cell of the grid, with ranks in place of a walk along the rows.
Planted PlantByRank(const Options& options,
                    const Planting& planting,
                    std::span<const ImageView<std::uint8_t>> pyramid,
                    const PlainPlanting& plain) {
  Planted planted{std::vector<std::size_t>(pyramid.size()), {}, {}};
  for (int l = static_cast<int>(pyramid.size()) - 1; l >= 0; --l) {
    const CandidateRule rule = MakeCandidateRule(options, planting, l);
    const CandidateGrid grid = MakeCandidateGrid(rule);
    std::vector<std::uint8_t> candidates(grid.size());
    PhaseCounts counts{};
    for (std::size_t i = 0; i < grid.size(); ++i) {
      candidates[i] = CandidateAt(pyramid[l], plain.marks(l).view(), rule, grid.X(i), grid.Y(i));
      if (candidates[i] > 0) ++counts[candidates[i] - 1];
    }
    const PlantView view = MakePlantView(options, planting, l, pyramid[l]);
    const auto plant = [&](auto model, const Share& share, std::size_t free) {
      std::vector<std::size_t> offered;
      std::size_t rank = 0, taken = 0;
      for (std::size_t i = 0; i < grid.size(); ++i) {
        const int phase = candidates[i] - 1;
        const std::size_t its_rank = phase == share.whole ? rank++ : 0;
        if (phase >= 0 && share.Offers(phase, its_rank)) offered.push_back(i);
      }
      EXPECT_EQ(offered.size(), share.size);
      for (const std::size_t i : offered) {
        candidates[i] = 0;
        NewSeed seed;
        const bool gives = SeedAt<decltype(model)>(options, view, grid.X(i), grid.Y(i), &seed);
        if (!gives || taken == free) continue;
        planted.Add(seed, options);
        ++taken;
      }
      return taken;
    };
    const std::size_t free = static_cast<std::size_t>(options.max_seeds) - planted.seeds.size();
    planted.by_level[l] = VisitModel(planting.frame.camera.model, [&](auto model) {
      return PlantInRounds(counts, free, [&](const Share& share, std::size_t left) {
        return plant(model, share, left);
      });
    });
  }
  return planted;
}

TEST(PlantRuleTest, RanksChooseWhatAWalkAlongTheRowsDoes) {
  const PointCloud points = SomePoints();
  for (const Case& c : Cases()) {
    SCOPED_TRACE(c.name);
    const PosedFrame frame = c.scene.Render(SidewaysPath(1))[0];
    const Levels levels(frame, c.options.levels);
    const Planting planting = {{frame.camera, frame.cam_from_world}, &c.range, {}, points};
    const PlainPlanting plain(c.options, planting, levels.views(), {});
    const Planted want = plain.Plant(static_cast<std::size_t>(c.options.max_seeds));
    EXPECT_GE(static_cast<int>(want.seeds.size()), std::min(c.options.max_seeds, 100));
    ExpectSame(want, PlantByRank(c.options, planting, levels.views(), plain));
  }
}

TEST(PlantRuleTest, SharesAreEvenAndCountedRight) {
  for (const std::size_t wanted : {0U, 1U, 7U, 40U, 99U, 100U, 101U, 5000U}) {
    PhaseCounts left{};
    left[0] = 40;
    left[2] = 60;
    left[15] = 1000;
    const PhaseCounts before = left;
    const Share share = TakeShare(wanted, &left);
    std::size_t offered = 0;
    for (int phase = 0; phase < kPhases; ++phase) {
      std::size_t of_phase = 0;
      for (std::size_t rank = 0; rank < before[phase]; ++rank) {
        of_phase += share.Offers(phase, rank);
        if (phase != share.whole) continue;
        // As many of the first ones as their share, rounded down.
        ASSERT_EQ(of_phase, (rank + 1) * share.some / share.all) << wanted;
      }
      EXPECT_EQ(of_phase + left[phase], before[phase]) << wanted;
      offered += of_phase;
    }
    EXPECT_EQ(offered, share.size);
    EXPECT_EQ(offered, std::min<std::size_t>(wanted, 1100));
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         PlantingBitsTest,
                         ::testing::ValuesIn(testing_support::BackendKinds()),
                         [](const ::testing::TestParamInfo<std::string>& tested) {
                           return testing_support::TestNameOf(tested.param);
                         });

}  // namespace
}  // namespace livemvs
