#pragma once

#include <Eigen/Core>
#include <vector>

namespace livemvs {

/// Height of a capital letter in the units of the glyphs.
inline constexpr double kCapHeight = 6;

/// A character drawn with a pen: x right from its left edge, y up from the baseline.
struct Glyph {
  double advance = 0;  ///< To the next character.
  std::vector<std::vector<Eigen::Vector2d>> strokes;
};

/// The glyph of a printable ASCII character; a box for any other.
Glyph GlyphOf(char c);

}  // namespace livemvs
