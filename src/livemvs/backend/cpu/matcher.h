// Included by kernels.cc only, inside of the namespace of one instruction set.
//
// NCC of a 5x5 patch along the epipolar line, [VH11] Sec. 4.2. A patch row is a vector of 8 floats
// of which 5 count; the image is interpolated bilinearly.

/// Eight floats in a vector of the compiler's; the instruction set decides how many registers it
/// takes.
using Vec8 = float __attribute__((vector_size(32)));
using Byte8 = std::uint8_t __attribute__((vector_size(8)));

inline Vec8 LoadBytes(const std::uint8_t* p) {
  Byte8 bytes;
  __builtin_memcpy(&bytes, p, sizeof(bytes));
  return __builtin_convertvector(bytes, Vec8);
}

inline float Sum(const Vec8& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

/// The reference patch with its mean taken off, rows padded with zeros, and its second moments.
struct Template {
  Vec8 rows[kPatchSize];
  float sum_of_squares;
};

constexpr Vec8 kRowMask = {1, 1, 1, 1, 1, 0, 0, 0};

inline Template MakeTemplate(const std::uint8_t* patch) {
  Template t;
  Vec8 sum = {};
  for (int r = 0; r < kPatchSize; ++r) {
    t.rows[r] = LoadBytes(patch + r * kPatchSize) * kRowMask;
    sum += t.rows[r];
  }
  const float mean = Sum(sum) * (1.0F / kPatchPixels);
  Vec8 squares = {};
  for (int r = 0; r < kPatchSize; ++r) {
    t.rows[r] = (t.rows[r] - mean) * kRowMask;
    squares += t.rows[r] * t.rows[r];
  }
  t.sum_of_squares = Sum(squares);
  return t;
}

/// Sum over the patch of the squared derivative along the unit direction (ex, ey), from central
/// differences on the inner 3x3, scaled to the whole patch. [grey levels²/px²]
inline float GradientAlong(const std::uint8_t* patch, float ex, float ey) {
  float sum = 0;
  for (int r = 1; r + 1 < kPatchSize; ++r) {
    for (int c = 1; c + 1 < kPatchSize; ++c) {
      const std::uint8_t* p = patch + r * kPatchSize + c;
      const float gx = static_cast<float>(p[1] - p[-1]);
      const float gy = static_cast<float>(p[kPatchSize] - p[-kPatchSize]);
      const float g = ex * gx + ey * gy;
      sum += g * g;
    }
  }
  constexpr float kInner = (kPatchSize - 2) * (kPatchSize - 2);
  return sum * (0.25F * kPatchPixels / kInner);
}

inline float Score(const Template& t, const Vec8& sums, const Vec8& squares, const Vec8& products) {
  const float sum = Sum(sums);
  const float variance = Sum(squares) - sum * sum * (1.0F / kPatchPixels);
  // A window without contrast (below rounding) matches nothing.
  const float floor = variance > 1.0F ? variance : 1.0F;
  return Sum(products) / std::sqrt(floor * t.sum_of_squares);
}

/// Samples the current image on the pixel grid of the reference patch.
struct AlignedSampler {
  const ImageView<std::uint8_t>& image;

  /// NCC of the patch with the window centred at (x, y).
  float Ncc(const Template& t, float x, float y) const {
    const float x0 = std::floor(x), y0 = std::floor(y);
    const float fx = x - x0, fy = y - y0;
    const std::uint8_t* p = image.data +
                            (static_cast<std::ptrdiff_t>(y0) - kPatchRadius) * image.stride +
                            (static_cast<std::ptrdiff_t>(x0) - kPatchRadius);
    Vec8 sums = {}, squares = {}, products = {};
    Vec8 above = LoadBytes(p);
    above += fx * (LoadBytes(p + 1) - above);
    for (int r = 0; r < kPatchSize; ++r) {
      p += image.stride;
      Vec8 below = LoadBytes(p);
      below += fx * (LoadBytes(p + 1) - below);
      const Vec8 v = (above + fy * (below - above)) * kRowMask;
      sums += v;
      squares += v * v;
      products += v * t.rows[r];
      above = below;
    }
    return Score(t, sums, squares, products);
  }
};

/// Samples the current image on a grid turned and scaled as the patch appears there.
struct WarpedSampler {
  const ImageView<std::uint8_t>& image;
  float ux,
      uy;  ///< Step in the current image per pixel to the right in the patch; down is (-uy, ux).

  float Ncc(const Template& t, float x, float y) const {
    Vec8 sums = {}, squares = {}, products = {};
    for (int r = 0; r < kPatchSize; ++r) {
      Vec8 v = {};
      for (int c = 0; c < kPatchSize; ++c) {
        const float i = static_cast<float>(c - kPatchRadius),
                    j = static_cast<float>(r - kPatchRadius);
        v[c] = Bilinear(x + i * ux - j * uy, y + i * uy + j * ux);
      }
      sums += v;
      squares += v * v;
      products += v * t.rows[r];
    }
    return Score(t, sums, squares, products);
  }

  float Bilinear(float x, float y) const {
    const float x0 = std::floor(x), y0 = std::floor(y);
    const float fx = x - x0, fy = y - y0;
    const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(y0) * image.stride +
                            static_cast<std::ptrdiff_t>(x0);
    const float v00 = p[0], v01 = p[1], v10 = p[image.stride], v11 = p[image.stride + 1];
    const float above = v00 + fx * (v01 - v00);
    const float below = v10 + fx * (v11 - v10);
    return above + fy * (below - above);
  }
};

/// The best local maximum on a stretch of the line.
struct LineMatch {
  float score = -2;
  float runner_up = -2;  ///< The next local maximum's score.
  float offset = 0;      ///< [px] along the line, sub-pixel.
};

/// [VH11] Algorithm 1, step 2b: the largest local maximum of the NCC among the inner samples of
/// `range`.
template <typename Sampler>
LineMatch SearchLine(const Sampler& sampler,
                     const Template& t,
                     const Projection<float>& p,
                     const SearchRange& range) {
  const auto ncc = [&](float s) { return sampler.Ncc(t, p.x + s * p.dx, p.y + s * p.dy); };
  LineMatch match;
  if (range.last - range.first < 2) return match;
  float before = ncc(static_cast<float>(range.first));
  float here = ncc(static_cast<float>(range.first + 1));
  for (int i = range.first + 1; i < range.last; ++i) {
    const float after = ncc(static_cast<float>(i + 1));
    if (here > before && here >= after) {
      if (here > match.score) {
        match.runner_up = match.score;
        match.score = here;
        match.offset = static_cast<float>(i);
      } else if (here > match.runner_up) {
        match.runner_up = here;
      }
    }
    before = here;
    here = after;
  }
  if (match.score <= -2) return match;
  // Half-pixel samples and a parabola: without the bias towards whole pixels (docs/algorithm.md).
  const float low = ncc(match.offset - 0.5F), high = ncc(match.offset + 0.5F);
  const float curvature = low - 2 * match.score + high;
  if (curvature < 0) {
    const float shift = 0.25F * (low - high) / curvature;
    match.offset += shift < -0.5F ? -0.5F : shift > 0.5F ? 0.5F : shift;
  }
  return match;
}
