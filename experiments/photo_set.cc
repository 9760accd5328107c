#include "photo_set.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "livemvs/core/error.h"

namespace livemvs::experiments {
namespace {

void Add(PhotoSet* photos, Image<std::uint8_t> image, const Camera& camera, const Rigid3d& pose) {
  photos->images.push_back(std::make_unique<Image<std::uint8_t>>(std::move(image)));
  photos->views.push_back({photos->images.back()->view(), Projector(camera), pose});
}

Image<std::uint8_t> Copy(const Image<std::uint8_t>& image) {
  Image<std::uint8_t> copy(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) {
    std::copy_n(image.Row(y), image.width(), copy.Row(y));
  }
  return copy;
}

// Rotation of the picture of `b` against that of `a` [rad].
double Roll(const Rigid3d& a_from_world, const Rigid3d& b_from_world) {
  const Eigen::Matrix3d r = b_from_world.rotation * a_from_world.rotation.transpose();
  return std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1));
}

}  // namespace

PhotoSet RenderPhotos(const SyntheticScene& scene,
                      const SequenceOptions& sequence,
                      const Progress& progress) {
  PhotoSet photos;
  photos.box = scene.box();
  for (int i = 0; i < sequence.path.frames; ++i) {
    const SyntheticFrame frame = RenderSequenceFrame(scene, sequence, i);
    Add(&photos, Copy(frame.frame.picture->grey), sequence.camera, frame.frame.cam_from_world);
    progress(i + 1, sequence.path.frames);
  }
  return photos;
}

PhotoSet ReadPhotos(Dataset* dataset) {
  if (!dataset->box()) throw Error(ErrorKind::kBadInput, "the data set brings no box along");
  PhotoSet photos;
  photos.box = *dataset->box();
  while (const auto frame = dataset->Next()) {
    Add(&photos, Copy(frame->picture->grey), frame->camera, frame->cam_from_world);
  }
  return photos;
}

std::vector<int> NearestViews(const PhotoSet& photos, int view, int count) {
  const Rigid3d& pose = photos.views[view].cam_from_world;
  std::vector<std::pair<double, int>> others;
  for (int i = 0; i < static_cast<int>(photos.views.size()); ++i) {
    const Rigid3d& other = photos.views[i].cam_from_world;
    if (i == view || std::abs(Roll(pose, other)) >= std::numbers::pi / 4) continue;
    others.emplace_back((other.Center() - pose.Center()).norm(), i);
  }
  std::sort(others.begin(), others.end());
  std::vector<int> nearest;
  for (std::size_t i = 0; i < others.size() && static_cast<int>(i) < count; ++i) {
    nearest.push_back(others[i].second);
  }
  return nearest;
}

}  // namespace livemvs::experiments
