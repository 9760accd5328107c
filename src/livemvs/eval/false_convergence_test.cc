#include "livemvs/eval/false_convergence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace livemvs {
namespace {

using ::testing::HasSubstr;

// A wall at z = 2 that covers x < 0.5 alone, seen by a turned and moved camera.
TriangleMesh HalfWall() {
  TriangleMesh mesh;
  mesh.vertices = {{-20, -20, 2}, {0.5F, -20, 2}, {0.5F, 20, 2}, {-20, 20, 2}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Camera WideCamera() {
  Camera camera;
  camera.width = 80;
  camera.height = 60;
  camera.fx = camera.fy = 70;
  camera.cx = 39.5;
  camera.cy = 29.5;
  return camera;
}

// Left half of the picture textureless, upper half repetitive, the first column an edge.
LabelledView View(std::int64_t frame) {
  LabelledView view;
  view.frame = frame;
  view.camera = WideCamera();
  view.cam_from_world.rotation =
      Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  view.cam_from_world.translation = {0.1, -0.05, 0.3};
  view.labels = Image<std::uint8_t>(80, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      view.labels(x, y) = static_cast<std::uint8_t>((x < 40 ? kLabelTextureless : 0) |
                                                    (y < 30 ? kLabelRepetitive : 0) |
                                                    (x == 0 ? kLabelOccludingEdge : 0));
    }
  }
  return view;
}

// Distance along a pixel's ray to the plane z = 2, by algebra.
double TrueDepth(const LabelledView& view, int x, int y) {
  const Eigen::Vector3d ray(
      (x - view.camera.cx) / view.camera.fx, (y - view.camera.cy) / view.camera.fy, 1);
  const Eigen::Vector3d direction =
      view.cam_from_world.rotation.transpose() * Eigen::Vector3d(ray.normalized());
  return (2 - view.cam_from_world.Center().z()) / direction.z();
}

SeedRecord Seed(const LabelledView& view, int x, int y, Fate fate, double relative_error) {
  return {.birth_frame = view.frame,
          .x = static_cast<float>(x),
          .y = static_cast<float>(y),
          .end_frame = view.frame + 5,
          .fate = fate,
          .views = 7,
          .depth = static_cast<float>(TrueDepth(view, x, y) * (1 + relative_error)),
          .sigma = 0.1F};
}

const ConvergenceCounts& Of(const FalseConvergence& result, const std::string& key) {
  for (std::size_t i = 0; i < kLabelClasses.size(); ++i) {
    if (kLabelClasses[i].key == key) return result.classes[i];
  }
  throw std::invalid_argument(key);
}

class FalseConvergenceTest : public testing::Test {
 protected:
  FalseConvergence Measure(double tolerance = 0.01) const { return Measure(surface_, tolerance); }

  FalseConvergence Measure(const MeshSurface& surface, double tolerance) const {
    std::vector<LabelledView> views;
    views.push_back(View(8));
    views.push_back(View(3));
    return MeasureFalseConvergence(seeds_, views, surface, {.tolerance = tolerance});
  }

  MeshSurface surface_{HalfWall()};
  LabelledView view_ = View(8);
  std::vector<SeedRecord> seeds_{
      // Textureless alone: six planted, of them three converged, two falsely.
      Seed(view_, 3, 40, Fate::kConverged, 0.002),
      Seed(view_, 9, 44, Fate::kConverged, 0.02),
      Seed(view_, 12, 50, Fate::kConverged, -0.5),
      Seed(view_, 15, 50, Fate::kOutlier, 0.5),
      Seed(view_, 20, 58, Fate::kAged, 0.5),
      Seed(view_, 0, 59, Fate::kAlive, 0.5),
      // Textureless and repetitive: one that converged falsely.
      Seed(view_, 10, 10, Fate::kConverged, 0.011),
      // No label: one that converged truly, as far as the threshold goes.
      Seed(view_, 41, 35, Fate::kConverged, -0.0095),
      // From a frame without labels.
      Seed(View(9), 10, 10, Fate::kConverged, 0.3),
  };
};

TEST_F(FalseConvergenceTest, KnownAnswers) {
  const FalseConvergence result = Measure();
  EXPECT_EQ(result.views, 2U);
  EXPECT_EQ(result.judged, 8U);
  EXPECT_EQ(result.not_judged, 1U);
  const ConvergenceCounts& plain = Of(result, "textureless");
  EXPECT_EQ(plain.planted, 7U);
  EXPECT_EQ(plain.converged, 4U);
  EXPECT_EQ(plain.falsely_converged, 3U);
  EXPECT_DOUBLE_EQ(plain.FalseRate(), 3.0 / 7);
  EXPECT_DOUBLE_EQ(plain.FalseShare(), 0.75);
  ASSERT_EQ(plain.errors.size(), 4U);
  constexpr float kRounding = 1e-5F;  // single precision, a few operations
  EXPECT_NEAR(plain.errors[0], 0.002F, kRounding);
  EXPECT_NEAR(plain.errors[1], 0.011F, kRounding);
  EXPECT_NEAR(plain.errors[2], 0.02F, kRounding);
  EXPECT_NEAR(plain.errors[3], 0.5F, kRounding);
  EXPECT_EQ(Of(result, "textureless_off_edges").planted, 6U);
  EXPECT_EQ(Of(result, "textureless_off_edges").falsely_converged, 3U);
  EXPECT_EQ(Of(result, "occluding_edge").planted, 1U);
  EXPECT_EQ(Of(result, "repetitive").planted, 1U);
  EXPECT_EQ(Of(result, "repetitive").falsely_converged, 1U);
  EXPECT_EQ(Of(result, "textureless_or_occluded").planted, 7U);
  EXPECT_EQ(Of(result, "any_label").planted, 7U);
  EXPECT_EQ(Of(result, "no_label").planted, 1U);
  EXPECT_EQ(Of(result, "no_label").falsely_converged, 0U);
  EXPECT_EQ(Of(result, "specular").planted, 0U);
  EXPECT_EQ(Of(result, "specular").FalseRate(), 0);
  EXPECT_EQ(Of(result, "specular").FalseShare(), 0);
}

TEST_F(FalseConvergenceTest, SeedsWhosePointsWereTakenOutHaveConvergedAllTheSame) {
  const FalseConvergence before = Measure();
  for (const int i : {0, 1, 6}) seeds_[i].fate = Fate::kTakenOut;  // one is right, two are false
  const FalseConvergence result = Measure();
  for (const char* key : {"textureless", "repetitive", "no_label"}) {
    const ConvergenceCounts& was = Of(before, key);
    EXPECT_EQ(was.points, was.converged) << key;
    EXPECT_EQ(was.false_points, was.falsely_converged) << key;
    EXPECT_EQ(Of(result, key).converged, was.converged) << key;
    EXPECT_EQ(Of(result, key).falsely_converged, was.falsely_converged) << key;
    EXPECT_EQ(Of(result, key).errors, was.errors) << key;
  }
  EXPECT_EQ(Of(result, "textureless").points, 1U);
  EXPECT_EQ(Of(result, "textureless").false_points, 1U);
  EXPECT_DOUBLE_EQ(Of(result, "textureless").FalsePointRate(), 1.0 / 7);
  EXPECT_EQ(Of(result, "repetitive").points, 0U);
  EXPECT_EQ(Of(result, "specular").FalsePointRate(), 0);
}

TEST_F(FalseConvergenceTest, TheToleranceDecides) {
  EXPECT_EQ(Of(Measure(0.009), "no_label").falsely_converged, 1U);
  EXPECT_EQ(Of(Measure(0.03), "textureless").falsely_converged, 1U);
  for (const double bad : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    EXPECT_THROW(Measure(bad), std::invalid_argument) << bad;
  }
}

TEST_F(FalseConvergenceTest, WhereNothingIsEveryConvergenceIsFalse) {
  // Right of x = 0.5 there is no wall: the camera looks past it.
  const int x = 75, y = 35;
  seeds_ = {Seed(view_, x, y, Fate::kConverged, 0), Seed(view_, x, y, Fate::kOutlier, 0)};
  const FalseConvergence result = Measure();
  EXPECT_EQ(Of(result, "no_label").planted, 2U);
  EXPECT_EQ(Of(result, "no_label").falsely_converged, 1U);
  EXPECT_TRUE(Of(result, "no_label").errors.empty());
}

TEST_F(FalseConvergenceTest, TellsANeighboursDepthFromAPhantom) {
  // Before the wall hangs a strip as wide as three pixels, about the column of pixel 20.
  TriangleMesh mesh = HalfWall();
  const Rigid3d world_from_cam = view_.cam_from_world.Inverse();
  const auto corner = [&](double x, double y) {
    const Camera& c = view_.camera;
    const Eigen::Vector3d in_cam((x - c.cx) / c.fx, (y - c.cy) / c.fy, 1);
    return Eigen::Vector3f((world_from_cam * in_cam).cast<float>());
  };
  for (const auto& [x, y] : {std::pair{18.5, -5}, {21.5, -5}, {21.5, 65}, {18.5, 65}}) {
    mesh.vertices.push_back(corner(x, y));
  }
  mesh.faces.insert(mesh.faces.end(), {{4, 5, 6}, {4, 6, 7}});
  // The strip's z depth is 1; of pixels left of it the patch ends on its edge, or just before it.
  const auto on_strip = [&](int x, int y) {
    SeedRecord seed = Seed(view_, x, y, Fate::kConverged, 0);
    const Camera& c = view_.camera;
    seed.depth =
        static_cast<float>(Eigen::Vector3d((x - c.cx) / c.fx, (y - c.cy) / c.fy, 1).norm());
    return seed;
  };
  seeds_ = {on_strip(20, 40),                              // true
            on_strip(17, 40),                              // beside
            on_strip(16, 40),                              // too far away: a phantom
            Seed(view_, 17, 40, Fate::kConverged, -0.2)};  // at neither depth: a phantom
  const FalseConvergence result = Measure(MeshSurface(mesh), 0.01);
  const ConvergenceCounts& plain = Of(result, "textureless");
  EXPECT_EQ(plain.converged, 4U);
  EXPECT_EQ(plain.falsely_converged, 3U);
  EXPECT_EQ(plain.beside, 1U);
  EXPECT_DOUBLE_EQ(plain.FalseRate(), 0.75);
  EXPECT_DOUBLE_EQ(plain.PhantomRate(), 0.5);
}

TEST_F(FalseConvergenceTest, RefusesLabelsThatDoNotFit) {
  std::vector<LabelledView> twice;
  twice.push_back(View(8));
  twice.push_back(View(8));
  EXPECT_THROW(MeasureFalseConvergence(seeds_, twice, surface_, {}), std::invalid_argument);
  std::vector<LabelledView> small;
  small.push_back(View(8));
  small[0].labels = Image<std::uint8_t>(79, 60);
  EXPECT_THROW(MeasureFalseConvergence(seeds_, small, surface_, {}), std::invalid_argument);
}

TEST_F(FalseConvergenceTest, TableAndJsonSayTheSame) {
  const FalseConvergence result = Measure();
  const std::string table = FalseConvergenceTable(result, {});
  EXPECT_THAT(table, HasSubstr("more than 1 %"));
  EXPECT_THAT(table, HasSubstr("42.86%"));  // 3 / 7
  EXPECT_THAT(table, HasSubstr("75.00%"));
  const auto json = nlohmann::json::parse(FalseConvergenceJson(result, {}));
  EXPECT_EQ(json["tolerance"], 0.01);
  EXPECT_EQ(json["labelled_frames"], 2);
  EXPECT_EQ(json["seeds_judged"], 8);
  EXPECT_EQ(json["seeds_not_judged"], 1);
  const auto& plain = json["labels"]["textureless"];
  EXPECT_EQ(plain["planted"], 7);
  EXPECT_EQ(plain["converged"], 4);
  EXPECT_EQ(plain["false"], 3);
  EXPECT_DOUBLE_EQ(plain["false_of_planted"], 3.0 / 7);
  EXPECT_DOUBLE_EQ(plain["false_of_converged"], 0.75);
  EXPECT_NEAR(plain["error_percentiles"]["50"], 0.0155, 1e-5);
  EXPECT_TRUE(json["labels"]["specular"]["error_percentiles"]["99"].is_null());
}

}  // namespace
}  // namespace livemvs
