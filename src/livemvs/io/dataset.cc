#include "livemvs/io/dataset.h"

#include <algorithm>
#include <functional>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/colmap.h"
#include "livemvs/io/dataset_images.h"
#include "livemvs/io/dataset_posed.h"
#include "livemvs/io/dataset_text.h"
#include "livemvs/io/image_source.h"
#include "livemvs/io/middlebury.h"
#include "livemvs/io/pose_file.h"
#include "livemvs/io/transforms.h"
#include "livemvs/io/tum.h"
#include "livemvs/io/video_source.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

bool IsFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool IsFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

// The folder of a file, or the parent of a folder; never empty.
fs::path ParentOf(const fs::path& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error).lexically_normal();
  if (absolute.filename().empty()) absolute = absolute.parent_path();
  return absolute.parent_path();
}

bool HoldsOneOf(const fs::path& folder, const std::vector<ImageEntry>& images) {
  constexpr std::size_t kEnough = 1000;
  const std::size_t n = std::min(images.size(), kEnough);
  return std::any_of(images.begin(),
                     images.begin() + static_cast<std::ptrdiff_t>(n),
                     [&](const ImageEntry& image) { return IsFile(folder / image.name); });
}

// COLMAP does not write down where the images are: look around the model.
void FindColmapImages(const fs::path& model_folder, ImageSet& set) {
  fs::path root = model_folder;
  constexpr int kLevels = 3;  // PATH/sparse/0
  for (int level = 0; level < kLevels; ++level) {
    for (const fs::path& folder : {root / "images", root}) {
      if (!IsFolder(folder) || !HoldsOneOf(folder, set.images)) continue;
      set.root = root;
      set.image_folder = folder;
      return;
    }
    root = ParentOf(root);
  }
  set.root = set.image_folder = model_folder;
}

void WarnUnused(const DatasetOptions& options, bool camera_used, bool convention_used) {
  if (!options.camera.empty() && !camera_used) {
    LogWarning("--camera is not used: the data set brings its own intrinsics");
  }
  if (options.pose_convention != PoseConvention::kAuto && !convention_used) {
    LogWarning("--pose-convention is not used: the data set's format implies its own");
  }
}

std::unique_ptr<Dataset> OpenColmap(const fs::path& model_folder, const DatasetOptions& options) {
  WarnUnused(options, false, false);
  ImageSet set = ReadColmapModel(model_folder);
  FindColmapImages(model_folder, set);
  return OpenImageSet(std::move(set), options);
}

std::unique_ptr<Dataset> OpenTransforms(const fs::path& file, const DatasetOptions& options) {
  WarnUnused(options, false, false);
  return OpenImageSet(ReadTransforms(file), options);
}

std::unique_ptr<Dataset> OpenTum(const fs::path& folder, const DatasetOptions& options) {
  return OpenImageSet(ReadTumDataset(folder, options.camera, options.pose_convention), options);
}

std::unique_ptr<Dataset> OpenMiddlebury(const fs::path& file, const DatasetOptions& options) {
  WarnUnused(options, false, false);
  return OpenImageSet(ReadMiddlebury(file), options);
}

std::unique_ptr<Dataset> OpenCams(const fs::path& file, const DatasetOptions& options) {
  WarnUnused(options, false, false);
  return OpenImageSet(ReadCamsFile(file), options);
}

std::vector<fs::path> ListVideos(const fs::path& folder) {
  std::vector<fs::path> videos;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (IsFile(it->path()) && HasVideoExtension(it->path())) videos.push_back(it->path());
  }
  std::sort(videos.begin(), videos.end());
  return videos;
}

std::unique_ptr<Dataset> OpenPosedFolder(const fs::path& folder, const DatasetOptions& options) {
  if (!options.images.empty()) return OpenPosedImages(folder, options.images, options);
  const std::vector<fs::path> videos = ListVideos(folder);
  if (videos.size() > 1) {
    throw BadInput(folder.string() + ": holds several videos (" + videos[0].filename().string() +
                   ", " + videos[1].filename().string() + "); name the one to use with --data");
  }
  if (videos.size() == 1) return OpenPosedVideo(videos[0], options);
  for (const fs::path& images : {folder, folder / "images", folder / "rgb"}) {
    if (IsFolder(images) && !ListImages(images).empty()) {
      return OpenPosedImages(folder, images, options);
    }
  }
  throw BadInput(folder.string() + ": no video, image or camera file found. " + SupportedForms());
}

struct Form {
  std::string name;
  std::function<std::unique_ptr<Dataset>(const DatasetOptions&)> open;
};

// The forms that are present in a folder, best first.
std::vector<Form> FindForms(const fs::path& folder) {
  std::vector<Form> forms;
  if (const std::optional<fs::path> model = FindColmapModel(folder)) {
    forms.push_back({"COLMAP model", [=](const auto& o) { return OpenColmap(*model, o); }});
  }
  if (const fs::path file = folder / "transforms.json"; IsFile(file)) {
    forms.push_back({"transforms.json", [=](const auto& o) { return OpenTransforms(file, o); }});
  }
  if (IsFile(folder / "rgb.txt")) {
    forms.push_back({"TUM sequence", [=](const auto& o) { return OpenTum(folder, o); }});
  }
  if (const std::optional<fs::path> file = FindMiddlebury(folder)) {
    forms.push_back({"Middlebury views", [=](const auto& o) { return OpenMiddlebury(*file, o); }});
  }
  if (const fs::path file = folder / "cams.txt"; IsFile(file)) {
    forms.push_back({"cams.txt", [=](const auto& o) { return OpenCams(file, o); }});
  }
  // A TUM sequence's own trajectory is no other form.
  if (FindPoseFile(folder) && !IsFile(folder / "rgb.txt")) {
    forms.push_back({"pose file", [=](const auto& o) { return OpenPosedFolder(folder, o); }});
  }
  return forms;
}

std::unique_ptr<Dataset> OpenFolder(const fs::path& folder, const DatasetOptions& options) {
  if (!options.poses.empty()) return OpenPosedFolder(folder, options);
  const std::vector<Form> forms = FindForms(folder);
  if (forms.empty()) return OpenPosedFolder(folder, options);  // says what is missing
  if (forms.size() > 1) {
    std::string others;
    for (std::size_t i = 1; i < forms.size(); ++i) {
      others += (others.empty() ? "" : ", ") + forms[i].name;
    }
    LogInfo(folder.string() + ": using the " + forms[0].name + "; also there, not used: " + others);
  }
  return forms[0].open(options);
}

std::unique_ptr<Dataset> OpenFile(const fs::path& file, const DatasetOptions& options) {
  const fs::path folder = ParentOf(file);
  const std::string name = file.filename().string();
  const auto is_any_of = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (ToLower(file.extension().string()) == ".json") return OpenTransforms(file, options);
  if (name.ends_with("_par.txt")) return OpenMiddlebury(file, options);
  if (name.starts_with("cams") && name.ends_with(".txt")) return OpenCams(file, options);
  if (is_any_of({"rgb.txt"})) return OpenTum(folder, options);
  if (is_any_of({"cameras.txt", "images.txt", "points3D.txt"}) ||
      is_any_of({"cameras.bin", "images.bin", "points3D.bin"})) {
    return OpenColmap(folder, options);
  }
  if (!HasVideoExtension(file) && (HasImageExtension(file) || file.extension() == ".txt")) {
    throw BadInput(file.string() + ": not a file that defines a data set. " + SupportedForms());
  }
  return OpenPosedVideo(file, options);
}

}  // namespace

std::unique_ptr<Dataset> OpenDataset(const DatasetOptions& options) {
  CheckRange(options);
  std::unique_ptr<Dataset> dataset;
  if (IsFolder(options.data)) {
    dataset = OpenFolder(options.data, options);
  } else if (IsFile(options.data)) {
    dataset = OpenFile(options.data, options);
  } else {
    throw BadInput(options.data.string() + ": no such file or folder. " + SupportedForms());
  }
  LogInfo(options.data.string() + ": " + dataset->description() + ", " +
          std::to_string(dataset->views().size()) + " frames to use");
  return dataset;
}

}  // namespace livemvs
