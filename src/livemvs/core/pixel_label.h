#pragma once

#include <cstdint>

namespace livemvs {

/// What makes a pixel hard to reconstruct; bits, of which a pixel may have several.
enum PixelLabel : std::uint8_t {
  kLabelTextureless = 1,
  kLabelRepetitive = 2,
  kLabelOccludingEdge = 4,  ///< Next to a jump in depth.
  kLabelBackground = 8,     ///< Nothing there.
  kLabelSpecular = 16,      ///< Looks different from every side.
  kLabelSoonOccluded = 32,  ///< Its surface is hidden in most of the frames that follow.
};

/// All bits that have a meaning.
inline constexpr std::uint8_t kAllPixelLabels = 63;

}  // namespace livemvs
