#include "export_workspace.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/lower_case.h"
#include "livemvs/io/picture_codec.h"
#include "livemvs/io/ply.h"
#include "livemvs/io/pose_writer.h"
#include "livemvs/io/tum.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

Error CannotMake(const fs::path& path, const std::string& why) {
  return Error(ErrorKind::kOutOfResource, path.string() + ": cannot be made: " + why);
}

/// A folder that appears under its name when all is in it.
class AtomicFolder {
 public:
  explicit AtomicFolder(fs::path target) : target_(std::move(target)) {
    if (!target_.has_filename()) target_ = target_.parent_path();
    std::error_code error;
    if (fs::exists(target_, error) && !(fs::is_directory(target_, error) && IsEmpty())) {
      throw BadInput(target_.string() +
                     ": exists and is not an empty folder; remove it or name another");
    }
    temporary_ = target_;
    temporary_ += ".tmp-" + std::to_string(::getpid());
    if (!fs::create_directory(temporary_, error)) {
      const fs::path failed = std::exchange(temporary_, fs::path());
      throw CannotMake(target_, error ? error.message() : failed.string() + " is in the way");
    }
  }
  ~AtomicFolder() {
    std::error_code ignored;
    if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
  }
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const fs::path& path() const { return temporary_; }

  void Commit() {
    std::error_code error;
    fs::rename(temporary_, target_, error);  // replaces an empty folder
    if (error) throw CannotMake(target_, error.message());
    temporary_.clear();
  }

 private:
  bool IsEmpty() const {
    std::error_code error;
    return fs::is_empty(target_, error) && !error;
  }

  fs::path target_;
  fs::path temporary_;  ///< Empty: committed.
};

bool CanBeCopied(const fs::path& file) {
  const std::string extension = LowerExtension(file);
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

/// Names of the pictures in the workspace: their own where these are unlike each other.
std::vector<std::string> NamesOf(const std::vector<DatasetView>& views) {
  std::set<std::string> own;
  for (const DatasetView& view : views) own.insert(view.file.filename().string());
  const bool keep = own.size() == views.size();
  std::vector<std::string> names;
  for (const DatasetView& view : views) {
    if (keep && CanBeCopied(view.file)) {
      names.push_back(view.file.filename().string());
      continue;
    }
    char number[32];
    std::snprintf(number, sizeof number, "%06lld", static_cast<long long>(view.index));
    names.push_back(number + (CanBeCopied(view.file) ? view.file.extension().string() : ".png"));
  }
  return names;
}

void WritePicture(const fs::path& path, const Picture& picture) {
  if (picture.cb.width() == 0) {
    WritePng(path, picture.grey);
    return;
  }
  Image<Rgb> rgb(picture.width(), picture.height());
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) rgb(x, y) = picture.ColorAt(x, y);
  }
  WritePng(path, rgb);
}

/// The pictures that could be read, in `images` where that is not empty.
std::vector<PosedImage> TakeDataset(const DatasetOptions& options, const fs::path& images) {
  const std::unique_ptr<Dataset> dataset = OpenDataset(options);
  const std::vector<DatasetView>& views = dataset->views();
  const std::vector<std::string> names = NamesOf(views);
  std::vector<PosedImage> posed;
  const auto add = [&](std::size_t i) {
    posed.push_back({names[i], views[i].camera, views[i].cam_from_world});
  };
  if (images.empty()) {
    for (std::size_t i = 0; i < views.size(); ++i) add(i);
    return posed;
  }
  std::map<std::int64_t, std::size_t> by_index;
  for (std::size_t i = 0; i < views.size(); ++i) by_index[views[i].index] = i;
  while (const std::optional<PosedFrame> frame = dataset->Next()) {
    const auto found = by_index.find(frame->index);
    if (found == by_index.end()) continue;
    const std::size_t i = found->second;
    const fs::path target = images / names[i];
    if (CanBeCopied(views[i].file)) {
      std::error_code error;
      if (!fs::copy_file(views[i].file, target, error)) throw CannotMake(target, error.message());
    } else {
      WritePicture(target, *frame->picture);
    }
    add(i);
  }
  if (posed.empty()) throw BadInput(options.data.string() + ": no picture of it can be read");
  return posed;
}

/// What a scan wrote down of its camera, named as the frames of a film are by number.
std::vector<PosedImage> PosesOfScan(const fs::path& scan) {
  const Camera camera = ReadOpenCvYaml(scan / "camera.yaml");
  const Trajectory path = ReadTumTrajectory(scan / "poses.txt", PoseConvention::kAuto);
  std::vector<PosedImage> posed;
  for (const double time : path.times()) {
    char number[32];
    std::snprintf(number, sizeof number, "%06zu.png", posed.size());
    if (const std::optional<Rigid3d> pose = path.At(time)) posed.push_back({number, camera, *pose});
  }
  return posed;
}

}  // namespace

void WriteWorkspace(const fs::path& folder,
                    const WorkspaceSource& source,
                    const PointCloud& cloud) {
  if (source.dataset.data.empty() && (source.scan.empty() || source.pictures)) {
    throw BadInput(folder.string() + ": needs pictures and poses: name the recording with --data" +
                   (source.scan.empty() ? "" : ", or write the poses alone with --no-pictures"));
  }
  AtomicFolder out(folder);
  fs::path images;
  if (source.pictures) {
    images = out.path() / "images";
    std::error_code error;
    if (!fs::create_directory(images, error)) throw CannotMake(images, error.message());
  }
  std::vector<PosedImage> posed =
      source.dataset.data.empty() ? PosesOfScan(source.scan) : TakeDataset(source.dataset, images);
  if (source.form == WorkspaceForm::kColmap) {
    WriteColmapText(out.path() / "sparse" / "0", posed, cloud);
  } else {
    for (PosedImage& image : posed) image.image = "images/" + image.image;
    WritePly(out.path() / "points.ply", cloud, "as in the cloud that was exported");
    WriteTransforms(out.path() / "transforms.json", posed, "points.ply");
  }
  out.Commit();
  std::printf("%zu pictures, %zu points\n", posed.size(), cloud.size());
}

}  // namespace livemvs::app
