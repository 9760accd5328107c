#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/frame.h"
#include "livemvs/synth/camera_path.h"
#include "livemvs/synth/render.h"
#include "livemvs/synth/scene.h"

namespace livemvs {

/// A pinhole camera whose image is `width` by `height`, with a phone's field of view (horizontally
/// 55 degrees), centred.
Camera SyntheticCamera(int width, int height);

struct SequenceOptions {
  PathOptions path;
  Camera camera = SyntheticCamera(640, 480);
  int samples_per_pixel = 4;
  double noise_sigma = 0;         ///< [grey levels]
  double blur = 0;                ///< Part of the frame's time that the shutter is open, 0 to 1.
  double exposure_variation = 0;  ///< Relative change of brightness that comes and goes, 0 to 0.9.
  bool ground_truth = true;       ///< Compute depth and material.

  void Check() const;  ///< @throws std::invalid_argument
};

/// A frame as a reconstruction gets it, and what is truly there.
struct SyntheticFrame {
  PosedFrame frame;
  Image<float> z_depth;          ///< As in RenderedFrame; empty without ground_truth.
  Image<std::uint8_t> material;  ///< Likewise.
};

/// One frame of a sequence. Frames are independent of each other.
SyntheticFrame RenderSequenceFrame(const SyntheticScene& scene,
                                   const SequenceOptions& options,
                                   int index);

/// The whole sequence in memory. Mind the size: about 8 bytes per pixel and frame.
///
///   SyntheticScene scene({.name = "table"});
///   SequenceOptions options;
///   options.path = DefaultPath("table");
///   for (const SyntheticFrame& f : RenderSequence(scene, options))
///   reconstructor.AddFrame(f.frame);
std::vector<SyntheticFrame> RenderSequence(const SyntheticScene& scene,
                                           const SequenceOptions& options);

}  // namespace livemvs
