#include "livemvs/synth/labels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::uint8_t LabelsOfMaterial(const synth::Material& material) {
  unsigned labels = 0;
  if (material.textureless) labels |= kLabelTextureless;
  if (material.repetitive) labels |= kLabelRepetitive;
  if (material.gloss > 0) labels |= kLabelSpecular;
  return static_cast<std::uint8_t>(labels);
}

void MarkEdgeAround(int x, int y, int radius, Image<std::uint8_t>* labels) {
  const int x0 = std::max(x - radius, 0), x1 = std::min(x + radius, labels->width() - 1);
  const int y0 = std::max(y - radius, 0), y1 = std::min(y + radius, labels->height() - 1);
  for (int v = y0; v <= y1; ++v) {
    for (int u = x0; u <= x1; ++u) (*labels)(u, v) |= kLabelOccludingEdge;
  }
}

// The cameras that look at the scene after a frame, as many as the options ask.
std::vector<Rigid3d> FollowingPoses(const SequenceOptions& sequence,
                                    std::int64_t index,
                                    const LabelOptions& options) {
  std::vector<Rigid3d> poses;
  const std::int64_t last =
      std::min<std::int64_t>(index + options.following_frames, sequence.path.frames - 1);
  for (std::int64_t i = index + options.frame_step; i <= last; i += options.frame_step) {
    poses.push_back(PoseAt(sequence.path, static_cast<double>(i)));
  }
  return poses;
}

// Whether a place is hidden in most of the pictures that it would lie in.
bool SoonOccluded(const SyntheticScene& scene,
                  const Projector& projector,
                  const std::vector<Rigid3d>& poses,
                  const Vector3d& place,
                  double share) {
  int looking = 0, hidden = 0;
  for (const Rigid3d& pose : poses) {
    const auto pixel = projector.Project(pose * place);
    if (!pixel || !projector.camera().Contains(*pixel)) continue;
    ++looking;
    hidden += scene.Hidden(place, pose.Center());
  }
  return hidden > share * looking;
}

}  // namespace

void LabelOptions::Check() const {
  if (edge_radius < 0) throw std::invalid_argument("edge_radius must not be negative");
  if (!(edge_jump > 0)) throw std::invalid_argument("edge_jump must be positive");
  if (following_frames < 0) throw std::invalid_argument("following_frames must not be negative");
  if (frame_step < 1) throw std::invalid_argument("frame_step must be at least 1");
  if (!(occluded_share >= 0 && occluded_share < 1)) {
    throw std::invalid_argument("occluded_share must be in [0, 1)");
  }
}

Image<std::uint8_t> LabelPixels(const SyntheticScene& scene,
                                const Image<float>& z_depth,
                                const Image<std::uint8_t>& material,
                                const LabelOptions& options) {
  options.Check();
  const int width = z_depth.width(), height = z_depth.height();
  const auto jump = [&](int x, int y, int x2, int y2) {
    const float a = z_depth(x, y), b = z_depth(x2, y2);
    return std::abs(a - b) > static_cast<float>(options.edge_jump) * std::max(a, b);
  };
  Image<std::uint8_t> labels(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint8_t id = material(x, y);
      labels(x, y) |= id == RenderedFrame::kNoMaterial ? std::uint8_t{kLabelBackground}
                                                       : LabelsOfMaterial(scene.materials()[id]);
      // A jump lies between two pixels: both are in its middle.
      if (x + 1 < width && jump(x, y, x + 1, y)) {
        MarkEdgeAround(x, y, options.edge_radius, &labels);
        MarkEdgeAround(x + 1, y, options.edge_radius, &labels);
      }
      if (y + 1 < height && jump(x, y, x, y + 1)) {
        MarkEdgeAround(x, y, options.edge_radius, &labels);
        MarkEdgeAround(x, y + 1, options.edge_radius, &labels);
      }
    }
  }
  return labels;
}

Image<std::uint8_t> LabelSequenceFrame(const SyntheticScene& scene,
                                       const SequenceOptions& sequence,
                                       const SyntheticFrame& frame,
                                       const LabelOptions& options) {
  Image<std::uint8_t> labels = LabelPixels(scene, frame.z_depth, frame.material, options);
  const std::vector<Rigid3d> poses = FollowingPoses(sequence, frame.frame.index, options);
  const Projector projector(frame.frame.camera);
  const Rigid3d world_from_cam = frame.frame.cam_from_world.Inverse();
  ParallelFor(static_cast<std::size_t>(labels.height()), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < labels.width(); ++x) {
      const auto ray = projector.Unproject(Vector2d(x, y));
      if (frame.z_depth(x, y) == 0 || !ray) continue;
      const Vector3d place = world_from_cam * (static_cast<double>(frame.z_depth(x, y)) * *ray);
      if (SoonOccluded(scene, projector, poses, place, options.occluded_share)) {
        labels(x, y) |= kLabelSoonOccluded;
      }
    }
  });
  return labels;
}

}  // namespace livemvs
