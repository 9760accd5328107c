#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

/// Bytes of one point in the stream.
inline constexpr std::size_t kPointBytes = 16;
/// Most points of one record.
inline constexpr std::size_t kMaxPointsPerRecord = 65536;

/// RecordType::kPoints and kPointsRefined.
struct PointsMessage {
  std::int64_t frame = 0;          ///< Index of the frame in which they converged.
  std::uint32_t first_id = 0;      ///< kPoints: the id of the first; the others follow.
  std::vector<std::uint32_t> ids;  ///< kPointsRefined: one for each point.
  PointCloud points;
};

/// The payload of a kPoints record. Points are quantised to 16 bytes: a position by 1/65535 of the
/// sides of the points' box, so that it moves by at most 1/131070 of them; a normal by half a
/// degree or so, 1 degree at most; sigma and footprint by 2.2 %; the inlier ratio by 1/510.
/// @param points  At most kMaxPointsPerRecord, all finite.
std::vector<std::uint8_t> EncodePoints(std::int64_t frame,
                                       std::uint32_t first_id,
                                       std::span<const Point> points);
/// The payload of a kPointsRefined record; `ids` are as many as points.
std::vector<std::uint8_t> EncodeRefinedPoints(std::int64_t frame,
                                              std::span<const std::uint32_t> ids,
                                              std::span<const Point> points);
/// The payload of a kPointsRemoved record.
std::vector<std::uint8_t> EncodeRemovedPoints(std::span<const std::uint32_t> ids);

/// Nothing where the payload is malformed.
std::optional<PointsMessage> DecodePoints(std::span<const std::uint8_t> payload);
std::optional<PointsMessage> DecodeRefinedPoints(std::span<const std::uint8_t> payload);
std::optional<std::vector<std::uint32_t>> DecodeRemovedPoints(
    std::span<const std::uint8_t> payload);

/// Sorts points into groups that fit one record each, small enough in space for the quantisation to
/// move none by more than an eighth of its group's least sigma along an axis, where it can be had
/// with groups of 64 points and more. Points that are not finite, or beyond 1e18, are left out.
std::vector<PointCloud> GroupForStream(std::span<const Point> points);

}  // namespace livemvs
