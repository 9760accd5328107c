#include "livemvs/pipeline/seed_pool.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livemvs {
namespace {

// The angle between two rotations [radians].
double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return 2 * std::asin(std::min(1.0, (a - b).norm() / (2 * std::numbers::sqrt2)));
}

}  // namespace

std::int64_t SeedPool::Plant(std::int64_t frame_index, const Planting& planting) {
  const std::size_t before = alive_;
  const std::vector<std::size_t> planted = backend_->Plant(planting);
  for (std::size_t l = planted.size(); l-- > 0;) {
    if (planted[l] == 0) continue;
    const int level = static_cast<int>(l);
    references_.push_back({end_,
                           end_ + planted[l],
                           planted[l],
                           frame_index,
                           level,
                           AtLevel(planting.frame.camera, level),
                           planting.frame.cam_from_world,
                           planting.frame.cam_from_world});
    end_ += planted[l];
    alive_ += planted[l];
  }
  return static_cast<std::int64_t>(alive_ - before);
}

std::vector<ReferenceFrame> SeedPool::Meet(const Rigid3d& cam_from_world, double min_move) {
  const Eigen::Vector3d here = cam_from_world.Center();
  std::vector<ReferenceFrame> met;
  met.reserve(references_.size());
  for (ReferenceFrame& reference : references_) {
    const double moved = (here - reference.last_met.Center()).norm();
    const double baseline = (here - reference.cam_from_world.Center()).norm();
    const double turn = AngleBetween(cam_from_world.rotation, reference.last_met.rotation);
    if (min_move > 0 && moved <= min_move * baseline && turn <= min_move) continue;
    reference.last_met = cam_from_world;
    met.push_back(reference);
  }
  return met;
}

void SeedPool::Compact() {
  if (alive_ == end_) return;
  backend_->Compact();
  end_ = 0;
  for (ReferenceFrame& reference : references_) {
    reference.begin = end_;
    reference.end = end_ += reference.alive;
  }
  std::erase_if(references_, [](const ReferenceFrame& reference) { return reference.alive == 0; });
}

}  // namespace livemvs
