#include "run_view.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "interrupt.h"

namespace livemvs::app {

RunView::RunView(const Settings& settings,
                 const Options& options,
                 const SceneRange& range,
                 const std::string& source)
    : speed_(settings.speed) {
  if (!settings.view.view) return;
  viewer::FeedOptions feed;
  feed.engine = options;
  view_ = std::make_unique<LiveView>(settings.view, settings.title, feed);
  SessionMessage session;
  session.json = nlohmann::json({{"program", "livemvs run"}, {"source", source}})
                     .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  view_->feed().Begin(session, SceneMessage{range.box, range.near, range.far, range.origin});
}

bool RunView::Show(const PosedFrame& frame,
                   std::span<const Point> converged,
                   std::int64_t frame_count,
                   const Reconstructor& reconstructor) {
  if (speed_ > 0) Pace(frame.timestamp);
  if (!view_) return true;
  viewer::LiveCounts counts;
  counts.frames = reconstructor.statistics().frames;
  counts.frames_total = frame_count;
  counts.seeds = static_cast<std::int64_t>(reconstructor.live_seeds());
  counts.points = static_cast<std::int64_t>(reconstructor.points().size());
  view_->feed().AddFrame(frame, converged, counts, &reconstructor.pool());
  StandWhilePaused();
  return !view_->finish_asked();
}

void RunView::Close(std::int64_t frames, std::int64_t points, const std::exception_ptr& failure) {
  if (!view_) return;
  EndMessage end;
  end.frames = frames;
  end.points = points;
  if (Interrupted()) end.reason = EndMessage::kInterrupted;
  if (failure) {
    end.reason = EndMessage::kFailed;
    try {
      std::rethrow_exception(failure);
    } catch (const std::exception& e) {
      end.text = e.what();
    }
  }
  view_->feed().End(end);
  if (!failure) view_->Linger(Interrupted);
}

// Waits until the frame's time has come.
void RunView::Pace(double timestamp) {
  if (!first_time_) first_time_ = timestamp;
  const auto offset = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>((timestamp - *first_time_) / speed_));
  const auto wanted = [&] { return !Interrupted() && !(view_ && view_->finish_asked()); };
  while (Clock::now() < start_ + offset && wanted()) {
    const auto next_look = Clock::now() + std::chrono::milliseconds(50);
    std::this_thread::sleep_until(std::min(start_ + offset, next_look));
    StandWhilePaused();
  }
}

// Waits while the page says pause, and the recording stands still, too.
void RunView::StandWhilePaused() {
  if (!view_) return;
  const auto reached = Clock::now();
  view_->WaitWhilePaused(Interrupted);
  start_ += Clock::now() - reached;
}

}  // namespace livemvs::app
