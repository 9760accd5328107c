#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livemvs {

/// Where a point's patch has its texture, as seen from the camera: Point::lean. A code of five
/// bits, which with the level fill a byte of the journal: 0 where it is not known, 1 ...
/// kLeanDirections for the direction, in steps of a turn, of a texture at one side, or
/// kLeanNowhere.
inline constexpr std::uint8_t kLeanUnknown = 0;
inline constexpr std::uint8_t kLeanDirections = 30;
inline constexpr std::uint8_t kLeanNowhere = 31;  ///< The texture lies all around the middle.

/// A texture is at one side where its centroid is further than this from the middle of its patch
/// [px]. Of five pixels' width; what it is exactly hardly matters, between 0.2 and 0.4.
inline constexpr float kCentredPx = 0.3F;

constexpr bool Leans(std::uint8_t code) { return code >= 1 && code <= kLeanDirections; }

/// The code of a direction, of any length; kLeanNowhere where it has no part across the line of
/// sight.
/// @param towards_camera  Unit; must be the same for decoding.
std::uint8_t LeanCode(const Eigen::Vector3f& towards_camera, const Eigen::Vector3f& direction);

/// The unit vector across the line of sight that a code for which Leans() stands for: within half a
/// step, 6 degrees, of the direction.
Eigen::Vector3f LeanDirection(const Eigen::Vector3f& towards_camera, std::uint8_t code);

}  // namespace livemvs
