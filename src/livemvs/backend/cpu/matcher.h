// Included by kernels.cc only, inside of the namespace of one instruction set.
//
// NCC of a 5x5 patch along the epipolar line, [VH11] Sec. 4.2. A patch row is a vector of 8 floats
// of which 5 count; the image is interpolated bilinearly.

/// Eight floats in a vector of the compiler's; the instruction set decides how many registers it
/// takes.
using Vec8 = float __attribute__((vector_size(32)));
using Byte8 = std::uint8_t __attribute__((vector_size(8)));

/// Eight bytes as floats. Spelt out for AVX2, where GCC 12 would convert one by one.
inline Vec8 LoadBytes(const std::uint8_t* p) {
#if defined(__AVX2__)
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p));
  return reinterpret_cast<Vec8>(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes)));
#else
  Vec8 v;
  for (int i = 0; i < 8; ++i) v[i] = static_cast<float>(p[i]);
  return v;
#endif
}

using Vec4 = float __attribute__((vector_size(16)));

/// The upper four floats added to the lower four.
inline Vec4 Fold(const Vec8& v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

/// The sums of three vectors, in the first three places.
inline Vec4 Sums(const Vec8& a, const Vec8& b, const Vec8& c) {
  const Vec4 fa = Fold(a), fb = Fold(b), fc = Fold(c);
  const Vec4 ab = __builtin_shufflevector(fa, fb, 0, 4, 1, 5) +
                  __builtin_shufflevector(fa, fb, 2, 6, 3, 7);       // a0+a2 b0+b2 a1+a3 b1+b3
  const Vec4 cc = fc + __builtin_shufflevector(fc, fc, 2, 3, 2, 3);  // c0+c2 c1+c3
  return __builtin_shufflevector(ab, cc, 0, 1, 4, 4) + __builtin_shufflevector(ab, cc, 2, 3, 5, 5);
}

inline float Sum(const Vec8& v) {
  const Vec4 f = Fold(v);
  return (f[0] + f[2]) + (f[1] + f[3]);
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
  constexpr Vec8 kInnerMask = {1, 1, 1, 0, 0, 0, 0, 0};
  Vec8 squares = {};
  for (int r = 1; r + 1 < kPatchSize; ++r) {
    const std::uint8_t* p = patch + r * kPatchSize + 1;
    const Vec8 gx = LoadBytes(p + 1) - LoadBytes(p - 1);
    const Vec8 gy = LoadBytes(p + kPatchSize) - LoadBytes(p - kPatchSize);
    const Vec8 g = (ex * gx + ey * gy) * kInnerMask;
    squares += g * g;
  }
  constexpr float kInner = (kPatchSize - 2) * (kPatchSize - 2);
  return Sum(squares) * (0.25F * kPatchPixels / kInner);
}

inline float Score(const Template& t, const Vec8& sums, const Vec8& squares, const Vec8& products) {
  const Vec4 total = Sums(sums, squares, products);
  const float variance = total[1] - total[0] * total[0] * (1.0F / kPatchPixels);
  // A window without contrast (below rounding) matches nothing.
  const float floor = variance > 1.0F ? variance : 1.0F;
  return total[2] / std::sqrt(floor * t.sum_of_squares);
}

/// Each pixel moved by the fraction fx towards its right neighbour; the last place is not valid.
inline Vec8 Between(const Vec8& row, float fx) {
  return row + fx * (__builtin_shufflevector(row, row, 1, 2, 3, 4, 5, 6, 7, 7) - row);
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
    Vec8 above = Between(LoadBytes(p), fx);
    for (int r = 0; r < kPatchSize; ++r) {
      p += image.stride;
      const Vec8 below = Between(LoadBytes(p), fx);
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
    constexpr Vec8 kColumns = {-2, -1, 0, 1, 2, 2, 2, 2};
    Vec8 sums = {}, squares = {}, products = {};
    for (int r = 0; r < kPatchSize; ++r) {
      const float j = static_cast<float>(r - kPatchRadius);
      const Vec8 v =
          Bilinear((x - j * uy) + kColumns * ux, (y + j * ux) + kColumns * uy) * kRowMask;
      sums += v;
      squares += v * v;
      products += v * t.rows[r];
    }
    return Score(t, sums, squares, products);
  }

  /// The image at eight places, all inside of it.
  Vec8 Bilinear(const Vec8& x, const Vec8& y) const {
    // Places are not negative: conversion cuts off like floor.
    Vec8 x0, y0, v00, v01, v10, v11;
#if defined(__AVX2__)
    const __m256i xi = _mm256_cvttps_epi32(reinterpret_cast<__m256>(x));
    const __m256i yi = _mm256_cvttps_epi32(reinterpret_cast<__m256>(y));
    x0 = reinterpret_cast<Vec8>(_mm256_cvtepi32_ps(xi));
    y0 = reinterpret_cast<Vec8>(_mm256_cvtepi32_ps(yi));
    const __m256i stride = _mm256_set1_epi32(static_cast<int>(image.stride));
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(yi, stride), xi);
    const auto gather = [&](const __m256i& where) {
      return _mm256_i32gather_epi32(reinterpret_cast<const int*>(image.data), where, 1);
    };
    const auto byte = [](const __m256i& v) {
      const __m256i low = _mm256_and_si256(v, _mm256_set1_epi32(255));
      return reinterpret_cast<Vec8>(_mm256_cvtepi32_ps(low));
    };
    const __m256i above_pair = gather(at);
    const __m256i below_pair = gather(_mm256_add_epi32(at, stride));
    v00 = byte(above_pair);
    v01 = byte(_mm256_srli_epi32(above_pair, 8));
    v10 = byte(below_pair);
    v11 = byte(_mm256_srli_epi32(below_pair, 8));
#else
    for (int i = 0; i < 8; ++i) {
      const int xi = static_cast<int>(x[i]), yi = static_cast<int>(y[i]);
      const std::uint8_t* p = image.data + yi * image.stride + xi;
      x0[i] = static_cast<float>(xi);
      y0[i] = static_cast<float>(yi);
      v00[i] = p[0];
      v01[i] = p[1];
      v10[i] = p[image.stride];
      v11[i] = p[image.stride + 1];
    }
#endif
    const Vec8 fx = x - x0, fy = y - y0;
    const Vec8 above = v00 + fx * (v01 - v00);
    const Vec8 below = v10 + fx * (v11 - v10);
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
