#include "livemvs/core/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

namespace livemvs {
namespace {

TEST(OptionsTest, PresetsAreValid) {
  EXPECT_NO_THROW(DefaultOptions().Check());
  EXPECT_NO_THROW(PaperOptions().Check());
  EXPECT_NO_THROW(OptionsFromPreset("paper").Check());
  EXPECT_THROW(OptionsFromPreset("papier"), std::invalid_argument);
}

TEST(OptionsTest, PaperPresetHasThePapersConstants) {
  const Options o = OptionsFromPreset("paper");
  EXPECT_EQ(o.max_seeds, 250'000);        // Sec. 4
  EXPECT_EQ(o.plant_every, 1);            // Algorithm 1, step 1
  EXPECT_EQ(o.min_move, 0);               // Algorithm 1, step 2
  EXPECT_EQ(o.prior_a, 10);               // Sec. 4.2
  EXPECT_EQ(o.prior_b, 10);               // Sec. 4.2
  EXPECT_EQ(o.search_radius_px, 3);       // w, Sec. 4.2
  EXPECT_EQ(o.measurement_sigma_px, 1);   // Sec. 3
  EXPECT_FLOAT_EQ(o.eta_outlier, 0.05F);  // Sec. 4.3
  EXPECT_FLOAT_EQ(o.eta_inlier, 0.1F);    // Sec. 4.3
  EXPECT_FLOAT_EQ(o.outlier_certainty, 0.99F);
  EXPECT_EQ(o.overhang_px, 0);
  EXPECT_EQ(o.rim_px, 0);
  EXPECT_EQ(o.coordinate, DepthCoordinate::kDepth);
  EXPECT_EQ(o.outlier_density, OutlierDensity::kRange);  // Eq. (1)
  EXPECT_EQ(o.min_ncc, -1);                              // any local maximum
}

TEST(OptionsTest, CheckNamesOptionAndValue) {
  const struct {
    const char* name;
    std::function<void(Options*)> spoil;
  } cases[] = {
      {"max_seeds", [](Options* o) { o->max_seeds = 0; }},
      {"plant_every", [](Options* o) { o->plant_every = -1; }},
      {"min_move", [](Options* o) { o->min_move = -0.1F; }},
      {"min_move", [](Options* o) { o->min_move = 1; }},
      {"seed_spacing_px", [](Options* o) { o->seed_spacing_px = 0; }},
      {"prior_a", [](Options* o) { o->prior_a = 0; }},
      {"prior_b", [](Options* o) { o->prior_b = std::nanf(""); }},
      {"search_radius_px", [](Options* o) { o->search_radius_px = 0; }},
      {"search_radius_max_px", [](Options* o) { o->search_radius_max_px = 0.5F; }},
      {"min_ncc", [](Options* o) { o->min_ncc = 1; }},
      {"measurement_sigma_px", [](Options* o) { o->measurement_sigma_px = -1; }},
      {"eta_inlier", [](Options* o) { o->eta_inlier = 1; }},
      {"outlier_certainty", [](Options* o) { o->outlier_certainty = 0.2F; }},
      {"epsilon_px",
       [](Options* o) {
         o->epsilon_px = 0;
         o->epsilon_range = 0;
       }},
      {"rim_px", [](Options* o) { o->rim_px = -1; }},
      {"rim_px", [](Options* o) { o->rim_px = std::nanf(""); }},
      {"overhang_px", [](Options* o) { o->overhang_px = -1; }},
      {"overhang_px", [](Options* o) { o->overhang_px = std::nanf(""); }},
      {"max_age", [](Options* o) { o->max_age = 70'000; }},
      {"threads", [](Options* o) { o->threads = -1; }},
  };
  for (const auto& c : cases) {
    Options options;
    c.spoil(&options);
    try {
      options.Check();
      ADD_FAILURE() << c.name << " was accepted";
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr(c.name));
    }
  }
}

}  // namespace
}  // namespace livemvs
