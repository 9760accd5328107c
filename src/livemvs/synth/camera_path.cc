#include "livemvs/synth/camera_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "livemvs/synth/random.h"

namespace livemvs {
namespace {

using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;

// A smooth random function of time [s], standard deviation 1: sines of a hand's frequencies.
double Unrest(std::uint64_t seed, int channel, double time) {
  constexpr std::array<double, 5> kHertz = {0.23, 0.61, 1.3, 2.4, 4.1};
  constexpr std::array<double, 5> kWeight = {1.0, 0.7, 0.3, 0.11, 0.045};
  synth::Random random(seed * 64 + channel);
  double sum = 0, power = 0;
  for (std::size_t i = 0; i < kHertz.size(); ++i) {
    const double hertz = kHertz[i] * random.Uniform(0.85, 1.15);
    const double phase = random.Uniform(0, 2 * std::numbers::pi);
    sum += kWeight[i] * std::sin(2 * std::numbers::pi * hertz * time + phase);
    power += kWeight[i] * kWeight[i] / 2;
  }
  return sum / std::sqrt(power);
}

Vector3d Unrest3(std::uint64_t seed, int channel, double time) {
  return {Unrest(seed, channel, time),
          Unrest(seed, channel + 1, time),
          Unrest(seed, channel + 2, time)};
}

// Adds the unrest of hands: of the place [m] and of the direction [rad].
Rigid3d HandHeld(const PathOptions& o,
                 double time,
                 const Vector3d& eye,
                 const Vector3d& target,
                 double place,
                 double angle) {
  const Vector3d moved = eye + o.wobble * place * Unrest3(o.seed, 0, time);
  const Vector3d turn = o.wobble * angle * Unrest3(o.seed, 3, time);
  Rigid3d pose = LookAt(moved, target);
  const double size = turn.norm();
  if (size > 0) {
    const Rigid3d shake{Eigen::AngleAxisd(size, turn / size).toRotationMatrix(), Vector3d::Zero()};
    pose = shake * pose;
  }
  return pose;
}

Rigid3d OrbitPose(const PathOptions& o, double frame) {
  const double part = o.frames > 1 ? frame / (o.frames - 1) : 0;
  const double time = frame / o.frames_per_second;
  // People do not turn evenly: some tenths of the speed come and go.
  const double uneven = o.wobble * 0.008 * Unrest(o.seed, 8, 0.6 * time);
  const double azimuth = (o.start_deg + o.arc_deg * (part + uneven)) * kRadians;
  const double radius = o.radius * (1 + 0.03 * o.wobble * Unrest(o.seed, 9, 0.5 * time));
  const Vector3d eye =
      o.target + Vector3d(radius * std::cos(azimuth), radius * std::sin(azimuth), o.height);
  return HandHeld(o, time, eye, o.target, 0.012 * o.radius, 0.008);
}

// A spiral from the rim to the top, with even area per view.
Rigid3d HemispherePose(const PathOptions& o, double frame) {
  const double z = 0.08 + 0.9 * (frame + 0.5) / o.frames;
  const double turns = std::sqrt(o.frames / 4.0);
  const double azimuth = o.start_deg * kRadians + 2 * std::numbers::pi * turns * frame / o.frames;
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  const Vector3d out(r * std::cos(azimuth), r * std::sin(azimuth), z);
  return LookAt(o.target + o.radius * out, o.target);
}

// Around the middle of the room on an ellipse, looking across it a little ahead.
Rigid3d WalkPose(const PathOptions& o, double frame) {
  const double part = o.frames > 1 ? frame / (o.frames - 1) : 0;
  const double time = frame / o.frames_per_second;
  const double azimuth = (o.start_deg + o.arc_deg * part) * kRadians;
  const double steps = 0.012 * o.wobble * std::sin(2 * std::numbers::pi * 1.8 * time);
  const Vector3d eye =
      o.target +
      Vector3d(o.radius * std::cos(azimuth), 0.7 * o.radius * std::sin(azimuth), o.height + steps);
  const double ahead = azimuth + 2.5;
  const Vector3d target = o.target + Vector3d(1.6 * std::cos(ahead), 1.3 * std::sin(ahead), -0.1);
  return HandHeld(o, time, eye, target, 0.03, 0.02);
}

}  // namespace

PathKind PathKindFromName(const std::string& name) {
  if (name == "orbit") return PathKind::kOrbit;
  if (name == "hemisphere") return PathKind::kHemisphere;
  if (name == "walk") return PathKind::kWalk;
  throw std::invalid_argument("path \"" + name +
                              "\": unknown; choose from orbit, hemisphere, walk");
}

void PathOptions::Check() const {
  if (frames < 1) throw std::invalid_argument("frames must be at least 1");
  if (!(frames_per_second > 0)) throw std::invalid_argument("frames_per_second must be positive");
  if (!(radius > 0)) throw std::invalid_argument("radius must be positive");
  if (!std::isfinite(height) || !std::isfinite(arc_deg) || !std::isfinite(start_deg) ||
      !std::isfinite(wobble) || !target.allFinite()) {
    throw std::invalid_argument("path: height, arc, start, wobble and target must be finite");
  }
}

PathOptions DefaultPath(const std::string& scene) {
  PathOptions path;
  if (scene == "relief") {
    path.kind = PathKind::kHemisphere;
    path.target = {0, 0, 0.1};
    path.radius = 0.6;
    path.frames = 312;
  } else if (scene == "house") {
    path.target = {0, 0, 0.08};
    path.radius = 0.6;
    path.height = 0.4;
    path.arc_deg = 360;
    path.frames = 600;
  } else if (scene == "room") {
    path.kind = PathKind::kWalk;
    path.target = {0, 0, 1.1};
    path.radius = 1.3;
    path.height = 0.35;
    path.arc_deg = 180;
    path.frames = 400;
  } else if (scene == "plane") {
    path.target = {0, 0, 0};
    path.radius = 0.5;
    path.height = 0.8;
    path.arc_deg = 40;
  } else if (scene == "bench") {
    path.radius = 0.6;
    path.height = 0.42;
    path.start_deg = -125;
    path.arc_deg = 80;
  }
  return path;
}

Rigid3d PoseAt(const PathOptions& options, double frame) {
  switch (options.kind) {
    case PathKind::kHemisphere:
      return HemispherePose(options, frame);
    case PathKind::kWalk:
      return WalkPose(options, frame);
    case PathKind::kOrbit:
      break;
  }
  return OrbitPose(options, frame);
}

std::vector<Rigid3d> MakePath(const PathOptions& options) {
  options.Check();
  std::vector<Rigid3d> poses;
  poses.reserve(options.frames);
  for (int i = 0; i < options.frames; ++i) poses.push_back(PoseAt(options, i));
  return poses;
}

Rigid3d LookAt(const Vector3d& eye, const Vector3d& target) {
  const Vector3d forward = (target - eye).normalized();
  const Vector3d up = std::abs(forward.z()) > 0.9999 ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d right = forward.cross(up).normalized();
  Rigid3d pose;
  pose.rotation.row(0) = right;
  pose.rotation.row(1) = forward.cross(right);
  pose.rotation.row(2) = forward;
  pose.translation = -(pose.rotation * eye);
  return pose;
}

}  // namespace livemvs
