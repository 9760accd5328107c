#include "scan_view.h"

#include <chrono>
#include <optional>
#include <thread>

#include "interrupt.h"
#include "scan_results.h"

namespace livemvs::app {

// How long a page has to hear of a failure, after which the program ends.
constexpr auto kLastWords = std::chrono::milliseconds(300);

ScanView::ScanView(const ScanArguments& args, const ScanFolder& folder, const ScanInput& input) {
  if (!args.view.view) return;
  counts_.frames_total = input.expected;
  live_ = input.live;
  viewer::FeedOptions feed;
  feed.engine = input.settings.method;
  feed.records = false;
  view_ = std::make_unique<LiveView>(args.view, folder.path.filename().string(), feed);
  if (!folder.before) return;
  JournalReader journal(folder.path / kJournalName);
  while (const std::optional<Record> record = journal.Next()) {
    view_->log().Append(record->type, record->payload);
  }
}

void ScanView::Join(const std::vector<std::uint8_t>& session, Scan* scan, Scan::Watch* watch) {
  if (view_ == nullptr) return;
  view_->log().Append(RecordType::kSession, session);
  scan->AddSink(&view_->log());
  watch->seen = [this](const PosedFrame& frame,
                       std::span<const Point> converged,
                       const Reconstructor& reconstructor) {
    ShowFrame(frame, converged, reconstructor);
  };
  watch->missed = [this](const SourceFrame& frame) {
    view_->feed().AddPicture(frame.index, frame.picture);
    view_->WaitWhilePaused(Interrupted);
  };
  // A camera waits at its first picture, which shows where it looks; a recording before it, so that
  // none of it is missed.
  if (!live_) view_->WaitWhilePaused(Interrupted);
}

void ScanView::ShowFrame(const PosedFrame& frame,
                         std::span<const Point> converged,
                         const Reconstructor& reconstructor) {
  ++counts_.frames;
  counts_.seeds = static_cast<std::int64_t>(reconstructor.live_seeds());
  counts_.points = static_cast<std::int64_t>(reconstructor.points().size());
  counts_.problem.clear();
  view_->feed().AddFrame(frame, converged, counts_, &reconstructor.pool());
  view_->WaitWhilePaused(Interrupted);
}

void ScanView::ShowProgress(const ScanProgress& progress) {
  if (view_ == nullptr) return;
  counts_.frames = progress.frames;
  counts_.frames_dropped = progress.dropped;
  counts_.seeds = progress.live_seeds;
  counts_.points = progress.points;
  counts_.problem = progress.problem;
  view_->feed().SetCounts(counts_);
}

void ScanView::End(const ScanResult& result) {
  if (view_ == nullptr) return;
  view_->feed().End({});
  if (result.failure != nullptr) std::this_thread::sleep_for(kLastWords);
}

void ScanView::Linger() {
  if (view_ != nullptr) view_->Linger(Interrupted);
}

}  // namespace livemvs::app
