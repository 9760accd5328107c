#include "livemvs/core/options.h"

#include <charconv>
#include <sstream>
#include <stdexcept>
#include <type_traits>

namespace livemvs {
namespace {

template <typename E>
struct EnumName {
  E value;
  const char* name;
};
constexpr EnumName<DepthCoordinate> kCoordinates[] = {
    {DepthCoordinate::kDepth, "depth"}, {DepthCoordinate::kInverseDepth, "inverse-depth"}};
constexpr EnumName<OutlierDensity> kDensities[] = {{OutlierDensity::kRange, "range"},
                                                   {OutlierDensity::kWindow, "window"}};
constexpr EnumName<Search> kSearches[] = {
    {Search::kAuto, "auto"}, {Search::kWindow, "window"}, {Search::kFull, "full"}};
constexpr EnumName<BackendChoice> kBackends[] = {
    {BackendChoice::kCpu, "cpu"}, {BackendChoice::kCuda, "cuda"}, {BackendChoice::kAuto, "auto"}};

template <typename T>
bool ParseNumber(const std::string& text, T* value) {
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, *value);
  return result.ec == std::errc() && result.ptr == end;
}

template <typename E, std::size_t N>
bool ParseEnum(const EnumName<E> (&names)[N], const std::string& text, E* value) {
  for (const auto& entry : names) {
    if (text == entry.name) {
      *value = entry.value;
      return true;
    }
  }
  return false;
}

template <typename E, std::size_t N>
std::string NameOf(const EnumName<E> (&names)[N], E value) {
  for (const auto& entry : names) {
    if (entry.value == value) return entry.name;
  }
  return "?";
}

bool Parse(const std::string& text, int* value) { return ParseNumber(text, value); }
bool Parse(const std::string& text, float* value) { return ParseNumber(text, value); }
bool Parse(const std::string& text, DepthCoordinate* value) {
  return ParseEnum(kCoordinates, text, value);
}
bool Parse(const std::string& text, OutlierDensity* value) {
  return ParseEnum(kDensities, text, value);
}
bool Parse(const std::string& text, Search* value) { return ParseEnum(kSearches, text, value); }
bool Parse(const std::string& text, BackendChoice* value) {
  return ParseEnum(kBackends, text, value);
}

template <typename T>
std::string Print(T value) {
  std::ostringstream out;
  out << value;
  return out.str();
}
std::string Print(DepthCoordinate value) { return NameOf(kCoordinates, value); }
std::string Print(OutlierDensity value) { return NameOf(kDensities, value); }
std::string Print(Search value) { return NameOf(kSearches, value); }
std::string Print(BackendChoice value) { return NameOf(kBackends, value); }

template <typename T>
void Require(bool ok, const char* option, T value, const std::string& allowed) {
  if (ok) return;
  throw std::invalid_argument(std::string("option ") + option + " = " + Print(value) + " must be " +
                              allowed);
}

template <typename T>
void Within(std::type_identity_t<T> least,
            T value,
            std::type_identity_t<T> most,
            const char* option) {
  Require(value >= least && value <= most, option, value, Print(least) + " ... " + Print(most));
}

template <typename T>
void AtLeast(std::type_identity_t<T> least, T value, const char* option) {
  Require(value >= least, option, value, Print(least) + " or more");
}

void CheckPool(const Options& o) {
  Within(1, o.max_seeds, 64'000'000, "max_seeds");
  Within(1, o.levels, 6, "levels");
  Within(0, o.plant_every, 1000, "plant_every");
  Require(o.min_move >= 0 && o.min_move < 1, "min_move", o.min_move, "in [0, 1)");
  Within(1, o.seed_spacing_px, 64, "seed_spacing_px");
  Within(-1, o.cover_radius_px, 64, "cover_radius_px");
  Require(o.cover_angle_deg > 0 && o.cover_angle_deg <= 180,
          "cover_angle_deg",
          o.cover_angle_deg,
          "in (0, 180]");
  Within(0, o.min_patch_stddev, 128, "min_patch_stddev");
  Within(0, o.min_coarse_stddev, 128, "min_coarse_stddev");
  Within(0, o.max_texture_offset_px, 3, "max_texture_offset_px");
  Within(0, o.box_margin, 1, "box_margin");
  Require(o.prior_a > 0 && o.prior_a < 1e4F, "prior_a", o.prior_a, "in (0, 10000)");
  Require(o.prior_b > 0 && o.prior_b < 1e4F, "prior_b", o.prior_b, "in (0, 10000)");
}

void CheckMatching(const Options& o) {
  Within(1, o.search_radius_px, 1000, "search_radius_px");
  AtLeast(0, o.search_sigmas, "search_sigmas");
  Require(o.search_radius_max_px >= o.search_radius_px && o.search_radius_max_px <= 2000,
          "search_radius_max_px",
          o.search_radius_max_px,
          "search_radius_px ... 2000");
  Require(o.min_ncc >= -1 && o.min_ncc < 1, "min_ncc", o.min_ncc, "in [-1, 1)");
  AtLeast(0, o.ambiguity_ncc, "ambiguity_ncc");
  AtLeast(0, o.min_parallax_px, "min_parallax_px");
  AtLeast(0, o.warp_roll_deg, "warp_roll_deg");
  Require(o.warp_scale >= 1 || o.warp_scale == 0, "warp_scale", o.warp_scale, "1 or more, or 0");
  Require(o.measurement_sigma_px > 0, "measurement_sigma_px", o.measurement_sigma_px, "positive");
  AtLeast(0, o.match_bias_px, "match_bias_px");
  AtLeast(0, o.epipolar_error_px, "epipolar_error_px");
  AtLeast(0, o.image_noise, "image_noise");
  Require(o.max_measurement_sigma_px >= o.measurement_sigma_px,
          "max_measurement_sigma_px",
          o.max_measurement_sigma_px,
          "at least measurement_sigma_px");
}

void CheckEnding(const Options& o) {
  Require(o.eta_outlier >= 0 && o.eta_outlier < 1, "eta_outlier", o.eta_outlier, "in [0, 1)");
  Require(o.outlier_certainty > 0.5F && o.outlier_certainty < 1,
          "outlier_certainty",
          o.outlier_certainty,
          "in (0.5, 1)");
  Require(o.eta_inlier >= 0 && o.eta_inlier < 1, "eta_inlier", o.eta_inlier, "in [0, 1)");
  AtLeast(0, o.epsilon_range, "epsilon_range");
  Require(o.epsilon_px > 0 || (o.epsilon_px == 0 && o.epsilon_range > 0),
          "epsilon_px",
          o.epsilon_px,
          "positive, or 0 with a positive epsilon_range");
  Within(0, o.min_views, 255, "min_views");
  Require(o.min_side_ncc >= -1 && o.min_side_ncc < 1, "min_side_ncc", o.min_side_ncc, "in [-1, 1)");
  Within(0, o.max_age, 65534, "max_age");
  Within(0, o.max_unseen, 254, "max_unseen");
}

}  // namespace

void SetOption(Options* options, const std::string& name, const std::string& value) {
  bool known = false;
  bool understood = false;
  VisitOptions(*options, [&](const char* field_name, auto& field) {
    if (name != field_name) return;
    known = true;
    understood = Parse(value, &field);
  });
  if (!known) throw std::invalid_argument("option '" + name + "' is unknown");
  if (!understood) {
    throw std::invalid_argument("option " + name + " cannot be '" + value + "'");
  }
}

std::string GetOption(const Options& options, const std::string& name) {
  std::string value;
  bool known = false;
  VisitOptions(options, [&](const char* field_name, const auto& field) {
    if (name != field_name) return;
    known = true;
    value = Print(field);
  });
  if (!known) throw std::invalid_argument("option '" + name + "' is unknown");
  return value;
}

void Options::Check() const {
  CheckPool(*this);
  CheckMatching(*this);
  CheckEnding(*this);
  Within(0, overhang_px, 1000, "overhang_px");
  Within(0, regularise_px, 100, "regularise_px");
  Within(0, min_support, 16, "min_support");
  Within(0, rim_px, 100, "rim_px");
  Within(0, threads, 1024, "threads");
}

Options PaperOptions() {
  Options o;
  o.box_margin = 0;
  o.levels = 1;
  o.plant_every = 1;
  o.min_move = 0;
  o.cover_radius_px = 1;
  o.min_patch_stddev = 0;
  o.max_texture_offset_px = 0;
  o.prior_a = 10;
  o.prior_b = 10;
  o.coordinate = DepthCoordinate::kDepth;
  o.search = Search::kWindow;
  o.search_radius_px = 3;
  o.search_sigmas = 0;
  o.search_radius_max_px = 3;
  o.min_ncc = -1;
  o.ambiguity_ncc = 0;
  o.warp_roll_deg = 0;
  o.warp_scale = 0;
  o.measurement_sigma_px = 1;
  o.image_noise = 0;
  o.match_bias_px = 0;
  o.epipolar_error_px = 0;
  o.outlier_density = OutlierDensity::kRange;
  o.eta_outlier = 0.05F;
  o.outlier_certainty = 0.99F;
  o.eta_inlier = 0.1F;
  o.epsilon_range = 0.002F;
  o.epsilon_px = 0;
  o.min_views = 0;
  o.min_side_ncc = -1;
  o.max_age = 0;
  o.max_unseen = 0;
  o.overhang_px = 0;
  o.regularise_px = 0;
  o.min_support = 0;
  o.rim_px = 0;
  return o;
}

Options DefaultOptions() { return Options(); }

Options OptionsFromPreset(const std::string& name) {
  if (name == "default") return DefaultOptions();
  if (name == "paper") return PaperOptions();
  throw std::invalid_argument("preset '" + name + "' is unknown; there are 'default' and 'paper'");
}

}  // namespace livemvs
