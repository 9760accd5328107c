#include "livemvs/pipeline/seed_pool.h"

#include <cassert>

namespace livemvs {

void SeedPool::BeginReference(std::int64_t frame_index,
                              int level,
                              const Camera& camera,
                              const Rigid3d& cam_from_world) {
  references_.push_back({end_, end_, 0, frame_index, level, camera, cam_from_world});
}

void SeedPool::Add(const NewSeed& seed) {
  assert(end_ < capacity() && !references_.empty());
  born_.push_back(seed);
  references_.back().end = ++end_;
  ++references_.back().alive;
  ++alive_;
}

void SeedPool::EndReference(const Posterior<float>& prior) {
  if (born_.empty()) {
    references_.pop_back();
    return;
  }
  backend_->Append(born_, prior);
  born_.clear();
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
