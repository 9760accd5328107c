#include "livemvs/io/tum.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <sstream>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/dataset_text.h"
#include "livemvs/io/pose_file.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr double kSameTime = 0.5e-3;       // [s]
constexpr double kMaxInterpolation = 0.1;  // [s] to each neighbour

std::string Seconds(double time) {
  std::ostringstream s;
  s.precision(15);
  s << time << " s";
  return s.str();
}

// Time stamps that must increase from line to line.
class Clock {
 public:
  double Read(std::string_view word, const std::string& place) {
    const double time = FiniteNumber(word, place, "time stamp");
    if (started_ && !(time > last_)) {
      throw BadInput(place + ": the time stamp " + Seconds(time) +
                     " is not after the one before, " + Seconds(last_) +
                     "; sort the rows by time and keep one of each");
    }
    started_ = true;
    last_ = time;
    return time;
  }

 private:
  bool started_ = false;
  double last_ = 0;
};

fs::path FindTrajectory(const fs::path& folder) {
  std::error_code error;
  for (const char* name : {"groundtruth.txt", "trajectory.txt"}) {
    if (fs::is_regular_file(folder / name, error)) return folder / name;
  }
  throw BadInput(
      folder.string() +
      ": rgb.txt is there, but no groundtruth.txt (or trajectory.txt) with the poses; add "
      "it, or name a pose file with --poses");
}

Camera FindCamera(const fs::path& folder, const std::string& camera) {
  if (!camera.empty()) return ReadCamera(camera);
  const std::optional<fs::path> found = FindCalibration(folder);
  if (!found) {
    throw BadInput(folder.string() +
                   ": no camera.yaml with the calibration; add it, or give --camera");
  }
  return ReadCamera(found->string());
}

}  // namespace

Trajectory::Trajectory(std::vector<double> times, std::vector<Rigid3d> world_from_cams)
    : times_(std::move(times)), world_from_cams_(std::move(world_from_cams)) {
  assert(!times_.empty() && times_.size() == world_from_cams_.size());
}

std::optional<Rigid3d> Trajectory::At(double time) const {
  const auto after = std::lower_bound(times_.begin(), times_.end(), time);
  const std::size_t next = static_cast<std::size_t>(after - times_.begin());
  const double to_next = next < size() ? times_[next] - time : HUGE_VAL;
  const double to_last = next > 0 ? time - times_[next - 1] : HUGE_VAL;
  if (to_next <= kSameTime && to_next <= to_last) return world_from_cams_[next].Inverse();
  if (to_last <= kSameTime) return world_from_cams_[next - 1].Inverse();
  if (!(to_next <= kMaxInterpolation && to_last <= kMaxInterpolation)) return std::nullopt;
  const Rigid3d& a = world_from_cams_[next - 1];
  const Rigid3d& b = world_from_cams_[next];
  const double s = to_last / (to_last + to_next);
  const Eigen::Quaterniond qa(a.rotation), qb(b.rotation);
  Rigid3d world_from_cam;
  world_from_cam.rotation = qa.slerp(s, qb).toRotationMatrix();
  world_from_cam.translation = (1 - s) * a.translation + s * b.translation;
  return world_from_cam.Inverse();
}

Trajectory ReadTumTrajectory(const fs::path& file, PoseConvention convention) {
  const std::string text = ReadTextFile(file);
  LineReader lines(text);
  PoseChecker checker;
  Clock clock;
  std::vector<double> times;
  std::vector<Rigid3d> poses;
  while (const auto line = lines.NextContent()) {
    const std::string place = Place(file, lines.line());
    const std::vector<std::string_view> words = SplitWords(*line, ",");
    if (words.size() != 8) {
      throw BadInput(place + ": " + std::to_string(words.size()) +
                     " words where a pose is: time tx ty tz qx qy qz qw");
    }
    times.push_back(clock.Read(words[0], place));
    const std::vector<double> v = FiniteNumbers({words.begin() + 1, words.end()}, place, "pose");
    Rigid3d written;
    written.translation = {v[0], v[1], v[2]};
    written.rotation = checker.FromQuaternion(v[6], v[3], v[4], v[5], place);
    if (convention == PoseConvention::kAuto) convention = PoseConvention::kWorldFromCam;
    poses.push_back(CamFromWorld(written, convention).Inverse());
  }
  if (times.empty()) throw BadInput(file.string() + ": holds no pose");
  return Trajectory(std::move(times), std::move(poses));
}

ImageSet ReadTumDataset(const fs::path& folder,
                        const std::string& camera,
                        PoseConvention convention) {
  ImageSet set;
  set.format = "TUM sequence";
  set.file = folder / "rgb.txt";
  set.root = set.image_folder = folder;
  set.keep_order = true;
  const Trajectory trajectory = ReadTumTrajectory(FindTrajectory(folder), convention);
  const Camera intrinsics = FindCamera(folder, camera);
  const std::string text = ReadTextFile(set.file);
  LineReader lines(text);
  Clock clock;
  while (const auto line = lines.NextContent()) {
    ImageEntry image;
    image.place = Place(set.file, lines.line());
    const std::vector<std::string_view> words = SplitWords(*line);
    if (words.size() < 2) throw BadInput(image.place + ": an image is: time file");
    image.timestamp = clock.Read(words[0], image.place);
    image.name = Trim(line->substr(static_cast<std::size_t>(words[1].data() - line->data())));
    image.camera = intrinsics;
    const std::optional<Rigid3d> pose = trajectory.At(*image.timestamp);
    if (!pose) {
      ++set.unposed;
      continue;
    }
    image.cam_from_world = *pose;
    set.images.push_back(std::move(image));
  }
  if (set.unposed > 0) {
    LogWarning(set.file.string() + ": " + std::to_string(set.unposed) +
               " images lie outside of the trajectory (" + Seconds(trajectory.front_time()) +
               " ... " + Seconds(trajectory.back_time()) + ", or in its gaps) and are left out");
  }
  return set;
}

}  // namespace livemvs
