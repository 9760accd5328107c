// Compares a scan with exact ground truth: camera centres, where the objects' true surface is seen
// with the found and with the true poses, and the cloud.
//
//   scan_truth SCAN DATA MESH [UP [BOX]]
//
// SCAN is a folder of 'livemvs scan', or a cloud (.ply) alone, made with the true poses. DATA is
// the recording with its true poses, MESH the true surface. The scan's world is that of its sheet,
// which lies UP metres (0) above the origin of the true one. BOX: x0 y0 z0 x1 y1 z1 of what is
// judged, in the true world [m].

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/eval/evaluate.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/ply.h"
#include "livemvs/io/tum.h"
#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSurfacePoints = 20000;
constexpr std::size_t kCloudSamples = 200000;
constexpr std::uint64_t kSeed = 1;
constexpr double kSameTime = 1e-3;  // [s]; frames are further apart
constexpr double kBorder = 4;       // [px]

struct Truth {
  std::vector<DatasetView> views;
  MeshSurface surface;
  std::optional<Box> box;
  double up = 0;
};

struct Sums {
  double squares = 0, worst = 0, center_squares = 0, worst_center = 0;
  std::int64_t points = 0, frames = 0;
};

// How far apart the pixels are where the surface that the true camera sees is seen in one frame.
void AddFrame(const Truth& truth,
              const DatasetView& view,
              const std::vector<Eigen::Vector3f>& samples,
              const Rigid3d& found,
              const Projector& found_camera,
              Sums* sums) {
  EvaluationOptions options;
  options.min_cameras = 1;
  options.border_px = kBorder;
  const PosedCamera eye{view.camera, view.cam_from_world};
  const Projector true_camera(view.camera);
  double squares = 0;
  std::int64_t n = 0;
  for (const Eigen::Vector3f& sample : SeenSamples(samples, truth.surface, {&eye, 1}, options)) {
    const Eigen::Vector3d point = sample.cast<double>();
    const auto expected = true_camera.Project(view.cam_from_world * point);
    const auto seen = found_camera.Project(found * point);
    if (!expected || !seen) continue;
    squares += (*seen - *expected).squaredNorm();
    ++n;
  }
  const double center = (found.Center() - view.cam_from_world.Center()).norm();
  sums->squares += squares;
  sums->points += n;
  sums->worst = std::max(sums->worst, std::sqrt(squares / std::max(1.0, static_cast<double>(n))));
  sums->center_squares += center * center;
  sums->worst_center = std::max(sums->worst_center, center);
  ++sums->frames;
}

void ComparePoses(const fs::path& scan, const Truth& truth) {
  const Camera camera = ReadCamera((scan / "camera.yaml").string());
  const Projector projector(camera);
  const Trajectory found = ReadTumTrajectory(scan / "poses.txt", PoseConvention::kAuto);
  const auto samples = truth.surface.Sample(kSurfacePoints, kSeed, truth.box);
  Sums sums;
  for (const DatasetView& view : truth.views) {
    const auto at =
        std::lower_bound(found.times().begin(), found.times().end(), view.timestamp - kSameTime);
    if (at == found.times().end() || *at > view.timestamp + kSameTime) continue;
    Rigid3d pose = *found.At(*at);
    pose.translation -= pose.rotation * Eigen::Vector3d(0, 0, truth.up);
    AddFrame(truth, view, samples, pose, projector, &sums);
  }
  const double frames = static_cast<double>(std::max<std::int64_t>(1, sums.frames));
  std::printf("poses    %lld of %zu frames; centres %.3f mm rms, %.3f mm at worst\n",
              static_cast<long long>(sums.frames),
              truth.views.size(),
              1e3 * std::sqrt(sums.center_squares / frames),
              1e3 * sums.worst_center);
  std::printf("surface  %.3f px rms over %lld points that were seen, worst frame %.3f px\n",
              std::sqrt(sums.squares / static_cast<double>(std::max<std::int64_t>(1, sums.points))),
              static_cast<long long>(sums.points),
              sums.worst);
  std::printf("focal    %.2f px of %.2f\n", camera.fx, truth.views.front().camera.fx);
}

void CompareCloud(const fs::path& file, double up, const Truth& truth) {
  PlyContents contents = ReadPly(file);
  for (Point& point : contents.cloud) point.position.z() += static_cast<float>(up);
  std::vector<PosedCamera> cameras;
  for (std::size_t i = 0; i < truth.views.size(); i += 5) {
    cameras.push_back({truth.views[i].camera, truth.views[i].cam_from_world});
  }
  EvaluationOptions options;
  options.box = truth.box;
  options.samples = kCloudSamples;
  const Evaluation e = EvaluateAgainstMesh(contents.cloud, truth.surface, cameras, options);
  std::printf(
      "cloud    %zu points; median %.4f mm, 90 %% %.3f mm; %.1f %% within 1 mm, %.1f %% within 5 "
      "mm; %.1f %% complete at 2 mm\n",
      e.accuracy.size(),
      1e3 * Percentile(e.accuracy, 50).value_or(0),
      1e3 * Percentile(e.accuracy, 90).value_or(0),
      100 * ShareWithin(e.accuracy, 1e-3),
      100 * ShareWithin(e.accuracy, 5e-3),
      100 * ShareWithin(e.completeness, 2e-3));
}

int Main(int argc, char** argv) {
  if (argc != 4 && argc != 5 && argc != 11) {
    std::fprintf(stderr, "usage: scan_truth SCAN DATA MESH [UP [x0 y0 z0 x1 y1 z1]]\n");
    return 2;
  }
  DatasetOptions options;
  options.data = argv[2];
  Truth truth{OpenDataset(options)->views(), MeshSurface(ReadMeshPly(argv[3])), std::nullopt};
  if (argc > 4) truth.up = std::atof(argv[4]);
  if (argc == 11) {
    truth.box.emplace();
    for (int k = 0; k < 3; ++k) {
      truth.box->min[k] = std::atof(argv[5 + k]);
      truth.box->max[k] = std::atof(argv[8 + k]);
    }
  }
  const fs::path scan = argv[1];
  if (fs::is_directory(scan)) {
    ComparePoses(scan, truth);
    CompareCloud(scan / "cloud.ply", truth.up, truth);
  } else {
    CompareCloud(scan, 0, truth);
  }
  return 0;
}

}  // namespace
}  // namespace livemvs

int main(int argc, char** argv) {
  try {
    return livemvs::Main(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "scan_truth: %s\n", e.what());
    return 1;
  }
}
