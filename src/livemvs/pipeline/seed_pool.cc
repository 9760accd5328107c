#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

std::int64_t SeedPool::Plant(std::int64_t frame_index, const Planting& planting) {
  const std::size_t before = alive_;
  const std::vector<std::size_t> planted = backend_->Plant(planting);
  for (std::size_t l = planted.size(); l-- > 0;) {
    if (planted[l] == 0) continue;
    const int level = static_cast<int>(l);
    references_.push_back({.begin = end_,
                           .end = end_ + planted[l],
                           .alive = planted[l],
                           .frame_index = frame_index,
                           .level = level,
                           .camera = AtLevel(planting.frame.camera, level),
                           .cam_from_world = planting.frame.cam_from_world,
                           .last_met_from = planting.frame.cam_from_world.Center()});
    end_ += planted[l];
    alive_ += planted[l];
  }
  return static_cast<std::int64_t>(alive_ - before);
}

std::vector<ReferenceFrame> SeedPool::Meet(const Rigid3d& cam_from_world,
                                           int levels,
                                           double min_move) {
  const Eigen::Vector3d here = cam_from_world.Center();
  std::vector<ReferenceFrame> met;
  met.reserve(references_.size());
  for (ReferenceFrame& reference : references_) {
    const double moved = (here - reference.last_met_from).norm();
    const double baseline = (here - reference.cam_from_world.Center()).norm();
    const bool due =
        min_move == 0 || moved > min_move * baseline || reference.left_out >= kMostLeftOut;
    if (!due || reference.level >= levels) {
      ++reference.left_out;
      continue;
    }
    reference.last_met_from = here;
    reference.left_out = 0;
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
