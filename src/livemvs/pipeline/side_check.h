#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "livemvs/backend/seed_state.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/options.h"
#include "livemvs/core/pose.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

/// Grey levels at the pixels of a patch, row-major.
using PatchValues = std::array<float, kPatchPixels>;

/// The least NCC score of the halves of a patch that have texture; 1 where none has. A half is the
/// patch's middle column and the two at one side of it, or its middle row and two.
/// @param window  What another picture has at the places of the patch's pixels.
/// @param noise2  Variance of the noise of a pixel [grey levels²]: more than eight times that is
///                texture, but not less than 1/2.
float LeastSideNcc(const PatchValues& patch, const PatchValues& window, float noise2);

/// Whether seeds that converged in a frame may become points (Options::min_side_ncc). At a jump in
/// depth a patch follows the edge of the nearer surface, also where the seed's own pixel is of the
/// farther one: the patch as a whole matches, but not its other half, which sees something else.
class SideCheck {
 public:
  /// @param projector  Of the frame's camera, at level 0. What is referred to must be there as long
  ///                   as this is.
  SideCheck(const Options& options,
            const Rigid3d& cam_from_world,
            const Projector& projector,
            std::span<const ImageView<std::uint8_t>> pyramid)
      : options_(options),
        cam_from_world_(cam_from_world),
        projector_(projector),
        pyramid_(pyramid) {}

  /// The patch is sampled where its plane, at the posterior mean and facing the reference camera,
  /// appears: to first order, so that it follows roll, scale and lens. True also where it is not
  /// all in the picture, a pixel from the border.
  bool Passes(const ReferenceFrame& reference, const EndedSeed& ended) const;

 private:
  const Options& options_;
  const Rigid3d& cam_from_world_;
  const Projector& projector_;
  std::span<const ImageView<std::uint8_t>> pyramid_;
};

}  // namespace livemvs
