#include "livemvs/tracking/motion.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace livemvs {

void Motion::Add(double time, const Rigid3d& cam_from_world) {
  before_ = last_;
  last_ = Known{time, cam_from_world};
}

std::optional<Rigid3d> Motion::Last(double time, double max_gap) const {
  if (!last_ || !(time >= last_->time) || time - last_->time > max_gap) return std::nullopt;
  return last_->pose;
}

std::optional<Rigid3d> Motion::Predict(double time, double max_gap) const {
  if (!Last(time, max_gap)) return std::nullopt;
  if (!before_ || !(last_->time > before_->time) || last_->time - before_->time > max_gap) {
    return last_->pose;
  }
  // Further ahead than twice the step that is known, the motion is anybody's guess.
  const double ahead = std::min(2.0, (time - last_->time) / (last_->time - before_->time));
  const Rigid3d step = last_->pose * before_->pose.Inverse();
  const Eigen::AngleAxisd turn(step.rotation);
  const Rigid3d part{Eigen::AngleAxisd(ahead * turn.angle(), turn.axis()).toRotationMatrix(),
                     ahead * step.translation};
  return part * last_->pose;
}

}  // namespace livemvs
