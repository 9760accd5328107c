#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

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
                           planting.frame.cam_from_world});
    end_ += planted[l];
    alive_ += planted[l];
  }
  return static_cast<std::int64_t>(alive_ - before);
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
