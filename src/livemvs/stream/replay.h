#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/stream/journal.h"
#include "livemvs/stream/messages.h"
#include "livemvs/stream/point_codec.h"

namespace livemvs {

/// What a stream says when all its records are taken together: the state of the scan at its end.
class Replay {
 public:
  /// Takes one more record. One whose payload is malformed is counted and passed over.
  void Apply(const Record& record);

  const std::vector<SessionMessage>& sessions() const { return sessions_; }
  const std::optional<Camera>& camera() const { return camera_; }
  const std::optional<SceneMessage>& scene() const { return scene_; }
  const std::vector<FrameMessage>& frames() const { return frames_; }
  /// The latest statistics: an object in JSON, or empty.
  const std::string& statistics() const { return statistics_; }
  /// Of the latest session; nothing: it was cut off.
  const std::optional<EndMessage>& end() const { return end_; }

  /// The points that were not removed, in the order of their ids.
  PointCloud Points() const;
  /// The id for the next new point.
  std::uint32_t next_id() const { return static_cast<std::uint32_t>(points_.size()); }
  std::int64_t malformed() const { return malformed_; }

 private:
  bool TryApply(const Record& record);
  bool AddPoints(const Record& record);
  bool RefinePoints(const Record& record);
  bool RemovePoints(const Record& record);

  std::vector<SessionMessage> sessions_;
  std::optional<Camera> camera_;
  std::optional<SceneMessage> scene_;
  std::vector<FrameMessage> frames_;
  std::string statistics_;
  std::optional<EndMessage> end_;
  PointCloud points_;  ///< By id.
  std::vector<char> removed_;
  std::int64_t malformed_ = 0;
};

/// A journal, read as far as it is whole.
struct JournalContents {
  Replay replay;
  std::int64_t valid_bytes = 0;
  std::uint32_t next_sequence = 0;
  JournalReader::Tail tail = JournalReader::Tail::kClean;
};

/// @throws Error (kBadInput) naming the file, where it is missing, is no journal, holds no whole
/// session, or is of another version.
JournalContents ReadJournal(const std::filesystem::path& path);

}  // namespace livemvs
