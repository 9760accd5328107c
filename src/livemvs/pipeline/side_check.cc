#include "livemvs/pipeline/side_check.h"

#include <algorithm>
#include <cmath>

#include "livemvs/core/epipolar.h"
#include "livemvs/core/texture.h"

namespace livemvs {
namespace {

// Variance that is texture, in those of the noise.
constexpr float kTexture = 8;

// Windows of less variance match nothing [grey levels²].
constexpr float kLeastVariance = 0.5F;

// Sums over some pixels of a patch and of a window.
struct Sums {
  float n = 0, p = 0, w = 0, pp = 0, pw = 0, ww = 0;

  void Add(float patch, float window) {
    ++n;
    p += patch;
    w += window;
    pp += patch * patch;
    pw += patch * window;
    ww += window * window;
  }
  void Add(const Sums& s) {
    n += s.n;
    p += s.p;
    w += s.w;
    pp += s.pp;
    pw += s.pw;
    ww += s.ww;
  }
};

// NCC over three neighbouring rows or columns; 1 where the patch has no texture there.
float NccOf(const Sums& first, const Sums& second, const Sums& third, float least_variance) {
  Sums s = first;
  s.Add(second);
  s.Add(third);
  const float patch_variance = s.pp / s.n - s.p * s.p / (s.n * s.n);
  if (!(patch_variance > least_variance)) return 1;
  const float window_variance = s.ww / s.n - s.w * s.w / (s.n * s.n);
  const float covariance = s.pw / s.n - s.p * s.w / (s.n * s.n);
  return covariance / std::sqrt(patch_variance * std::max(window_variance, kLeastVariance));
}

// The grey levels of a patch that is turned and scaled: a step to the right is (ux, uy), one down
// (-uy, ux). Nothing where a part of it is outside.
std::optional<PatchValues> Sample(
    const ImageView<std::uint8_t>& image, float x, float y, float ux, float uy) {
  constexpr float kRadius = kPatchRadius;
  const float reach = kRadius * (std::abs(ux) + std::abs(uy));
  const bool inside = x - reach >= 0 && y - reach >= 0 &&
                      x + reach < static_cast<float>(image.width - 1) &&
                      y + reach < static_cast<float>(image.height - 1);
  if (!inside) return std::nullopt;
  PatchValues values;
  for (int k = 0; k < kPatchPixels; ++k) {
    const auto i = static_cast<float>(k % kPatchSize - kPatchRadius);
    const auto j = static_cast<float>(k / kPatchSize - kPatchRadius);
    const float u = x + i * ux - j * uy, v = y + i * uy + j * ux;
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const float fx = u - static_cast<float>(column), fy = v - static_cast<float>(row);
    const std::uint8_t* at = &image(column, row);
    const std::uint8_t* below = at + image.stride;
    const float upper = at[0] + fx * static_cast<float>(at[1] - at[0]);
    const float lower = below[0] + fx * static_cast<float>(below[1] - below[0]);
    values[k] = upper + fy * (lower - upper);
  }
  return values;
}

}  // namespace

float LeastSideNcc(const PatchValues& patch, const PatchValues& window, float noise2) {
  // About the patches' middles: sums of squares of grey levels are large.
  constexpr int kMiddle = kPatchPixels / 2;
  std::array<Sums, kPatchSize> rows, columns;
  for (int k = 0; k < kPatchPixels; ++k) {
    const float p = patch[k] - patch[kMiddle], w = window[k] - window[kMiddle];
    rows[k / kPatchSize].Add(p, w);
    columns[k % kPatchSize].Add(p, w);
  }
  const float least_variance = std::max(kTexture * noise2, kLeastVariance);
  float least = 1;
  for (const auto& lines : {rows, columns}) {
    least = std::min(least, NccOf(lines[0], lines[1], lines[2], least_variance));
    least = std::min(least, NccOf(lines[2], lines[3], lines[4], least_variance));
  }
  return least;
}

SideCheck::SideCheck(const Options& options,
                     const PosedFrame& frame,
                     std::span<const ImageView<std::uint8_t>> pyramid)
    : options_(options), cam_from_world_(frame.cam_from_world), pyramid_(pyramid) {
  for (std::size_t level = 0; level < pyramid.size(); ++level) {
    cameras_.push_back(AtLevel(frame.camera, static_cast<int>(level)));
    params_.push_back(MakeCameraParams<float>(cameras_.back()));
  }
}

const RelativeView<float>& SideCheck::ViewFrom(const ReferenceFrame& reference) {
  if (!view_ || viewed_from_ != reference.begin) {
    viewed_from_ = reference.begin;
    view_ = MakeRelativeView(reference.camera,
                             reference.cam_from_world,
                             cameras_[reference.level],
                             params_[reference.level],
                             cam_from_world_);
  }
  return *view_;
}

bool SideCheck::Passes(const ReferenceFrame& reference, const EndedSeed& ended) {
  if (options_.min_side_ncc <= -1) return true;
  const SeedState& seed = ended.seed;
  const RelativeView<float>& view = ViewFrom(reference);
  const Projection<float> p = VisitModel(cameras_[reference.level].model, [&](auto model) {
    return ProjectSeed<decltype(model)>(view,
                                        options_.coordinate,
                                        seed.interval,
                                        seed.bearing_x,
                                        seed.bearing_y,
                                        seed.posterior.mu);
  });
  if (!p.visible) return true;
  const float scale = std::clamp(p.scale, 0.25F, 4.0F);  // as when it was matched
  const auto window =
      Sample(pyramid_[reference.level], p.x, p.y, scale * view.roll_cos, scale * view.roll_sin);
  if (!window) return true;
  PatchValues patch;
  std::copy(std::begin(ended.patch), std::end(ended.patch), patch.begin());
  const float noise2 = NoiseVariance(options_, reference.level);
  return LeastSideNcc(patch, *window, noise2) >= options_.min_side_ncc;
}

}  // namespace livemvs
