#pragma once

#include <cstdint>

#include "livemvs/core/image.h"
#include "livemvs/core/pixel_label.h"
#include "livemvs/synth/scene.h"
#include "livemvs/synth/sequence.h"

namespace livemvs {

struct LabelOptions {
  int edge_radius = 2;          ///< Pixels this near to a jump in depth are occluding edges. [px]
  double edge_jump = 0.03;      ///< Relative change of depth between neighbours that is a jump.
  int following_frames = 15;    ///< Frames after a pixel's own that may hide its surface.
  int frame_step = 1;           ///< Every n-th of them is asked.
  double occluded_share = 0.5;  ///< "Soon occluded": hidden in more of those that look there.

  void Check() const;  ///< @throws std::invalid_argument
};

/// The PixelLabels of a frame with ground truth, as far as one frame can tell: all but
/// kLabelSoonOccluded.
Image<std::uint8_t> LabelPixels(const SyntheticScene& scene,
                                const Image<float>& z_depth,
                                const Image<std::uint8_t>& material,
                                const LabelOptions& options = {});

/// All PixelLabels of a frame of a sequence, rendered with ground truth. Multi-threaded.
Image<std::uint8_t> LabelSequenceFrame(const SyntheticScene& scene,
                                       const SequenceOptions& sequence,
                                       const SyntheticFrame& frame,
                                       const LabelOptions& options = {});

}  // namespace livemvs
