#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "livemvs/tracking/pose_source.h"

namespace livemvs::app {

/// What became of the frames of a recording.
class TrackReport {
 public:
  void Add(std::int64_t frame, double timestamp, const PoseEstimate& estimate, double milliseconds);

  std::int64_t frames() const { return static_cast<std::int64_t>(rows_.size()); }

  /// Why most frames without a pose have none.
  std::string commonest_problem() const;

  /// Tracked frames, error, gaps and time, on standard output.
  void Print() const;

  /// A row for each frame, comma-separated.
  void WriteTable(const std::filesystem::path& file) const;

 private:
  struct Row {
    std::int64_t frame;
    double timestamp;
    PoseEstimate estimate;
    double milliseconds;
  };
  std::vector<Row> rows_;
};

}  // namespace livemvs::app
