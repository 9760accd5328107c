#include "livemvs/io/dataset_posed.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/dataset_images.h"
#include "livemvs/io/dataset_text.h"
#include "livemvs/io/image_source.h"
#include "livemvs/io/pose_file.h"
#include "livemvs/io/video_source.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

fs::path PoseFileFor(const fs::path& base, const fs::path& what, const DatasetOptions& options) {
  if (!options.poses.empty()) return options.poses;
  const std::optional<fs::path> found = FindPoseFile(base);
  if (found) return *found;
  throw BadInput(what.string() +
                 ": no poses for it: neither --poses nor poses.txt, trajectory.txt "
                 "or groundtruth.txt in " +
                 base.string() + ". " + SupportedForms());
}

Camera CameraFor(const fs::path& base, const fs::path& what, const DatasetOptions& options) {
  if (!options.camera.empty()) return ReadCamera(options.camera);
  const std::optional<fs::path> found = FindCalibration(base);
  if (found) return ReadCamera(found->string());
  throw BadInput(what.string() +
                 ": no calibration for it: neither --camera nor camera.yaml or "
                 "intrinsics.txt in " +
                 base.string());
}

Error WrongNumber(const fs::path& poses,
                  std::int64_t n,
                  const fs::path& what,
                  std::int64_t frames) {
  return BadInput(poses.string() + ": poses for " + std::to_string(n) + " frames, but " +
                  what.string() + " has " + std::to_string(frames) +
                  "; give the poses of these frames, put the frame's number in front of each row, "
                  "or use a trajectory with time stamps");
}

std::int64_t PoseSpan(const NumberedPoses& poses) {
  return poses.cam_from_world.empty() ? 0 : poses.cam_from_world.rbegin()->first + 1;
}

class VideoDataset : public Dataset {
 public:
  VideoDataset(const fs::path& video, const DatasetOptions& options)
      : video_(video), options_(options) {
    const fs::path base = video.parent_path().empty() ? "." : video.parent_path();
    pose_file_ = PoseFileFor(base, video, options);
    source_ = OpenVideo(video);
    info_ = source_->info();
    poses_ = ReadPoseFile(pose_file_, options.pose_convention);
    camera_ =
        CameraForSize(CameraFor(base, video, options), info_.width, info_.height, video.string());
    MakeViews();
    RequireTwoFrames(views_.size(), video, WhatIsThere());
  }

  std::string description() const override {
    return info_.description + " with " +
           (std::holds_alternative<Trajectory>(poses_) ? "a trajectory" : "poses by frame");
  }
  const std::vector<DatasetView>& views() const override { return views_; }
  const std::vector<Eigen::Vector3d>& sparse_points() const override { return no_points_; }
  std::optional<Box> box() const override { return std::nullopt; }

  Statistics statistics() const override {
    return {decoded_, source_->statistics().skipped + unposed_};
  }

  std::optional<PosedFrame> Next() override {
    while (!ended_ && !(options_.cancelled && options_.cancelled())) {
      std::optional<SourceFrame> frame = source_->Next();
      if (!frame || (options_.last_frame >= 0 && frame->index > options_.last_frame)) break;
      ++seen_;
      if (!IsChosen(options_, frame->index)) continue;
      const std::optional<Rigid3d> pose = PoseOf(frame->index, frame->timestamp);
      if (!pose) {
        ++unposed_;
        continue;
      }
      CameraForSize(camera_, frame->picture->width(), frame->picture->height(), frame->name);
      ++decoded_;
      return PosedFrame{frame->index,
                        frame->timestamp,
                        std::move(frame->name),
                        std::move(frame->picture),
                        camera_,
                        *pose};
    }
    if (!ended_) ReportEnd();
    ended_ = true;
    return std::nullopt;
  }

 private:
  std::optional<Rigid3d> PoseOf(std::int64_t index, double timestamp) const {
    if (const Trajectory* trajectory = std::get_if<Trajectory>(&poses_)) {
      return trajectory->At(timestamp);
    }
    const auto& by_frame = std::get<NumberedPoses>(poses_).cam_from_world;
    const auto found = by_frame.find(index);
    if (found == by_frame.end()) return std::nullopt;
    return found->second;
  }

  void AddView(std::int64_t index, double timestamp) {
    const std::optional<Rigid3d> pose = PoseOf(index, timestamp);
    if (!IsChosen(options_, index) || !pose) return;
    views_.push_back({index, timestamp, "frame " + std::to_string(index), camera_, *pose});
  }

  void MakeViews() {
    const double rate = info_.frames_per_second > 0 ? info_.frames_per_second : 30;
    if (const NumberedPoses* numbered = std::get_if<NumberedPoses>(&poses_)) {
      // Containers may count one frame more or less than they hold.
      const std::int64_t span = PoseSpan(*numbered);
      // Rows without numbers are one per frame; containers may be off by one in their count.
      const bool too_few = !numbered->explicit_numbers && span + 1 < info_.frame_count;
      if (info_.frame_count > 0 && (span > info_.frame_count + 1 || too_few)) {
        throw WrongNumber(pose_file_, span, video_, info_.frame_count);
      }
      for (const auto& [index, pose] : numbered->cam_from_world) {
        AddView(index, static_cast<double>(index) / rate);
      }
      return;
    }
    if (info_.frame_count > 0) {
      for (std::int64_t i = 0; i < info_.frame_count; ++i)
        AddView(i, static_cast<double>(i) / rate);
      return;
    }
    for (const double time : std::get<Trajectory>(poses_).times()) {
      if (time >= 0) AddView(std::llround(time * rate), time);
    }
  }

  std::string WhatIsThere() const {
    std::string found = info_.description + " and ";
    if (const Trajectory* trajectory = std::get_if<Trajectory>(&poses_)) {
      return found + "a trajectory from " + std::to_string(trajectory->front_time()) + " s to " +
             std::to_string(trajectory->back_time()) +
             " s (time stamps must be seconds since the video's first frame)";
    }
    return found + std::to_string(std::get<NumberedPoses>(poses_).cam_from_world.size()) + " poses";
  }

  void ReportEnd() {
    if (unposed_ > 0) {
      LogWarning(pose_file_.string() + ": no pose for " + std::to_string(unposed_) +
                 " frames of the video, which were left out");
    }
    const NumberedPoses* numbered = std::get_if<NumberedPoses>(&poses_);
    const std::int64_t frames = seen_ + source_->statistics().skipped;
    if (numbered != nullptr && options_.last_frame < 0 && PoseSpan(*numbered) > frames + 1) {
      LogWarning(video_.string() + ": the video ended after " + std::to_string(frames) +
                 " frames; the pose file goes on to " + std::to_string(PoseSpan(*numbered)));
    }
  }

  fs::path video_;
  fs::path pose_file_;
  DatasetOptions options_;
  std::unique_ptr<FrameSource> source_;
  FrameSource::Info info_;
  Poses poses_;
  Camera camera_;
  std::vector<DatasetView> views_;
  std::vector<Eigen::Vector3d> no_points_;
  std::int64_t seen_ = 0;
  std::int64_t decoded_ = 0;
  std::int64_t unposed_ = 0;
  bool ended_ = false;
};

// The time in an image's name ("1305031102.175304.png"), if it is one.
std::optional<double> TimeOfName(const fs::path& file) {
  const std::optional<double> time = ParseNumber(file.stem().string());
  return time && std::isfinite(*time) ? time : std::nullopt;
}

std::optional<Rigid3d> PoseOfImage(const Poses& poses,
                                   std::size_t index,
                                   const fs::path& file,
                                   bool in_order) {
  if (const NumberedPoses* numbered = std::get_if<NumberedPoses>(&poses)) {
    const auto found = numbered->cam_from_world.find(static_cast<std::int64_t>(index));
    if (found == numbered->cam_from_world.end()) return std::nullopt;
    return found->second;
  }
  const Trajectory& trajectory = std::get<Trajectory>(poses);
  if (in_order) return trajectory.At(trajectory.times()[index]);
  const std::optional<double> time = TimeOfName(file);
  return time ? trajectory.At(*time) : std::nullopt;
}

void CheckNumbers(const Poses& poses,
                  const fs::path& pose_file,
                  const std::vector<fs::path>& files,
                  const fs::path& folder) {
  const std::int64_t images = static_cast<std::int64_t>(files.size());
  if (const NumberedPoses* numbered = std::get_if<NumberedPoses>(&poses)) {
    const std::int64_t span = PoseSpan(*numbered);
    const bool fits = numbered->explicit_numbers ? span <= images : span == images;
    if (!fits) throw WrongNumber(pose_file, span, folder, images);
    return;
  }
  const Trajectory& trajectory = std::get<Trajectory>(poses);
  if (trajectory.size() == files.size()) return;
  const bool times_meet = std::any_of(files.begin(), files.end(), [&](const fs::path& file) {
    const std::optional<double> time = TimeOfName(file);
    return time && trajectory.At(*time);
  });
  if (!times_meet) {
    throw WrongNumber(pose_file, static_cast<std::int64_t>(trajectory.size()), folder, images);
  }
}

}  // namespace

std::unique_ptr<Dataset> OpenPosedVideo(const fs::path& video, const DatasetOptions& options) {
  return std::make_unique<VideoDataset>(video, options);
}

std::unique_ptr<Dataset> OpenPosedImages(const fs::path& base,
                                         const fs::path& images,
                                         const DatasetOptions& options) {
  const fs::path pose_file = PoseFileFor(base, images, options);
  const Poses poses = ReadPoseFile(pose_file, options.pose_convention);
  const Camera camera = CameraFor(base, images, options);
  const std::vector<fs::path> files = ListImages(images);
  CheckNumbers(poses, pose_file, files, images);
  const Trajectory* trajectory = std::get_if<Trajectory>(&poses);
  const bool in_order = trajectory != nullptr && trajectory->size() == files.size();
  ImageSet set;
  set.format = "image folder with poses";
  set.file = pose_file;
  set.root = set.image_folder = images;
  set.keep_order = true;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::optional<Rigid3d> pose = PoseOfImage(poses, i, files[i], in_order);
    if (!pose) {
      ++set.unposed;
      continue;
    }
    ImageEntry image;
    image.name = files[i].filename().string();
    image.place = pose_file.string();
    image.number = static_cast<std::int64_t>(i);
    if (trajectory != nullptr) {
      image.timestamp = in_order ? trajectory->times()[i] : TimeOfName(files[i]);
    }
    image.camera = camera;
    image.cam_from_world = *pose;
    set.images.push_back(std::move(image));
  }
  if (set.unposed > 0) {
    LogWarning(pose_file.string() + ": no pose for " + std::to_string(set.unposed) + " of " +
               std::to_string(files.size()) + " images, which are left out");
  }
  return OpenImageSet(std::move(set), options);
}

}  // namespace livemvs
