#include "plane_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "livemvs/core/options.h"

namespace livemvs::testing_support {
namespace {

// A sum of waves in random directions, 5 to 20 pixels long at the plane's distance.
class Waves {
 public:
  explicit Waves(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> angle(0, 2 * M_PI),
        log_length(std::log(5.0), std::log(20.0));
    for (Wave& w : waves_) {
      const double direction = angle(random);
      const double frequency = 2 * M_PI * 190 / std::exp(log_length(random));
      w = {frequency * std::cos(direction), frequency * std::sin(direction), angle(random)};
    }
  }

  // Mean 0, standard deviation 1.
  double operator()(double x, double y) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += std::cos(w.fx * x + w.fy * y + w.phase);
    return sum / std::sqrt(kWaves / 2.0);
  }

 private:
  static constexpr int kWaves = 14;
  struct Wave {
    double fx, fy, phase;
  };
  Wave waves_[kWaves];
};

}  // namespace

PosedFrame PlaneScene::Render(const Rigid3d& cam_from_world, std::int64_t index) const {
  const Waves waves(seed);
  std::mt19937 random(seed * 1000 + static_cast<unsigned>(index));
  std::normal_distribution<double> gauss;
  const Projector projector(camera);
  const Rigid3d world_from_cam = cam_from_world.Inverse();
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(camera.width, camera.height);
  picture->full_range = true;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = projector.Unproject({x, y});
      if (!ray) continue;
      // HeightAbove(center + s direction) = 0.
      const Eigen::Vector3d center = world_from_cam.translation;
      const Eigen::Vector3d direction = world_from_cam.rotation * *ray;
      const double slope = direction.z() - 0.3 * direction.x() - 0.2 * direction.y();
      const double s = -HeightAbove(center) / slope;
      if (!(s > 0)) continue;
      const Eigen::Vector3d p = center + s * direction;
      const double texture = p.x() < plain_left ? 0 : contrast * waves(p.x(), p.y());
      const double grey = 128 + texture + noise * gauss(random);
      picture->grey(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
    }
  }
  PosedFrame frame;
  frame.index = index;
  frame.name = "frame " + std::to_string(index);
  frame.picture = std::move(picture);
  frame.camera = camera;
  frame.cam_from_world = cam_from_world;
  return frame;
}

std::vector<PosedFrame> PlaneScene::Render(const std::vector<Rigid3d>& cam_from_world) const {
  std::vector<PosedFrame> frames;
  for (const Rigid3d& pose : cam_from_world) {
    frames.push_back(Render(pose, static_cast<std::int64_t>(frames.size())));
  }
  return frames;
}

std::vector<Rigid3d> SidewaysPath(int frames, double step) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < frames; ++i) {
    const Eigen::Vector3d center(step * i, 0.3 * step * std::sin(0.5 * i), 0.2 * step * i);
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(0.3 * step * i, Eigen::Vector3d(0.2, -1, 0.3).normalized())
            .toRotationMatrix();
    poses.push_back({rotation, -(rotation * center)});
  }
  return poses;
}

Options TestOptions() {
  Options o;
  o.max_seeds = 4000;
  o.levels = 1;
  o.min_move = 0.04F;
  o.seed_spacing_px = 2;
  o.cover_radius_px = 1;
  o.cover_angle_deg = 50;
  o.min_patch_stddev = 5;
  o.max_texture_offset_px = 1.3F;
  o.prior_a = 10;
  o.prior_b = 10;
  o.coordinate = DepthCoordinate::kInverseDepth;
  o.search = Search::kWindow;
  o.search_radius_px = 3;
  o.search_sigmas = 2.5F;
  o.search_radius_max_px = 8;
  o.min_ncc = 0.5F;
  o.epipolar_error_px = 0.2F;
  o.ambiguity_ncc = 0.05F;
  o.min_parallax_px = 1;
  o.warp_roll_deg = 0;
  o.warp_scale = 0;
  o.measurement_sigma_px = 0.5F;
  o.image_noise = 2;
  o.match_bias_px = 0.15F;
  o.max_measurement_sigma_px = 1.5F;
  o.outlier_density = OutlierDensity::kWindow;
  o.eta_outlier = 0.05F;
  o.outlier_certainty = 0.99F;
  o.eta_inlier = 0.6F;
  o.epsilon_range = 0;
  o.epsilon_px = 1;
  o.min_views = 4;
  o.min_side_ncc = 0.3F;
  o.max_age = 150;
  o.max_unseen = 15;
  o.threads = 1;
  return o;
}

}  // namespace livemvs::testing_support
