#pragma once

#include <cstddef>
#include <cstdint>

#include "livemvs/core/options.h"
#include "livemvs/core/platform.h"
#include "livemvs/core/seed.h"

namespace livemvs {

/// What the inner 3x3 of a patch tells of its place along a line, see Texture().
template <typename T>
struct TextureSums {
  T along2;        ///< Of the derivative along the line, squared. [grey levels²/px²]
  T along_across;  ///< Of the derivatives along and across it.
};

/// Added to the grey levels' squared deviations where their sum divides: flat patches give no NaN.
inline constexpr float kLeastSpread = 1e-3F;

/// Sums over the patch of products of its derivatives along and across the unit direction (ex, ey),
/// less the share that a change of gain and offset would explain: NCC does not see those, so that a
/// ramp of brightness looks the same wherever it is moved. From central differences on the inner
/// 3x3, scaled to the whole patch.
/// @param pixel  kPatchPixels grey levels, row-major.
template <typename T>
LIVEMVS_HD inline TextureSums<T> Texture(const T* pixel, const T& ex, const T& ey) {
  constexpr int kInnerSide = kPatchSize - 2;
  constexpr int kInner = kInnerSide * kInnerSide;
  const T mean(1.0F / kInner), half(0.5F);
  T grey[kInner], along[kInner], across[kInner];
  T grey_sum(0.0F), along_sum(0.0F), across_sum(0.0F);
  for (int r = 0; r < kInnerSide; ++r) {
    for (int c = 0; c < kInnerSide; ++c) {
      const int at = (r + 1) * kPatchSize + c + 1, i = r * kInnerSide + c;
      const T gx = pixel[at + 1] - pixel[at - 1];
      const T gy = pixel[at + kPatchSize] - pixel[at - kPatchSize];
      grey_sum += grey[i] = pixel[at];
      along_sum += along[i] = half * (ex * gx + ey * gy);
      across_sum += across[i] = half * (ex * gy - ey * gx);
    }
  }
  const T grey_mean = grey_sum * mean;
  const T along_mean = along_sum * mean, across_mean = across_sum * mean;
  T tt(0.0F), gt(0.0F), ht(0.0F), gg(0.0F), gh(0.0F);
  for (int i = 0; i < kInner; ++i) {
    const T t = grey[i] - grey_mean, g = along[i] - along_mean, h = across[i] - across_mean;
    tt += t * t;
    gt += g * t;
    ht += h * t;
    gg += g * g;
    gh += g * h;
  }
  const T gain = gt / (tt + T(kLeastSpread));
  const T scale = T(static_cast<float>(kPatchPixels)) * mean;
  return {(gg - gain * gt) * scale, (gh - gain * ht) * scale};
}

/// tau of [VH11] Sec. 3, in pixels, and the error that all matches of a seed share.
template <typename T>
struct MatchErrors {
  T tau2_px;   ///< Variance of a match [px²].
  T bias2_px;  ///< Variance of the error that all matches of the seed share [px²].
};

/// Beside the matcher's own sigma there is what the image noise adds where the patch has little
/// texture along the line (the Cramér-Rao bound of a shift between two noisy patches), and what an
/// error across the line does where the patch's edges cross it at a slant.
/// @param noise2  Variance of the noise of a pixel, see NoiseVariance().
template <typename T>
LIVEMVS_HD inline MatchErrors<T> PredictErrors(const Options& options,
                                               float noise2,
                                               const TextureSums<T>& texture) {
  // The share of the noise in the sum of squared derivatives, in units of its variance: half of it
  // in each central difference, of which two degrees of freedom are taken off.
  constexpr float kNoiseShare = 0.5F * 7 * kPatchPixels / 9;
  const T beyond_noise = texture.along2 - T(kNoiseShare * noise2);
  const T signal = Select(beyond_noise > T(0.0F), beyond_noise, T(0.0F)) + T(1e-6F);
  const T slip = T(options.epipolar_error_px) * texture.along_across / signal;
  const float own = options.measurement_sigma_px * options.measurement_sigma_px;
  return {T(own) + T(2 * noise2) / signal + slip * slip,
          T(options.match_bias_px * options.match_bias_px) + slip * slip};
}

/// Variance of the noise at a level of the pyramid, where averaging has halved its sigma level by
/// level [grey levels²].
LIVEMVS_HD inline float NoiseVariance(const Options& options, int level) {
  const float noise = std::ldexp(options.image_noise, -level);
  return noise * noise;
}

/// The largest Texture().along2 of a patch over all directions: that along its principal axis,
/// which nothing crosses at a slant. Sums are of whole numbers.
/// @param center  The patch's middle pixel, in a picture whose rows lie `stride` apart.
LIVEMVS_HD inline float LargestTexture(const std::uint8_t* center, std::ptrdiff_t stride) {
  constexpr int kInnerRadius = kPatchRadius - 1;
  constexpr int kInner = (kPatchSize - 2) * (kPatchSize - 2);
  static_assert(kInner * kInner * 255 * 255 < 1 << 24, "float holds the sums' products exactly");
  // Sums over the inner pixels: t of grey levels, x and y of twice the derivatives.
  int t = 0, x = 0, y = 0, tt = 0, tx = 0, ty = 0, xx = 0, xy = 0, yy = 0;
  for (int row = -kInnerRadius; row <= kInnerRadius; ++row) {
    for (int column = -kInnerRadius; column <= kInnerRadius; ++column) {
      const std::uint8_t* at = center + row * stride + column;
      const int g = at[0], gx = at[1] - at[-1], gy = at[stride] - at[-stride];
      t += g;
      x += gx;
      y += gy;
      tt += g * g;
      tx += g * gx;
      ty += g * gy;
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  // kInner times the sum of products of two quantities' deviations.
  const auto covariance = [](int product, int a, int b) {
    return static_cast<float>(kInner * product - a * b);
  };
  const float gain = 1 / (covariance(tt, t, t) + kInner * kLeastSpread);
  const float ctx = covariance(tx, t, x), cty = covariance(ty, t, y);
  const float along_x = covariance(xx, x, x) - gain * ctx * ctx;
  const float along_y = covariance(yy, y, y) - gain * cty * cty;
  const float across = covariance(xy, x, y) - gain * ctx * cty;
  const float half_difference = 0.5F * (along_x - along_y);
  const float largest =
      0.5F * (along_x + along_y) + Sqrt(half_difference * half_difference + across * across);
  // Derivatives were taken twice; the mean square over the inner pixels stands for all of them.
  return largest * (0.25F * kPatchPixels / (kInner * kInner));
}

/// How much texture a patch has, and its moments about the patch's middle.
struct TextureMoments {
  float sum = 0;  ///< [grey levels²/px²]
  float x = 0;    ///< [grey levels²/px]
  float y = 0;
};

/// Texture is the squared gradient between each four pixels, less what the noise contributes.
/// @param center, stride  See LargestTexture().
LIVEMVS_HD inline TextureMoments MomentsOfTexture(float noise2,
                                                  const std::uint8_t* center,
                                                  std::ptrdiff_t stride) {
  TextureMoments moments;
  for (int row = -kPatchRadius; row < kPatchRadius; ++row) {
    for (int column = -kPatchRadius; column < kPatchRadius; ++column) {
      const std::uint8_t* at = center + row * stride + column;
      const int falling = at[stride + 1] - at[0], rising = at[1] - at[stride];
      const float squared = 0.5F * static_cast<float>(falling * falling + rising * rising);
      const float texture = squared > 2 * noise2 ? squared - 2 * noise2 : 0;
      moments.sum += texture;
      moments.x += texture * (static_cast<float>(column) + 0.5F);
      moments.y += texture * (static_cast<float>(row) + 0.5F);
    }
  }
  return moments;
}

/// Whether the centroid of a patch's texture lies within `most` pixels of its middle. True where
/// there is no texture.
LIVEMVS_HD inline bool IsCentred(float most, const TextureMoments& texture) {
  return texture.x * texture.x + texture.y * texture.y <= most * most * texture.sum * texture.sum;
}

/// The same of a patch; `most` = 0: it may lie anywhere.
/// @param center, stride  See LargestTexture().
LIVEMVS_HD inline bool IsCentred(float most,
                                 float noise2,
                                 const std::uint8_t* center,
                                 std::ptrdiff_t stride) {
  return most <= 0 || IsCentred(most, MomentsOfTexture(noise2, center, stride));
}

/// Whether matches of a patch may be precise enough along a line of some direction.
/// @param center, stride  See LargestTexture().
LIVEMVS_HD inline bool CanMatch(const Options& options,
                                float noise2,
                                const std::uint8_t* center,
                                std::ptrdiff_t stride) {
  const float most = options.max_measurement_sigma_px * options.max_measurement_sigma_px;
  const TextureSums<float> texture = {LargestTexture(center, stride), 0.0F};
  return PredictErrors<float>(options, noise2, texture).tau2_px <= most;
}

}  // namespace livemvs
