#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "livemvs/backend/seed_state.h"
#include "livemvs/core/frame.h"
#include "livemvs/core/image.h"
#include "livemvs/core/options.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

/// Grey levels at the pixels of a patch, row-major.
using PatchValues = std::array<float, kPatchPixels>;

/// The least NCC score of the halves of a patch that have texture; 1 where none has. A half is the
/// patch's middle column and the two at one side of it, or its middle row and two.
/// @param window  What another picture has at the places of the patch's pixels.
/// @param noise2  Variance of the noise of a pixel [grey levels²]: more than eight times that is
///                texture.
float LeastSideNcc(const PatchValues& patch, const PatchValues& window, float noise2);

/// Whether seeds that converged in a frame may become points (Options::min_side_ncc). At a jump in
/// depth a patch follows the edge of the nearer surface, also where the seed's own pixel is of the
/// farther one: the patch as a whole matches, but not its other half, which sees something else.
class SideCheck {
 public:
  /// Looks at the frame's pyramid, which must be there as long as this is; options are copied.
  SideCheck(const Options& options,
            const PosedFrame& frame,
            std::span<const ImageView<std::uint8_t>> pyramid);

  /// True also where the patch's place is not all in the picture.
  bool Passes(const ReferenceFrame& reference, const EndedSeed& seed);

 private:
  const RelativeView<float>& ViewFrom(const ReferenceFrame& reference);

  Options options_;
  Rigid3d cam_from_world_;
  std::span<const ImageView<std::uint8_t>> pyramid_;
  std::vector<Camera> cameras_;  // of the frame, by level
  std::vector<CameraParams<float>> params_;
  std::size_t viewed_from_ = 0;  // `begin` of the reference frame that view_ is for
  std::optional<RelativeView<float>> view_;
};

}  // namespace livemvs
