#include "livemvs/mesh/color_mesh.h"

#include <gtest/gtest.h>

#include "livemvs/mesh/mesh_test_util.h"

namespace livemvs {
namespace {

/// A picture of one grey value.
PosedFrame GreyFrame(const PosedCamera& camera, std::uint8_t grey) {
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(camera.camera.width, camera.camera.height);
  for (int y = 0; y < camera.camera.height; ++y) {
    for (int x = 0; x < camera.camera.width; ++x) picture->grey(x, y) = grey;
  }
  picture->full_range = true;
  PosedFrame frame;
  frame.picture = picture;
  frame.camera = camera.camera;
  frame.cam_from_world = camera.cam_from_world;
  return frame;
}

/// A square of side 0.2 at height z, facing up, of n x n quads.
void AddSquare(float z, float half, int n, TriangleMesh* mesh) {
  const auto first = static_cast<int>(mesh->vertices.size());
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      mesh->vertices.emplace_back(half * (2.0F * static_cast<float>(x) / static_cast<float>(n) - 1),
                                  half * (2.0F * static_cast<float>(y) / static_cast<float>(n) - 1),
                                  z);
      if (x == n || y == n) continue;
      const int at = first + y * (n + 1) + x;
      mesh->faces.emplace_back(at, at + 1, at + n + 2);
      mesh->faces.emplace_back(at, at + n + 2, at + n + 1);
    }
  }
}

TEST(MeshColorizer, TakesTheMedianOfViews) {
  TriangleMesh mesh;
  AddSquare(0, 0.1F, 4, &mesh);
  MeshColorizer colorizer(mesh, 0.001);
  const PosedCamera above = LookAt({0.01, 0, 0.5}, {0, 0, 0});
  for (const int grey : {100, 102, 98, 250, 101}) {
    colorizer.AddFrame(GreyFrame(above, static_cast<std::uint8_t>(grey)));
  }
  EXPECT_EQ(colorizer.seen(), mesh.vertices.size());
  for (const Rgb& color : colorizer.Take(std::vector<Rgb>(mesh.vertices.size()))) {
    for (const std::uint8_t c : color) EXPECT_NEAR(c, 100, 2);
  }
}

TEST(MeshColorizer, LeavesOutWhatIsHiddenBehindOrOutside) {
  TriangleMesh mesh;
  AddSquare(0, 0.1F, 4, &mesh);
  const std::size_t low = mesh.vertices.size();
  AddSquare(0.1F, 0.05F, 1, &mesh);  // hides the middle
  MeshColorizer colorizer(mesh, 0.001);
  colorizer.AddFrame(GreyFrame(LookAt({0.001, 0, 0.5}, {0, 0, 0}), 100));
  colorizer.AddFrame(GreyFrame(LookAt({0.001, 0, -0.5}, {0, 0, 0}), 50));     // sees the backs
  colorizer.AddFrame(GreyFrame(LookAt({0.001, 0, 0.5}, {0.001, 0, 1}), 50));  // looks away
  const std::vector<Rgb> colors =
      colorizer.Take(std::vector<Rgb>(mesh.vertices.size(), Rgb{1, 2, 3}));
  for (std::size_t i = 0; i < low; ++i) {
    const Eigen::Vector3f& v = mesh.vertices[i];
    const bool hidden = std::max(std::abs(v.x()), std::abs(v.y())) < 0.06F;
    EXPECT_EQ(colors[i], hidden ? (Rgb{1, 2, 3}) : (Rgb{100, 100, 100})) << v.transpose();
  }
  for (std::size_t i = low; i < colors.size(); ++i) EXPECT_EQ(colors[i], (Rgb{100, 100, 100}));
}

TEST(ColorsOfPoints, BlendTheNearest) {
  TriangleMesh mesh;
  AddSquare(0, 0.1F, 1, &mesh);
  SightLines points;
  points.spacing = 0.01;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    for (int i = 0; i < 6; ++i) {
      SightLine line;
      line.position = v + Eigen::Vector3f(0, 0, 0.001F * static_cast<float>(i));
      points.lines.push_back(line);
      points.colors.push_back(v.x() > 0 ? Rgb{10, 200, 30} : Rgb{90, 0, 255});
    }
  }
  const std::vector<Rgb> colors = ColorsOfPoints(mesh, points);
  for (std::size_t i = 0; i < colors.size(); ++i) {
    EXPECT_EQ(colors[i], mesh.vertices[i].x() > 0 ? (Rgb{10, 200, 30}) : (Rgb{90, 0, 255}));
  }
}

TEST(SharpnessOf, IsLessWhereAPictureIsBlurred) {
  Picture sharp, flat;
  sharp.grey = Image<std::uint8_t>(64, 64);
  flat.grey = Image<std::uint8_t>(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      sharp.grey(x, y) = (x / 3 + y / 3) % 2 == 0 ? 200 : 50;
      flat.grey(x, y) = static_cast<std::uint8_t>(x + y);
    }
  }
  EXPECT_GT(SharpnessOf(sharp), 10 * (SharpnessOf(flat) + 1));
}

}  // namespace
}  // namespace livemvs
