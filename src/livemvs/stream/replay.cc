#include "livemvs/stream/replay.h"

#include <algorithm>
#include <string>
#include <utility>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

template <typename T, typename Store>
bool Take(std::optional<T> decoded, Store store) {
  if (!decoded) return false;
  store(*std::move(decoded));
  return true;
}

}  // namespace

void Replay::Apply(const Record& record) {
  if (!TryApply(record)) ++malformed_;
}

bool Replay::TryApply(const Record& record) {
  switch (record.type) {
    case RecordType::kSession:
      return Take(DecodeSession(record.payload), [this](SessionMessage m) {
        sessions_.push_back(std::move(m));
        end_.reset();
      });
    case RecordType::kCamera:
      return Take(DecodeCamera(record.payload), [this](Camera m) { camera_ = m; });
    case RecordType::kScene:
      return Take(DecodeScene(record.payload), [this](SceneMessage m) { scene_ = std::move(m); });
    case RecordType::kFrame:
      return Take(DecodeFrame(record.payload), [this](FrameMessage m) { frames_.push_back(m); });
    case RecordType::kPoints:
      return AddPoints(record);
    case RecordType::kPointsRefined:
      return RefinePoints(record);
    case RecordType::kPointsRemoved:
      return RemovePoints(record);
    case RecordType::kStatistics:
      return Take(DecodeStatistics(record.payload),
                  [this](std::string m) { statistics_ = std::move(m); });
    case RecordType::kMessage:
      return DecodeText(record.payload).has_value();
    case RecordType::kEnd:
      return Take(DecodeEnd(record.payload), [this](EndMessage m) { end_ = std::move(m); });
  }
  return true;  // of a later version
}

bool Replay::AddPoints(const Record& record) {
  const std::optional<PointsMessage> message = DecodePoints(record.payload);
  // Ids without gaps are what bounds the memory by the size of the stream.
  if (!message || message->first_id != points_.size()) return false;
  points_.insert(points_.end(), message->points.begin(), message->points.end());
  removed_.resize(points_.size(), 0);
  return true;
}

bool Replay::RefinePoints(const Record& record) {
  const std::optional<PointsMessage> message = DecodeRefinedPoints(record.payload);
  if (!message) return false;
  for (std::size_t i = 0; i < message->ids.size(); ++i) {
    if (message->ids[i] >= points_.size()) return false;
    points_[message->ids[i]] = message->points[i];
  }
  return true;
}

bool Replay::RemovePoints(const Record& record) {
  const auto ids = DecodeRemovedPoints(record.payload);
  if (!ids) return false;
  for (const std::uint32_t id : *ids) {
    if (id >= points_.size()) return false;
    removed_[id] = 1;
  }
  return true;
}

PointCloud Replay::Points() const {
  PointCloud cloud;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (removed_[i] == 0) cloud.push_back(points_[i]);
  }
  return cloud;
}

JournalContents ReadJournal(const std::filesystem::path& path) {
  JournalReader reader(path);
  JournalContents contents;
  while (const std::optional<Record> record = reader.Next()) {
    contents.replay.Apply(*record);
    const auto& sessions = contents.replay.sessions();
    if (sessions.empty()) break;
    if (sessions.back().version != kStreamVersion) {
      throw BadInput(path.string() + ": its format is version " +
                     std::to_string(sessions.back().version) + ", this program reads version " +
                     std::to_string(kStreamVersion) + "; use the program that wrote it");
    }
  }
  if (contents.replay.sessions().empty()) {
    throw BadInput(path.string() +
                   ": holds no whole record of a scan's beginning; start the scan anew");
  }
  contents.valid_bytes = reader.valid_bytes();
  contents.next_sequence = reader.next_sequence();
  contents.tail = reader.tail();
  return contents;
}

}  // namespace livemvs
