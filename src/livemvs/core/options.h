#pragma once

#include <cstdint>
#include <string>

namespace livemvs {

/// The coordinate along a seed's ray in which its posterior is Gaussian.
enum class DepthCoordinate {
  kDepth,        ///< Z, as published.
  kInverseDepth  ///< 1 / Z: the projection moves almost linearly in it, however wide the range.
};

/// The density u of an outlier measurement, [VH11] Eq. (1).
enum class OutlierDensity {
  kRange,  ///< 1 / (Z_max - Z_min), as published.
  kWindow  ///< 1 / (length of the interval that was searched): outliers fall into the window only.
};

/// How far along the epipolar line a match is sought.
enum class Search {
  kAuto,    ///< kFull where the steps between frames are too wide for the window, else kWindow.
  kWindow,  ///< Near the projection of the prior mean, as published: for video.
  kFull  ///< All of the posterior's interval, with several hypotheses per pixel: for photographs.
};

/// What the seeds live and are updated on.
enum class BackendChoice {
  kCpu,
  kCuda,  ///< An NVIDIA GPU.
  kAuto   ///< The GPU where there is one that can be used, else the CPU.
};

/// The most frames in a row that a seed does not meet, see Options::min_move. It bounds how long
/// those that went out of view stay while the camera hardly moves.
inline constexpr int kMostLeftOut = 7;

/// Every number of the method, with its symbol in [VH11] where it has one. Lengths along the line
/// are in pixels of the current image; nothing depends on the scene's unit.
struct Options {
  // --- The pool, [VH11] Algorithm 1
  // -------------------------------------------------------------------
  /// M, the number of seeds that are kept alive.
  int max_seeds = 250'000;
  /// Levels of the image pyramid on which seeds live: each sees half the detail of the one below,
  /// and with the same patch four times the surface. 1: none, as published.
  int levels = 3;
  /// Seeds are planted in frames that are at least so many apart: frames of a video that follow
  /// each other offer nearly the same pixels, and seeds of one frame are quicker to handle
  /// together. 1: in every frame, as published; 0: in every frame with Search::kFull, in every
  /// sixth with kWindow. Frames of several cameras in turn want a number that does not favour one
  /// of them.
  int plant_every = 0;
  /// A seed meets a frame only if the camera has moved since the last that it met, by this share of
  /// its distance from the seed's own frame, or if it has left out kMostLeftOut frames: from nearly
  /// the same place a match has nearly the same error again. 0: every frame, as published.
  float min_move = 0.03F;
  /// Distance between neighbouring seeds of one frame [px].
  int seed_spacing_px = 1;
  /// A pixel is given a seed only if no live seed and no point that was seen from a similar
  /// direction projects within this many pixels of it; -1 plants everywhere. [VH11] does not say.
  int cover_radius_px = 0;
  /// Points seen from directions further apart than this do not cover each other [degrees].
  float cover_angle_deg = 50;
  /// Least standard deviation of a patch's grey levels to be worth a seed, ...
  float min_patch_stddev = 10;
  /// ... and on the coarser levels, where averaging leaves less noise.
  float min_coarse_stddev = 2;
  /// On the finest level, how far from its middle the centroid of a patch's texture may lie [px]:
  /// beside an edge, what a patch tells is where the edge is, and a pixel that is nearer to it
  /// tells the same. 0: anywhere, as published.
  float max_texture_offset_px = 1.3F;

  /// How far beyond the scene's box surfaces are sought, so that points at its sides have
  /// neighbours [diagonals of the box]; 0: not, as published.
  float box_margin = 0.015F;

  // --- The prior, [VH11] Sec. 4.2
  // ---------------------------------------------------------------------
  float prior_a = 3;  ///< a_0
  float prior_b = 3;  ///< b_0
  DepthCoordinate coordinate = DepthCoordinate::kInverseDepth;

  // --- The search, [VH11] Sec. 4.2
  // --------------------------------------------------------------------
  Search search = Search::kAuto;
  /// w, the least radius of the search window [px].
  float search_radius_px = 2;
  /// The window grows to this many standard deviations of the posterior ...
  float search_sigmas = 2.5F;
  /// ... but not beyond this radius [px].
  float search_radius_max_px = 16;
  /// Least NCC score of a match; -1 accepts any local maximum, as published.
  float min_ncc = 0.5F;
  /// A second local maximum scoring within this of the best makes the frame tell nothing; 0: never.
  float ambiguity_ncc = 0.03F;
  /// Posterior's extent [-2 sigma, 2 sigma] projected [px] below which a frame can tell nothing.
  float min_parallax_px = 1;
  /// Rotation and scale between the patches beyond which the sampling grid follows them; 0: never.
  float warp_roll_deg = 8;
  float warp_scale = 1.15F;

  // --- The measurement, [VH11] Sec. 3
  // -----------------------------------------------------------------
  /// tau, the standard deviation of a good match [px].
  float measurement_sigma_px = 0.5F;
  /// Standard deviation of the image noise [grey levels], which adds to tau where the patch has
  /// little gradient along the line; 0: tau is the same for all, as published.
  float image_noise = 2;
  /// tau beyond which a match tells nothing, because the patch is flat along the line [px].
  float max_measurement_sigma_px = 1.5F;
  /// Error that all matches of a seed share, because its surface is slanted, its patch overlaps an
  /// edge or the poses drift [px]. It does not average out, but shrinks as the baseline grows: the
  /// posterior's variance at conversion is enlarged by it. 0: none, as published.
  float match_bias_px = 0.15F;
  /// Error across the line [px], for the same reasons. Where the patch's edges cross the line at a
  /// slant, it shifts the match along it; it adds to tau and to the error that matches share. 0:
  /// none, as published.
  float epipolar_error_px = 0.2F;
  OutlierDensity outlier_density = OutlierDensity::kWindow;

  // --- The end of a seed, [VH11] Sec. 4.3
  // -------------------------------------------------------------
  float eta_outlier = 0.4F;        ///< Removed when P(inlier ratio < eta_outlier) exceeds ...
  float outlier_certainty = 0.9F;  ///< ... this.
  float eta_inlier = 0.5F;         ///< Converted when the mean inlier ratio exceeds this, and ...
  /// ... epsilon: the standard deviation of depth is below this fraction of Z_max - Z_min, or ...
  float epsilon_range = 0;
  /// ... below this many pixels' width at that depth (Z / f), the pixels being those of the seed's
  /// level. At least one of the two must be positive.
  float epsilon_px = 1.4F;
  /// Fewest measurements that agreed.
  int min_views = 8;
  /// Least NCC score, in the frame in which a seed converges, of each half of its patch that has
  /// texture: where a half does not match, it shows another surface. -1: not asked, as published.
  float min_side_ncc = 0.6F;
  /// Frames met that told something, or would have if the patch could be matched, after which a
  /// seed that has not converged is given up; 0: never.
  int max_age = 66;
  /// Consecutive frames met out of view after which a seed is given up; 0: never.
  int max_unseen = 5;

  // --- The cloud, when all frames are in; [VH11] leaves it as it is
  // ---------------------------------
  /// A point whose patch has its texture at one side stays only if points agree with it at the
  /// other side, within this many pixels of the finest level [px]; 0: all stay.
  float overhang_px = 64;
  /// Radius within which points are drawn to the plane of their neighbours [px of their level]; 0:
  /// not.
  float regularise_px = 5;
  /// Fewest points on that plane, itself included, for a point to stay; 0: all stay. Needs
  /// regularise_px.
  int min_support = 4;
  /// A point stays only if others of its surface lie all around it, those within this many pixels
  /// of the finest level or the nearest few [px]; 0: all stay.
  float rim_px = 5.25F;

  /// Worker threads; 0: all cores. Results do not depend on it.
  int threads = 0;

  /// Results do not depend on it, but for the last bits with fisheye lenses.
  BackendChoice backend = BackendChoice::kCpu;

  /// @throws std::invalid_argument naming the option and its value.
  void Check() const;
};

/// Calls `visit(name, field)` for every option: the one list that command line, files and printing
/// use. Works on const and non-const Options.
template <typename AnyOptions, typename Visit>
void VisitOptions(AnyOptions& o, Visit&& visit) {
  visit("max_seeds", o.max_seeds);
  visit("box_margin", o.box_margin);
  visit("levels", o.levels);
  visit("plant_every", o.plant_every);
  visit("min_move", o.min_move);
  visit("seed_spacing_px", o.seed_spacing_px);
  visit("cover_radius_px", o.cover_radius_px);
  visit("cover_angle_deg", o.cover_angle_deg);
  visit("min_patch_stddev", o.min_patch_stddev);
  visit("min_coarse_stddev", o.min_coarse_stddev);
  visit("max_texture_offset_px", o.max_texture_offset_px);
  visit("prior_a", o.prior_a);
  visit("prior_b", o.prior_b);
  visit("coordinate", o.coordinate);
  visit("search", o.search);
  visit("search_radius_px", o.search_radius_px);
  visit("search_sigmas", o.search_sigmas);
  visit("search_radius_max_px", o.search_radius_max_px);
  visit("min_ncc", o.min_ncc);
  visit("ambiguity_ncc", o.ambiguity_ncc);
  visit("min_parallax_px", o.min_parallax_px);
  visit("warp_roll_deg", o.warp_roll_deg);
  visit("warp_scale", o.warp_scale);
  visit("measurement_sigma_px", o.measurement_sigma_px);
  visit("image_noise", o.image_noise);
  visit("max_measurement_sigma_px", o.max_measurement_sigma_px);
  visit("match_bias_px", o.match_bias_px);
  visit("epipolar_error_px", o.epipolar_error_px);
  visit("outlier_density", o.outlier_density);
  visit("eta_outlier", o.eta_outlier);
  visit("outlier_certainty", o.outlier_certainty);
  visit("eta_inlier", o.eta_inlier);
  visit("epsilon_range", o.epsilon_range);
  visit("epsilon_px", o.epsilon_px);
  visit("min_views", o.min_views);
  visit("min_side_ncc", o.min_side_ncc);
  visit("max_age", o.max_age);
  visit("max_unseen", o.max_unseen);
  visit("overhang_px", o.overhang_px);
  visit("regularise_px", o.regularise_px);
  visit("min_support", o.min_support);
  visit("rim_px", o.rim_px);
  visit("threads", o.threads);
  visit("backend", o.backend);
}

/// Sets an option from text: numbers, or the enumerators "depth", "inverse-depth"; "range",
/// "window"; "auto", "window", "full"; "cpu",
/// "cuda", "auto". @throws std::invalid_argument naming option and value.
void SetOption(Options* options, const std::string& name, const std::string& value);

/// The option's value as SetOption takes it. @throws std::invalid_argument for an unknown name.
std::string GetOption(const Options& options, const std::string& name);

/// Algorithm 1 and its constants as published. Where the text leaves a choice: the threshold
/// "1/10,000th of the bounding volume size" is called one of variance and one of sigma_n. Read as
/// sigma < range / 10,000, seeds need hundreds of frames; read as a variance in units of the range
/// squared, sigma < range / 100, a dozen. The "few tenths of a second" that the paper reports fit
/// sigma between range / 300 and range / 1000: here range / 500. The sub-pixel position of a
/// maximum is the parabola's, as in all presets.
Options PaperOptions();

/// Our own choices; the reasons are in docs/algorithm.md.
Options DefaultOptions();

/// "paper" or "default". @throws std::invalid_argument for any other name.
Options OptionsFromPreset(const std::string& name);

}  // namespace livemvs
