#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/core/seed.h"

namespace livemvs::reference {

/// A seed with all it needs, on its own.
struct Seed {
  Camera camera;           ///< Of the reference frame.
  Rigid3d cam_from_world;  ///< Of the reference frame.
  Rigid3d last_met;        ///< cam_from_world of the last frame that it met, or of its own.
  int left_out = 0;        ///< Frames since then.
  double bearing_x = 0;    ///< The ray is (bearing_x, bearing_y, 1).
  double bearing_y = 0;
  Interval<double> interval{};
  Posterior<double> posterior{};
  std::array<std::uint8_t, kPatchPixels> patch{};
  SeedCounts counts{};
  Fate fate = Fate::kAlive;
};

/// What a seed meets.
struct Meeting {
  ImageView<std::uint8_t> image;
  Projector projector;  ///< Of its camera.
  Rigid3d cam_from_world;
  bool warp = false;  ///< The sampling grid turns and scales with the relative pose.
  int level = 0;      ///< Of the image pyramid, which the image and both cameras are of.
};

/// The outcome of step 2b; the numbers are set where the status is kMatched.
struct Match {
  MatchStatus status = MatchStatus::kMismatch;
  double score = 0;           ///< NCC.
  double offset = 0;          ///< [px] along the epipolar line.
  double mu = 0;              ///< Measured coordinate, in the seed's interval.
  double tau2 = 0;            ///< Its variance.
  double u = 0;               ///< Density of outliers.
  double step = 0;            ///< Change of mu per pixel of the current image.
  double bias2_px = 0;        ///< Variance of the error that all matches of the seed share [px²].
  bool had_parallax = false;  ///< The frame lay far enough from the seed's own to tell something.
};

/// Steps 2a and 2b of Algorithm 1 [VH11] for one seed. Points are projected one by one through
/// world coordinates; the line's direction and the rate are central differences, the depth of the
/// match a bisection.
Match FindMatch(const Options& options, const Seed& seed, const Meeting& current);

/// Steps 2 to 4 for one seed: also fuses (FuseTextbook, in double) and judges.
Match UpdateSeed(const Options& options, const Meeting& current, Seed* seed);

/// Algorithm 1 as in its box, with a list of seeds; for short sequences of small pictures. Fills
/// the pool in raster order on every `seed_spacing_px`-th pixel with texture, whether or not there
/// is a point already.
class Algorithm1 {
 public:
  /// Rays are searched between the planar depths `near` and `far` [scene].
  Algorithm1(const Options& options, double near, double far);

  /// Runs one frame and returns how many points converged.
  std::size_t AddFrame(const PosedFrame& frame);

  const PointCloud& points() const { return points_; }
  const std::vector<Seed>& seeds() const { return seeds_; }
  /// Meetings of a seed with a frame, so far.
  std::int64_t updates() const { return updates_; }

 private:
  void Plant(const PosedFrame& frame);
  void Convert(const Seed& seed);

  Options options_;
  double near_;
  double far_;
  std::vector<Seed> seeds_;
  std::int64_t updates_ = 0;
  PointCloud points_;
};

/// The seed of the pixel (x, y), at least three pixels inside of the picture, searched between two
/// planar depths. Posterior as in Sec. 4.2.
Seed MakeSeed(
    const Options& options, const PosedFrame& frame, int x, int y, double near, double far);

}  // namespace livemvs::reference
