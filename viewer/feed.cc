#include "viewer/feed.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "livemvs/stream/bytes.h"
#include "livemvs/stream/point_codec.h"

namespace livemvs::viewer {
namespace {

// Points that are marked on the picture after they converged.
constexpr std::size_t kRecentPoints = 800;

// Frames whose time a page is told at once.
constexpr std::size_t kMostHanded = 16;

// A refined point is sent again each time its observations have doubled.
bool WorthSending(const MapUpdate& update) {
  return update.change == MapChange::kReplaced ||
         (update.change == MapChange::kRefined && std::has_single_bit(update.entry.observations));
}

double UnixTime() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

bool SameCamera(const Camera& a, const Camera& b) {
  return a.model == b.model && a.width == b.width && a.height == b.height && a.fx == b.fx &&
         a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.distortion == b.distortion;
}

}  // namespace

Feed::Feed(StreamLog* log, const FeedOptions& options)
    : log_(log), options_(options), map_(options.map), encoder_(options.preview_width) {
  thread_ = std::thread([this] { Run(); });
}

Feed::~Feed() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void Feed::Begin(const SessionMessage& session, const std::optional<SceneMessage>& scene) {
  log_->Append(RecordType::kSession, Encode(session));
  if (scene) log_->Append(RecordType::kScene, Encode(*scene));
}

void Feed::AddFrame(const PosedFrame& frame,
                    std::span<const Point> converged,
                    const LiveCounts& counts,
                    const SeedPool* pool) {
  Pending pending;
  pending.message.index = frame.index;
  pending.message.timestamp = frame.timestamp;
  pending.message.tracking_state = 1;
  pending.message.cam_from_world = frame.cam_from_world;
  pending.camera = frame.camera;
  pending.handed = UnixTime();
  pending.points.assign(converged.begin(), converged.end());
  std::optional<PendingPreview> preview;
  if (PreviewIsDue()) {
    preview.emplace();
    preview->frame = frame;
    if (pool != nullptr) {
      preview->marks = MarkSeeds(*pool, frame, options_.engine, options_.marks);
    }
  }
  {
    const std::scoped_lock lock(mutex_);
    frames_.push_back(std::move(pending));
    if (preview) preview_ = std::move(preview);
    counts_ = counts;
    live_changed_ = true;
  }
  changed_.notify_one();
}

bool Feed::PreviewIsDue() {
  const auto now = Clock::now();
  if (std::chrono::duration<double>(now - last_marked_).count() * options_.preview_hz < 1) {
    return false;
  }
  last_marked_ = now;
  return true;
}

void Feed::AddPicture(std::int64_t index, std::shared_ptr<const Picture> picture) {
  if (!PreviewIsDue()) return;
  PendingPreview preview;
  preview.frame.index = index;
  preview.frame.picture = std::move(picture);
  preview.posed = false;
  {
    const std::scoped_lock lock(mutex_);
    preview_ = std::move(preview);
    live_changed_ = true;
  }
  changed_.notify_one();
}

void Feed::SetCounts(const LiveCounts& counts) {
  {
    const std::scoped_lock lock(mutex_);
    counts_ = counts;
    live_changed_ = true;
  }
  changed_.notify_one();
}

void Feed::AddMessage(MessageLevel level, const std::string& text) {
  log_->Append(RecordType::kMessage, Encode(TextMessage{level, text}));
}

void Feed::SetState(const std::string& state) {
  {
    const std::scoped_lock lock(mutex_);
    state_ = state;
    live_changed_ = true;
  }
  changed_.notify_one();
}

void Feed::End(const EndMessage& end) {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
  thread_ = std::thread([] {});  // for the destructor
  if (options_.records) log_->Append(RecordType::kEnd, Encode(end));
}

std::size_t Feed::map_points() const {
  const std::scoped_lock lock(mutex_);
  return map_points_;
}

void Feed::Run() {
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1 / options_.most_hz));
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || live_changed_; });
    const bool last = stop_;
    std::deque<Pending> frames = std::exchange(frames_, {});
    std::optional<PendingPreview> preview = std::exchange(preview_, std::nullopt);
    const LiveCounts counts = counts_;
    const std::string state = state_;
    live_changed_ = false;
    lock.unlock();
    for (const Pending& frame : frames) SendFrame(frame);
    if (preview) SendPreview(std::move(*preview));
    SendLive(counts, state, frames);
    lock.lock();
    map_points_ = map_.size();
    if (last) return;
    changed_.wait_for(lock, period, [&] { return stop_; });
  }
}

void Feed::SendFrame(const Pending& frame) {
  for (const Point& point : frame.points) {
    if (recent_.size() < kRecentPoints) {
      recent_.push_back(point);
    } else {
      recent_[recent_next_++ % kRecentPoints] = point;
    }
  }
  if (!options_.records) return;
  if (!sent_camera_ || !SameCamera(*sent_camera_, frame.camera)) {
    sent_camera_ = frame.camera;
    log_->Append(RecordType::kCamera, Encode(frame.camera));
  }
  log_->Append(RecordType::kFrame, Encode(frame.message));
  for (const PointCloud& group : GroupForStream(frame.points)) {
    SendPoints(frame.message.index, group);
  }
}

// Points of one group, near each other, so that what the map makes of them is, too.
void Feed::SendPoints(std::int64_t frame, const PointCloud& group) {
  std::vector<MapUpdate> updates;
  map_.Insert(group, static_cast<std::uint32_t>(frame), &updates);
  PointCloud added, refined;
  std::vector<std::uint32_t> ids;
  std::uint32_t first_id = 0;
  for (const MapUpdate& update : updates) {
    if (update.change == MapChange::kAdded) {
      if (added.empty()) first_id = update.entry.id;
      added.push_back(update.entry.point);
    } else if (WorthSending(update)) {
      ids.push_back(update.entry.id);
      refined.push_back(update.entry.point);
    }
  }
  if (!added.empty()) log_->Append(RecordType::kPoints, EncodePoints(frame, first_id, added));
  if (!refined.empty()) {
    log_->Append(RecordType::kPointsRefined, EncodeRefinedPoints(frame, ids, refined));
  }
}

// How far the points in view moved since the last picture. [px a frame]
double Feed::MotionPx(const PosedFrame& frame) {
  const std::optional<Rigid3d> before = std::exchange(last_pose_, frame.cam_from_world);
  const auto frames = static_cast<double>(frame.index - std::exchange(last_frame_, frame.index));
  if (!before || frames < 1) return motion_px_;
  const Projector projector(frame.camera);
  std::vector<double> moved;
  for (std::size_t i = 0; i < recent_.size(); i += 4) {
    const Eigen::Vector3d position = recent_[i].position.cast<double>();
    const auto now = projector.Project(frame.cam_from_world * position);
    const auto then = projector.Project(*before * position);
    if (now && then && frame.camera.Contains(*now)) moved.push_back((*now - *then).norm() / frames);
  }
  if (moved.size() < 8) return motion_px_;
  const auto middle = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 2);
  std::nth_element(moved.begin(), middle, moved.end());
  return *middle;
}

void Feed::SendPreview(PendingPreview preview) {
  const PosedFrame& frame = preview.frame;
  if (preview.posed) motion_px_ = MotionPx(frame);
  sharpness_ = Sharpness(frame.picture->grey.view());
  usual_sharpness_ += (sharpness_ - usual_sharpness_) * (usual_sharpness_ > 0 ? 0.05 : 1);
  MarkPlainBlocks(frame.picture->grey.view(), options_.engine.min_patch_stddev, &preview.marks);
  if (preview.posed) MarkPoints(recent_, frame, &preview.marks);
  const std::vector<std::uint8_t> jpeg = encoder_.Encode(*frame.picture);
  if (jpeg.empty()) return;
  std::vector<std::uint8_t> payload;
  ByteWriter out(&payload);
  out.Put(frame.index);
  out.Put(UnixTime());
  out.Put(static_cast<std::uint32_t>(preview.marks.size()));
  out.Put(static_cast<std::uint32_t>(jpeg.size()));
  for (const SeedMark& mark : preview.marks) {
    out.Put(mark.x);
    out.Put(mark.y);
    out.Put(static_cast<std::uint8_t>(mark.kind));
    out.Put(mark.progress);
    out.Put(std::uint16_t{0});
  }
  payload.insert(payload.end(), jpeg.begin(), jpeg.end());
  log_->SetPreview(payload);
}

void Feed::SendLive(const LiveCounts& counts,
                    const std::string& state,
                    const std::deque<Pending>& frames) {
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  const double rate = elapsed > 0 ? static_cast<double>(counts.frames) / elapsed : 0;
  nlohmann::json json = {
      {"state", state},
      {"unix_time", UnixTime()},
      {"frames", counts.frames},
      {"frames_total", counts.frames_total},
      {"frames_dropped", counts.frames_dropped},
      {"frames_per_second", rate},
      {"seeds", counts.seeds},
      {"points", options_.records ? static_cast<std::int64_t>(map_.size()) : counts.points},
      {"converged", counts.points},
      {"motion_px", motion_px_},
      {"window_px", options_.engine.search_radius_px},
      {"sharpness", usual_sharpness_ > 0 ? sharpness_ / usual_sharpness_ : 1},
      {"elapsed_s", elapsed}};
  if (!counts.problem.empty()) json["problem"] = counts.problem;
  if (state == "running" && counts.frames_total > counts.frames && rate > 0) {
    json["eta_s"] = static_cast<double>(counts.frames_total - counts.frames) / rate;
  }
  // When the engine gave the latest frames, so that the page can tell how old they are.
  nlohmann::json& handed = json["handed"] = nlohmann::json::array();
  for (const Pending& frame : frames) {
    if (handed.size() < kMostHanded) handed.push_back({frame.message.index, frame.handed});
  }
  log_->SetLive(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace livemvs::viewer
