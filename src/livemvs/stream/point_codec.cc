#include "livemvs/stream/point_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "livemvs/core/lean.h"
#include "livemvs/stream/bytes.h"

namespace livemvs {
namespace {

constexpr float kSteps = 65535;
constexpr float kNormalSteps = 127;
/// Lengths are scale * 2^(-q / kPerOctave); the last code is zero.
constexpr float kPerOctave = 16;
constexpr int kZeroLength = 255;
constexpr int kLeanCodes = 32;
static_assert(kLeanNowhere == kLeanCodes - 1, "the lean fills five bits of the format");
constexpr std::size_t kSmallestGroup = 64;
constexpr float kMaxCoordinate = 1e18F;

struct Frame {
  Eigen::Array3f min = Eigen::Array3f::Zero();
  Eigen::Array3f extent = Eigen::Array3f::Zero();
  float sigma_scale = 0;
  float footprint_scale = 0;
};

Frame FrameOf(std::span<const Point> points) {
  Frame frame;
  if (points.empty()) return frame;
  Eigen::Array3f max = points[0].position.array();
  frame.min = max;
  for (const Point& p : points) {
    frame.min = frame.min.min(p.position.array());
    max = max.max(p.position.array());
    frame.sigma_scale = std::max(frame.sigma_scale, p.sigma);
    frame.footprint_scale = std::max(frame.footprint_scale, p.footprint);
  }
  frame.extent = max - frame.min;
  return frame;
}

std::uint8_t LengthCode(float length, float scale) {
  if (!(length > 0 && scale > 0)) return kZeroLength;
  const float q = std::round(-kPerOctave * std::log2(length / scale));
  return static_cast<std::uint8_t>(std::clamp(q, 0.0F, kZeroLength - 1.0F));
}

float LengthOf(std::uint8_t code, float scale) {
  return code == kZeroLength ? 0 : scale * std::exp2(-static_cast<float>(code) / kPerOctave);
}

// The unit sphere on a square: the octahedron |x| + |y| + |z| = 1, its lower half folded out.
std::array<std::int8_t, 2> NormalCode(const Eigen::Vector3f& normal) {
  const float sum = normal.lpNorm<1>();
  if (!(sum > 0)) return {-128, -128};
  float u = normal.x() / sum, v = normal.y() / sum;
  if (normal.z() < 0) {
    const float folded_u = (1 - std::abs(v)) * (u >= 0 ? 1.0F : -1.0F);
    v = (1 - std::abs(u)) * (v >= 0 ? 1.0F : -1.0F);
    u = folded_u;
  }
  const auto code = [](float x) { return static_cast<std::int8_t>(std::round(x * kNormalSteps)); };
  return {code(u), code(v)};
}

Eigen::Vector3f NormalOf(std::int8_t code_u, std::int8_t code_v) {
  if (code_u == -128 || code_v == -128) return Eigen::Vector3f::Zero();
  float u = static_cast<float>(code_u) / kNormalSteps;
  float v = static_cast<float>(code_v) / kNormalSteps;
  const float z = 1 - std::abs(u) - std::abs(v);
  if (z < 0) {
    const float unfolded_u = (1 - std::abs(v)) * (u >= 0 ? 1.0F : -1.0F);
    v = (1 - std::abs(u)) * (v >= 0 ? 1.0F : -1.0F);
    u = unfolded_u;
  }
  return Eigen::Vector3f(u, v, z).normalized();
}

// The level, and where the texture lies: what overhangs is looked for when a scan is finished,
// which may be a later run. The direction is put as the reader will take it, from the coded normal.
std::uint8_t SideCode(const Point& p, const Eigen::Vector3f& coded_normal) {
  const int level = std::min<int>(p.level, 256 / kLeanCodes - 1);
  std::uint8_t lean = std::min(p.lean, kLeanNowhere);
  if (Leans(lean)) lean = LeanCode(coded_normal, LeanDirection(p.normal, lean));
  return static_cast<std::uint8_t>(level * kLeanCodes + lean);
}

void PutPoints(std::span<const Point> points, ByteWriter* out) {
  const Frame frame = FrameOf(points);
  for (int i = 0; i < 3; ++i) out->Put(frame.min[i]);
  for (int i = 0; i < 3; ++i) out->Put(frame.extent[i]);
  out->Put(frame.sigma_scale);
  out->Put(frame.footprint_scale);
  for (const Point& p : points) {
    for (int i = 0; i < 3; ++i) {
      const float share =
          frame.extent[i] > 0 ? (p.position[i] - frame.min[i]) / frame.extent[i] : 0;
      out->Put(static_cast<std::uint16_t>(std::clamp(std::round(share * kSteps), 0.0F, kSteps)));
    }
    const std::array<std::int8_t, 2> normal = NormalCode(p.normal);
    for (const std::int8_t code : normal) out->Put(code);
    for (const std::uint8_t c : p.color) out->Put(c);
    out->Put(static_cast<std::uint8_t>(std::lround(std::clamp(p.inlier_ratio, 0.0F, 1.0F) * 255)));
    out->Put(LengthCode(p.sigma, frame.sigma_scale));
    out->Put(LengthCode(p.footprint, frame.footprint_scale));
    out->Put(static_cast<std::uint8_t>(std::min<int>(p.views, 255)));
    out->Put(SideCode(p, NormalOf(normal[0], normal[1])));
  }
}

bool IsSane(const Frame& frame) {
  const auto in_reach = [](float v) { return std::abs(v) <= 4 * kMaxCoordinate; };  // false for NaN
  for (int i = 0; i < 3; ++i) {
    if (!in_reach(frame.min[i]) || !in_reach(frame.extent[i]) || frame.extent[i] < 0) return false;
  }
  return in_reach(frame.sigma_scale) && in_reach(frame.footprint_scale) && frame.sigma_scale >= 0 &&
         frame.footprint_scale >= 0;
}

Point GetPoint(const Frame& frame, ByteReader* in) {
  Point p;
  for (int i = 0; i < 3; ++i) {
    const float share = static_cast<float>(in->Get<std::uint16_t>()) / kSteps;
    p.position[i] = frame.min[i] + share * frame.extent[i];
  }
  const auto u = in->Get<std::int8_t>();
  const auto v = in->Get<std::int8_t>();
  p.normal = NormalOf(u, v);
  for (std::uint8_t& c : p.color) c = in->Get<std::uint8_t>();
  p.inlier_ratio = static_cast<float>(in->Get<std::uint8_t>()) / 255;
  p.sigma = LengthOf(in->Get<std::uint8_t>(), frame.sigma_scale);
  p.footprint = LengthOf(in->Get<std::uint8_t>(), frame.footprint_scale);
  p.views = in->Get<std::uint8_t>();
  const auto side = in->Get<std::uint8_t>();
  p.level = static_cast<std::uint8_t>(side / kLeanCodes);
  p.lean = static_cast<std::uint8_t>(side % kLeanCodes);
  return p;
}

bool GetPoints(std::size_t count, std::int64_t frame_index, ByteReader* in, PointCloud* points) {
  Frame frame;
  for (int i = 0; i < 3; ++i) frame.min[i] = in->Get<float>();
  for (int i = 0; i < 3; ++i) frame.extent[i] = in->Get<float>();
  frame.sigma_scale = in->Get<float>();
  frame.footprint_scale = in->Get<float>();
  if (!in->ok() || !IsSane(frame) || in->left() < count * kPointBytes) return false;
  points->reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    points->push_back(GetPoint(frame, in));
    points->back().frame = FrameNumber(frame_index);
  }
  return true;
}

void CheckCount(std::size_t points) {
  if (points > kMaxPointsPerRecord) {
    throw std::invalid_argument(std::to_string(points) + " points do not fit one record");
  }
}

// Whether points of this box may share a record.
bool IsFine(std::span<const Point> points) {
  if (points.size() > kMaxPointsPerRecord) return false;
  if (points.size() < 2 * kSmallestGroup) return true;
  float least_sigma = std::numeric_limits<float>::infinity();
  for (const Point& p : points) {
    if (p.sigma > 0) least_sigma = std::min(least_sigma, p.sigma);
  }
  const float step = FrameOf(points).extent.maxCoeff() / kSteps;
  return step <= least_sigma / 4;
}

void Split(std::span<Point> points, std::vector<PointCloud>* groups) {
  if (IsFine(points)) {
    if (!points.empty()) groups->emplace_back(points.begin(), points.end());
    return;
  }
  Eigen::Index axis = 0;
  FrameOf(points).extent.maxCoeff(&axis);
  const std::size_t half = points.size() / 2;
  std::nth_element(
      points.begin(),
      points.begin() + static_cast<std::ptrdiff_t>(half),
      points.end(),
      [axis](const Point& a, const Point& b) { return a.position[axis] < b.position[axis]; });
  Split(points.first(half), groups);
  Split(points.subspan(half), groups);
}

}  // namespace

Bytes EncodePoints(std::int64_t frame, std::uint32_t first_id, std::span<const Point> points) {
  CheckCount(points.size());
  Bytes bytes;
  bytes.reserve(48 + points.size() * kPointBytes);
  ByteWriter out(&bytes);
  out.Put(frame);
  out.Put(static_cast<std::uint32_t>(points.size()));
  out.Put(first_id);
  PutPoints(points, &out);
  return bytes;
}

std::optional<PointsMessage> DecodePoints(ByteSpan payload) {
  ByteReader in(payload);
  PointsMessage message;
  message.frame = in.Get<std::int64_t>();
  const auto count = in.Get<std::uint32_t>();
  message.first_id = in.Get<std::uint32_t>();
  constexpr auto kMaxId = std::numeric_limits<std::uint32_t>::max();
  if (!in.ok() || message.frame < 0 || count > kMaxPointsPerRecord ||
      message.first_id > kMaxId - count || !GetPoints(count, message.frame, &in, &message.points)) {
    return std::nullopt;
  }
  return message;
}

Bytes EncodeRefinedPoints(std::int64_t frame,
                          std::span<const std::uint32_t> ids,
                          std::span<const Point> points) {
  CheckCount(points.size());
  if (ids.size() != points.size()) throw std::invalid_argument("as many ids as points are needed");
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(frame);
  out.Put(static_cast<std::uint32_t>(points.size()));
  out.Put(std::uint32_t{0});
  PutPoints(points, &out);
  for (const std::uint32_t id : ids) out.Put(id);
  return bytes;
}

std::optional<PointsMessage> DecodeRefinedPoints(ByteSpan payload) {
  ByteReader in(payload);
  PointsMessage message;
  message.frame = in.Get<std::int64_t>();
  const auto count = in.Get<std::uint32_t>();
  in.Get<std::uint32_t>();
  if (!in.ok() || message.frame < 0 || count > kMaxPointsPerRecord ||
      !GetPoints(count, message.frame, &in, &message.points)) {
    return std::nullopt;
  }
  for (std::uint32_t i = 0; i < count; ++i) message.ids.push_back(in.Get<std::uint32_t>());
  if (!in.ok()) return std::nullopt;
  return message;
}

Bytes EncodeRemovedPoints(std::span<const std::uint32_t> ids) {
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(static_cast<std::uint32_t>(ids.size()));
  for (const std::uint32_t id : ids) out.Put(id);
  return bytes;
}

std::optional<std::vector<std::uint32_t>> DecodeRemovedPoints(ByteSpan payload) {
  ByteReader in(payload);
  const std::size_t count = in.Get<std::uint32_t>();
  if (!in.ok() || in.left() < count * sizeof(std::uint32_t)) return std::nullopt;
  std::vector<std::uint32_t> ids(count);
  for (std::uint32_t& id : ids) id = in.Get<std::uint32_t>();
  return ids;
}

std::vector<PointCloud> GroupForStream(std::span<const Point> points) {
  PointCloud sane;
  sane.reserve(points.size());
  for (const Point& p : points) {
    // False for NaN.
    if ((p.position.array().abs() <= kMaxCoordinate).all() && p.normal.allFinite() &&
        p.sigma <= kMaxCoordinate && p.footprint <= kMaxCoordinate &&
        std::isfinite(p.inlier_ratio)) {
      sane.push_back(p);
    }
  }
  std::vector<PointCloud> groups;
  Split(sane, &groups);
  return groups;
}

}  // namespace livemvs
