#include "livemvs/io/dataset_images.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/image_source.h"
#include "livemvs/io/picture_codec.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr double kNominalRate = 30;  // [Hz] of images without time stamps

void Order(ImageSet& set) {
  if (!set.keep_order) {
    std::stable_sort(
        set.images.begin(), set.images.end(), [](const ImageEntry& a, const ImageEntry& b) {
          return NaturalLess(a.name, b.name);
        });
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    ImageEntry& image = set.images[i];
    if (!names.insert(image.name).second) {
      throw BadInput(image.place + ": the image '" + image.name + "' is listed twice");
    }
    if (image.number < 0) image.number = static_cast<std::int64_t>(i);
  }
}

// The file of an image, or an empty path where there is none. Some transforms.json leave the
// extension out.
fs::path FindFile(const ImageSet& set, const ImageEntry& image) {
  std::error_code error;
  const fs::path below_root = fs::relative(set.image_folder, set.root, error);
  const fs::path folder = error || below_root == "." ? fs::path() : below_root;
  for (const char* extension : {"", ".png", ".jpg", ".jpeg", ".PNG", ".JPG"}) {
    if (*extension != '\0' && HasImageExtension(image.name)) break;
    // An absolute name would replace the folder in front of it.
    const std::string name = fs::path(image.name).is_absolute()
                                 ? image.name
                                 : (folder / (image.name + extension)).string();
    const fs::path file = ResolveInside(set.root, name, image.place);
    if (fs::is_regular_file(file, error)) return file;
  }
  return {};
}

// Fills in the files and removes the images that have none. Returns the number of those.
std::int64_t Locate(ImageSet& set) {
  std::string example;
  const auto is_missing = [&](ImageEntry& image) {
    if (image.file.empty()) image.file = FindFile(set, image);
    if (image.file.empty() && example.empty()) example = image.name;
    return image.file.empty();
  };
  const std::size_t missing = std::erase_if(set.images, is_missing);
  if (missing > 0) {
    LogWarning(set.file.string() + ": " + std::to_string(missing) + " of " +
               std::to_string(missing + set.images.size()) + " images do not exist in " +
               set.image_folder.string() + " (" + example + ", ...) and are left out");
  }
  return static_cast<std::int64_t>(missing);
}

class ImageDataset : public Dataset {
 public:
  ImageDataset(ImageSet set, const DatasetOptions& options) : set_(std::move(set)) {
    Order(set_);
    const std::size_t listed = set_.images.size();
    const std::int64_t missing = Locate(set_);
    statistics_.skipped = missing + set_.unposed;
    description_ = set_.format + ", " + std::to_string(set_.images.size()) + " images";
    std::erase_if(set_.images,
                  [&](const ImageEntry& image) { return !IsChosen(options, image.number); });
    RequireTwoFrames(set_.images.size(),
                     set_.file,
                     set_.format + " that lists " + std::to_string(listed) +
                         " images with poses, " + std::to_string(missing) + " of them missing in " +
                         set_.image_folder.string());
    ReadFirst();
    MakeViews();
  }

  std::string description() const override { return description_; }
  const std::vector<DatasetView>& views() const override { return views_; }
  const std::vector<Eigen::Vector3d>& sparse_points() const override { return set_.sparse_points; }
  std::optional<Box> box() const override { return set_.box; }
  Statistics statistics() const override { return statistics_; }

  std::optional<PosedFrame> Next() override {
    while (next_ < views_.size()) {
      const DatasetView& view = views_[next_];
      std::shared_ptr<const Picture> picture = ReadView(next_++);
      if (!picture) continue;
      CameraForSize(view.camera, picture->width(), picture->height(), view.name);
      ++statistics_.decoded;
      return PosedFrame{view.index,
                        view.timestamp,
                        view.name,
                        std::move(picture),
                        view.camera,
                        view.cam_from_world};
    }
    return std::nullopt;
  }

 private:
  // Decodes the first good picture, which tells the size that the calibration must have.
  void ReadFirst() {
    for (std::size_t i = 0;; ++i) {
      try {
        first_ = std::make_shared<const Picture>(ReadPicture(set_.images[i].file));
        first_index_ = i;
        return;
      } catch (const Error&) {
        if (i + 1 == set_.images.size()) throw;
      }
    }
  }

  void MakeViews() {
    views_.reserve(set_.images.size());
    for (const ImageEntry& image : set_.images) {
      DatasetView view;
      view.index = image.number;
      view.timestamp = image.timestamp.value_or(static_cast<double>(image.number) / kNominalRate);
      view.name = image.name;
      view.file = image.file;
      view.camera = image.camera;
      if (view.camera.width == 0) {
        view.camera = CameraForSize(view.camera, first_->width(), first_->height(), view.name);
      }
      view.cam_from_world = image.cam_from_world;
      views_.push_back(std::move(view));
    }
    CameraForSize(views_[first_index_].camera,
                  first_->width(),
                  first_->height(),
                  set_.images[first_index_].file.string());
  }

  // Nothing where the file is damaged, which is counted and warned of once.
  std::shared_ptr<const Picture> ReadView(std::size_t i) {
    if (i == first_index_ && first_) return std::exchange(first_, nullptr);
    try {
      return std::make_shared<const Picture>(ReadPicture(set_.images[i].file));
    } catch (const Error& e) {
      ++statistics_.skipped;
      if (!warned_)
        LogWarning(std::string(e.what()) + "; the image is left out, and others like it");
      warned_ = true;
      return nullptr;
    }
  }

  ImageSet set_;
  std::string description_;
  std::vector<DatasetView> views_;
  std::shared_ptr<const Picture> first_;
  std::size_t first_index_ = 0;
  std::size_t next_ = 0;
  Statistics statistics_;
  bool warned_ = false;
};

}  // namespace

std::unique_ptr<Dataset> OpenImageSet(ImageSet set, const DatasetOptions& options) {
  if (!options.images.empty()) set.root = set.image_folder = options.images;
  return std::make_unique<ImageDataset>(std::move(set), options);
}

void RequireTwoFrames(std::size_t usable, const fs::path& place, const std::string& found) {
  if (usable >= 2) return;
  throw BadInput(
      place.string() + ": found " + found + "; " + (usable == 0 ? "no frame" : "only one frame") +
      " is left to use, at least two are needed (check the image folder, --images and the "
      "range of frames). " +
      SupportedForms());
}

bool IsChosen(const DatasetOptions& options, std::int64_t index) {
  return index >= options.first_frame && (options.last_frame < 0 || index <= options.last_frame) &&
         (index - options.first_frame) % options.step == 0;
}

void CheckRange(const DatasetOptions& options) {
  if (options.first_frame < 0 || options.last_frame < -1 || options.step < 1) {
    throw std::invalid_argument("frames: first " + std::to_string(options.first_frame) + ", last " +
                                std::to_string(options.last_frame) + ", step " +
                                std::to_string(options.step) +
                                "; first must be 0 or more, last -1 (all) or more, step 1 or more");
  }
  if (options.last_frame >= 0 && options.last_frame < options.first_frame) {
    throw std::invalid_argument("frames: the last, " + std::to_string(options.last_frame) +
                                ", is before the first, " + std::to_string(options.first_frame));
  }
}

std::string SupportedForms() {
  return "Supported are: a COLMAP model (sparse/0) with its images, transforms.json (instant-ngp, "
         "nerfstudio), a TUM sequence (rgb.txt, groundtruth.txt, camera.yaml), Middlebury views "
         "(*_par.txt), a list of cameras (cams.txt), and a video or image folder with a pose file "
         "(poses.txt or --poses) and a calibration (camera.yaml, intrinsics.txt or --camera)";
}

}  // namespace livemvs
