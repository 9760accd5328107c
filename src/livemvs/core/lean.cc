#include "livemvs/core/lean.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace livemvs {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

// Two unit vectors across n, at right angles: the z axis, or -z, turned to n takes x and y along.
struct Across {
  explicit Across(const Eigen::Vector3f& n) {
    const float sign = std::copysign(1.0F, n.z());
    const float a = -1 / (sign + n.z()), b = a * n.x() * n.y();
    first = {1 + sign * a * n.x() * n.x(), sign * b, -sign * n.x()};
    second = {b, sign + a * n.y() * n.y(), -n.y()};
  }
  Eigen::Vector3f first, second;
};

}  // namespace

std::uint8_t LeanCode(const Eigen::Vector3f& towards_camera, const Eigen::Vector3f& direction) {
  const Across across(towards_camera);
  const float x = across.first.dot(direction), y = across.second.dot(direction);
  if (!(x * x + y * y > 0) || !std::isfinite(x) || !std::isfinite(y)) return kLeanNowhere;
  const float turns = std::atan2(y, x) / kTurn;
  const int step = static_cast<int>(std::lround(turns * kLeanDirections));
  return static_cast<std::uint8_t>((step + kLeanDirections) % kLeanDirections + 1);
}

Eigen::Vector3f LeanDirection(const Eigen::Vector3f& towards_camera, std::uint8_t code) {
  assert(Leans(code));
  const Across across(towards_camera);
  const float angle = kTurn * static_cast<float>(code - 1) / kLeanDirections;
  return std::cos(angle) * across.first + std::sin(angle) * across.second;
}

}  // namespace livemvs
