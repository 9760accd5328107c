#include "viewer/stream_log.h"

#include <utility>

#include "livemvs/stream/messages.h"
#include "viewer/rules.h"

namespace livemvs::viewer {

SharedBytes MakeUnnumbered(RecordType type, std::span<const std::uint8_t> payload) {
  auto bytes = std::make_shared<std::vector<std::uint8_t>>();
  AppendRecord(type, kUnnumbered, payload, bytes.get());
  return bytes;
}

StreamLog::StreamLog() : session_(MakeToken().substr(0, 16)) {}

void StreamLog::Append(RecordType type, std::span<const std::uint8_t> payload) {
  auto bytes = std::make_shared<std::vector<std::uint8_t>>();
  {
    const std::scoped_lock lock(mutex_);
    AppendRecord(type, static_cast<std::uint32_t>(records_.size()), payload, bytes.get());
    bytes_ += bytes->size();
    records_.push_back(std::move(bytes));
    if (listener_) listener_();
  }
}

void StreamLog::SetPreview(std::span<const std::uint8_t> payload) {
  SharedBytes bytes = MakeUnnumbered(kRecordPreview, payload);
  {
    const std::scoped_lock lock(mutex_);
    preview_ = std::move(bytes);
    ++preview_version_;
    if (listener_) listener_();
  }
}

void StreamLog::SetLive(const std::string& json) {
  SharedBytes bytes = MakeUnnumbered(kRecordLive, EncodeStatistics(json));
  {
    const std::scoped_lock lock(mutex_);
    live_ = std::move(bytes);
    ++live_version_;
    if (listener_) listener_();
  }
}

std::vector<SharedBytes> StreamLog::Take(Cursor* cursor, std::size_t most_bytes) const {
  const std::scoped_lock lock(mutex_);
  std::vector<SharedBytes> taken;
  std::size_t bytes = 0;
  while (cursor->next < records_.size() && bytes < most_bytes) {
    taken.push_back(records_[cursor->next++]);
    bytes += taken.back()->size();
  }
  if (cursor->next < records_.size()) return taken;
  if (live_version_ != cursor->live) {
    cursor->live = live_version_;
    taken.push_back(live_);
  }
  // A reader that is behind gets no pictures.
  if (bytes == 0 && preview_version_ != cursor->preview) {
    cursor->preview = preview_version_;
    taken.push_back(preview_);
  }
  return taken;
}

std::uint32_t StreamLog::size() const {
  const std::scoped_lock lock(mutex_);
  return static_cast<std::uint32_t>(records_.size());
}

std::size_t StreamLog::bytes() const {
  const std::scoped_lock lock(mutex_);
  return bytes_;
}

void StreamLog::SetListener(std::function<void()> listener) {
  const std::scoped_lock lock(mutex_);
  listener_ = std::move(listener);
}

}  // namespace livemvs::viewer
