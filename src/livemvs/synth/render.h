#pragma once

#include <cstdint>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/frame.h"
#include "livemvs/core/image.h"
#include "livemvs/core/pose.h"
#include "livemvs/synth/scene.h"

namespace livemvs {

struct FrameRenderOptions {
  int samples_per_pixel = 4;
  double noise_sigma = 0;        ///< Sensor noise, standard deviation [grey levels].
  double exposure = 1;           ///< Factor on the light.
  std::uint64_t noise_seed = 1;  ///< Each frame has noise of its own.
  bool ground_truth = true;      ///< Compute depth and material.
  /// cam_from_world while the shutter is open, at even times: the samples of a pixel are shared out
  /// to them. Empty: a sharp picture.
  std::vector<Rigid3d> shutter_poses = {};

  void Check() const;  ///< @throws std::invalid_argument
};

/// A rendered picture and what is truly there.
struct RenderedFrame {
  static constexpr std::uint8_t kNoMaterial = 255;

  Picture picture;               ///< Full range, BT.601, chroma at full size.
  Image<float> z_depth;          ///< Along the optical axis through pixel centres [m]; 0: nothing.
  Image<std::uint8_t> material;  ///< Index into the scene's materials; kNoMaterial: nothing.
};

/// Renders one frame, over all cores. The bytes do not depend on the number of threads.
/// Pixels that no ray of the camera's model reaches are black, without depth.
RenderedFrame RenderFrame(const SyntheticScene& scene,
                          const Camera& camera,
                          const Rigid3d& cam_from_world,
                          const FrameRenderOptions& options = {},
                          std::int64_t frame_index = 0);

}  // namespace livemvs
