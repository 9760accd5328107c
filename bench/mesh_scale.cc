// Time and memory of a mesh against the number of points:
//   mesh_scale POINTS [RESOLUTION_IN_SPACINGS]
// A hilly square of 2 x 2 with a half ball over it, seen by 40 cameras from above; noise of 0.7
// spacings along the lines of sight. Prints one row of a table.

#include <sys/resource.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "livemvs/mesh/build_mesh.h"

namespace {

using livemvs::MeshCameras;
using livemvs::Point;
using livemvs::PointCloud;
using livemvs::PosedCamera;

PosedCamera LookDown(const Eigen::Vector3d& center) {
  PosedCamera c;
  c.camera.width = 1920;
  c.camera.height = 1080;
  c.camera.fx = c.camera.fy = 900;
  c.camera.cx = 959.5;
  c.camera.cy = 539.5;
  c.cam_from_world.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  c.cam_from_world.translation = -(c.cam_from_world.rotation * center);
  return c;
}

double Height(double x, double y) { return 0.1 * std::sin(5 * x) * std::cos(4 * y); }

PointCloud MakeCloud(int count, double noise, const MeshCameras& cameras) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1, 1);
  std::normal_distribution<double> normal;
  PointCloud cloud;
  cloud.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p(place(random), place(random), 0);
    p.z() = Height(p.x(), p.y());
    if (i % 10 == 0) {
      p = Eigen::Vector3d(normal(random), normal(random), std::abs(normal(random))).normalized();
      p = 0.25 * p + Eigen::Vector3d(0, 0, 0.5);
    }
    Point point;
    point.frame = static_cast<std::int32_t>(random() % cameras.size());
    const Eigen::Vector3d center = cameras.at(point.frame).cam_from_world.Center();
    point.position = (p + noise * normal(random) * (center - p).normalized()).cast<float>();
    point.sigma = static_cast<float>(noise);
    point.inlier_ratio = 0.9F;
    point.color = {150, 150, 150};
    cloud.push_back(point);
  }
  return cloud;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 100'000;
  const double times = argc > 2 ? std::atof(argv[2]) : 0;
  if (count < 100) {
    std::fprintf(stderr, "usage: mesh_scale POINTS [RESOLUTION_IN_SPACINGS]\n");
    return 2;
  }
  MeshCameras cameras;
  for (int i = 0; i < 40; ++i) {
    cameras[i] = LookDown({-1.0 + 0.25 * (i % 8) + 0.1, -0.8 + 0.4 * (i / 8), 1.8});
  }
  const double spacing = std::sqrt(4.0 / count);
  const PointCloud cloud = MakeCloud(count, 0.7 * spacing, cameras);
  livemvs::MeshOptions options;
  options.resolution = times * spacing;
  const auto start = std::chrono::steady_clock::now();
  const livemvs::BuiltMesh built = livemvs::BuildMesh(cloud, cameras, options, {});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const livemvs::MeshStatistics& s = built.statistics;
  std::printf("| %d | %.2f | %zu | %zu | %.1f | %.1f | %.0f |\n",
              count,
              1000 * s.voxel,
              s.voxels,
              built.mesh.faces.size(),
              seconds,
              static_cast<double>(usage.ru_utime.tv_sec),
              static_cast<double>(usage.ru_maxrss) / 1024);
  return s.bad_edges + s.pinched + s.intersections > 0 ? 1 : 0;
}
