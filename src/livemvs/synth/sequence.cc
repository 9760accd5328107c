#include "livemvs/synth/sequence.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace livemvs {

Camera SyntheticCamera(int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.95 * width;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

void SequenceOptions::Check() const {
  path.Check();
  camera.Check();
  if (!(blur >= 0 && blur <= 1)) throw std::invalid_argument("blur must be 0 to 1");
  if (!(exposure_variation >= 0 && exposure_variation <= 0.9)) {
    throw std::invalid_argument("exposure_variation must be 0 to 0.9");
  }
}

SyntheticFrame RenderSequenceFrame(const SyntheticScene& scene,
                                   const SequenceOptions& options,
                                   int index) {
  options.Check();
  FrameRenderOptions render;
  render.samples_per_pixel = options.samples_per_pixel;
  render.noise_sigma = options.noise_sigma;
  render.noise_seed = options.path.seed;
  render.ground_truth = options.ground_truth;
  const double time = index / options.path.frames_per_second;
  constexpr double kExposurePeriod = 4;  // [s]
  render.exposure =
      1 + options.exposure_variation * std::sin(2 * std::numbers::pi * time / kExposurePeriod);
  const Rigid3d pose = PoseAt(options.path, index);
  if (options.blur > 0) {
    // The frame's pose is that of the middle of the exposure.
    const int count = options.samples_per_pixel;
    for (int i = 0; i < count; ++i) {
      const double part = (i + 0.5) / count - 0.5;
      render.shutter_poses.push_back(PoseAt(options.path, index + options.blur * part));
    }
  }
  RenderedFrame rendered = RenderFrame(scene, options.camera, pose, render, index);
  SyntheticFrame out;
  out.frame.index = index;
  out.frame.timestamp = time;
  out.frame.name = "frame " + std::to_string(index);
  out.frame.picture = std::make_shared<const Picture>(std::move(rendered.picture));
  out.frame.camera = options.camera;
  out.frame.cam_from_world = pose;
  out.z_depth = std::move(rendered.z_depth);
  out.material = std::move(rendered.material);
  return out;
}

std::vector<SyntheticFrame> RenderSequence(const SyntheticScene& scene,
                                           const SequenceOptions& options) {
  options.Check();
  std::vector<SyntheticFrame> frames;
  frames.reserve(options.path.frames);
  for (int i = 0; i < options.path.frames; ++i) {
    frames.push_back(RenderSequenceFrame(scene, options, i));
  }
  return frames;
}

}  // namespace livemvs
