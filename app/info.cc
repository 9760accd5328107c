#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "commands.h"
#include "dataset_options.h"
#include "livemvs/backend/backend.h"
#include "livemvs/backend/cuda/cuda_backend.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/dataset_consistency.h"

namespace livemvs::app {
namespace {

using nlohmann::json;

struct InfoOptions {
  DatasetOptions dataset;
  bool as_json = false;
  bool quick = false;
  bool devices = false;
};

std::array<double, 3> ToArray(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

json DescribeCamera(const std::vector<DatasetView>& views) {
  const Camera& c = views.front().camera;
  const bool all_same = std::all_of(views.begin(), views.end(), [&](const DatasetView& v) {
    return v.camera.fx == c.fx && v.camera.fy == c.fy && v.camera.cx == c.cx &&
           v.camera.cy == c.cy && v.camera.distortion == c.distortion;
  });
  return {{"model", ToString(c.model)},
          {"width", c.width},
          {"height", c.height},
          {"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"distortion", c.distortion},
          {"same_for_all_frames", all_same}};
}

// The box of the middle 98 % of points, so that single stray ones do not count.
Box RobustBounds(const std::vector<Eigen::Vector3d>& points) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    values.reserve(points.size());
    for (const Eigen::Vector3d& p : points) values.push_back(p[k]);
    box.min[k] = Quantile(values, 0.01);
    box.max[k] = Quantile(values, 0.99);
  }
  return box;
}

// What the cameras are known to look at: corners of the box, or some of the sparse points.
std::vector<Eigen::Vector3d> Targets(const Dataset& dataset) {
  std::vector<Eigen::Vector3d> targets;
  if (const std::optional<Box> box = dataset.box()) {
    targets.push_back(0.5 * (box->min + box->max));
    return targets;
  }
  constexpr std::size_t kEnough = 200;
  const auto& points = dataset.sparse_points();
  const std::size_t stride = points.size() / kEnough + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) targets.push_back(points[i]);
  return targets;
}

json DescribePath(const Dataset& dataset) {
  const auto& views = dataset.views();
  const std::vector<Eigen::Vector3d> targets = Targets(dataset);
  std::vector<double> steps, parallax;
  Box extent{views[0].cam_from_world.Center(), views[0].cam_from_world.Center()};
  for (std::size_t i = 1; i < views.size(); ++i) {
    const Eigen::Vector3d a = views[i - 1].cam_from_world.Center();
    const Eigen::Vector3d b = views[i].cam_from_world.Center();
    extent.min = extent.min.cwiseMin(b);
    extent.max = extent.max.cwiseMax(b);
    steps.push_back((b - a).norm());
    for (const Eigen::Vector3d& p : targets) {
      const Eigen::Vector3d u = p - a, v = p - b;
      parallax.push_back(std::atan2(u.cross(v).norm(), u.dot(v)) * views[i].camera.fx);
    }
  }
  double length = 0;
  for (const double step : steps) length += step;
  json path = {{"length", length},
               {"median_step", Quantile(steps, 0.5)},
               {"largest_step", Quantile(steps, 1)},
               {"min", ToArray(extent.min)},
               {"max", ToArray(extent.max)}};
  if (!parallax.empty()) path["median_step_parallax_px"] = Quantile(parallax, 0.5);
  return path;
}

// Share of (view, target) pairs in which the target is in front of the camera and in the picture.
std::optional<double> VisibleShare(const Dataset& dataset) {
  const std::vector<Eigen::Vector3d> targets = Targets(dataset);
  if (targets.empty()) return std::nullopt;
  constexpr std::size_t kEnough = 50;
  const auto& views = dataset.views();
  std::size_t seen = 0, all = 0;
  for (std::size_t i = 0; i < views.size(); i += views.size() / kEnough + 1) {
    const Projector projector(views[i].camera);
    for (const Eigen::Vector3d& p : targets) {
      const auto pixel = projector.Project(views[i].cam_from_world * p);
      seen += pixel && views[i].camera.Contains(*pixel) ? 1 : 0;
      ++all;
    }
  }
  return static_cast<double>(seen) / static_cast<double>(all);
}

EpipolarReport CheckPictures(Dataset& dataset) {
  constexpr std::size_t kFrames = 40;
  std::vector<PosedFrame> frames;
  while (frames.size() < kFrames) {
    std::optional<PosedFrame> frame = dataset.Next();
    if (!frame) break;
    frames.push_back(std::move(*frame));
  }
  return CheckEpipolarConsistency(frames);
}

json DescribeCheck(const EpipolarReport& report) {
  json check = {{"matches", report.matches}, {"conclusive", report.conclusive()}};
  if (!report.conclusive()) return check;
  for (std::size_t r = 0; r < kPoseReadings; ++r) {
    check["median_epipolar_error_px"][ToString(static_cast<PoseReading>(r))] =
        report.median_error_px[r];
  }
  return check;
}

void WarnOfPath(const json& path, json& warnings) {
  const double median = path["median_step"], largest = path["largest_step"];
  if (path["length"].get<double>() == 0) {
    warnings.push_back("the camera does not move; no depth can be measured");
  } else if (median == 0) {
    warnings.push_back("most frames stand where the one before stood; are poses repeated?");
  } else if (largest > 20 * median) {
    warnings.push_back("the largest step between frames is " + std::to_string(largest / median) +
                       " times the median; does the path jump?");
  }
}

void WarnOfCheck(const EpipolarReport& report, json& warnings) {
  if (!report.conclusive()) return;
  constexpr double kPoorError = 2;  // [px]
  if (report.suggests_other()) {
    warnings.push_back("the pictures agree better with the poses " + ToString(report.best) +
                       "; try another --pose-convention (cam-from-world, world-from-cam, "
                       "world-from-cam-opengl)");
  } else if (report.median_error_px[0] > kPoorError) {
    warnings.push_back("the pictures disagree with poses and calibration by " +
                       std::to_string(report.median_error_px[0]) +
                       " px; are they of this recording, at this size?");
  }
}

json Describe(Dataset& dataset, bool quick) {
  json info = {{"description", dataset.description()},
               {"frames", dataset.views().size()},
               {"first_frame", dataset.views().front().name},
               {"last_frame", dataset.views().back().name},
               {"camera", DescribeCamera(dataset.views())},
               {"path", DescribePath(dataset)},
               {"warnings", json::array()}};
  if (const std::optional<Box> box = dataset.box()) {
    info["box"] = {{"min", ToArray(box->min)}, {"max", ToArray(box->max)}};
  }
  if (!dataset.sparse_points().empty()) {
    const Box bounds = RobustBounds(dataset.sparse_points());
    info["sparse_points"] = {{"count", dataset.sparse_points().size()},
                             {"min", ToArray(bounds.min)},
                             {"max", ToArray(bounds.max)}};
  }
  WarnOfPath(info["path"], info["warnings"]);
  const std::optional<double> visible = VisibleShare(dataset);
  if (visible) info["visible_share"] = *visible;
  if (visible && *visible < 0.25) {
    info["warnings"].push_back(
        "most of the known points or box lie outside of the pictures; do "
        "poses and points share one world?");
  }
  if (!quick) {
    const EpipolarReport report = CheckPictures(dataset);
    info["check"] = DescribeCheck(report);
    WarnOfCheck(report, info["warnings"]);
  }
  info["skipped"] = dataset.statistics().skipped;
  return info;
}

std::string Format(const json& v) {
  char text[128];
  std::snprintf(text,
                sizeof(text),
                "(%.4g %.4g %.4g)",
                v[0].get<double>(),
                v[1].get<double>(),
                v[2].get<double>());
  return text;
}

void PrintCamera(const json& c) {
  std::printf("camera     %s, %d x %d px, fx %.2f fy %.2f cx %.2f cy %.2f%s\n",
              c["model"].get<std::string>().c_str(),
              c["width"].get<int>(),
              c["height"].get<int>(),
              c["fx"].get<double>(),
              c["fy"].get<double>(),
              c["cx"].get<double>(),
              c["cy"].get<double>(),
              c["same_for_all_frames"].get<bool>() ? "" : " (first frame; others differ)");
  if (c["model"] == ToString(CameraModel::kPinhole)) return;
  std::printf("distortion");
  for (const json& k : c["distortion"]) std::printf(" %.5g", k.get<double>());
  std::printf("\n");
}

void PrintPath(const json& path) {
  std::printf("path       %.4g long, median step %.4g",
              path["length"].get<double>(),
              path["median_step"].get<double>());
  if (path.contains("median_step_parallax_px")) {
    std::printf(" = %.2f px of parallax", path["median_step_parallax_px"].get<double>());
  }
  std::printf(" [scene units]\ncameras in %s to %s\n",
              Format(path["min"]).c_str(),
              Format(path["max"]).c_str());
}

void PrintCheck(const json& check) {
  if (!check["conclusive"].get<bool>()) {
    std::printf(
        "check      too few matches between neighbouring pictures (%d) to check the poses\n",
        check["matches"].get<int>());
    return;
  }
  std::printf("check      median epipolar error of %d matches:", check["matches"].get<int>());
  const char* separator = " ";
  for (const auto& [reading, error] : check["median_epipolar_error_px"].items()) {
    std::printf("%s%.2f px %s", separator, error.get<double>(), reading.c_str());
    separator = ", ";
  }
  std::printf("\n");
}

void Print(const json& info) {
  std::printf("data       %s\n", info["description"].get<std::string>().c_str());
  std::printf("frames     %d (%s ... %s), %d left out so far\n",
              info["frames"].get<int>(),
              info["first_frame"].get<std::string>().c_str(),
              info["last_frame"].get<std::string>().c_str(),
              info["skipped"].get<int>());
  PrintCamera(info["camera"]);
  PrintPath(info["path"]);
  for (const char* key : {"box", "sparse_points"}) {
    if (!info.contains(key)) continue;
    const json& box = info[key];
    const std::string count =
        box.contains("count") ? std::to_string(box["count"].get<int>()) + " points within " : "";
    std::printf("%s %s%s to %s\n",
                box.contains("count") ? "sparse    " : "box       ",
                count.c_str(),
                Format(box["min"]).c_str(),
                Format(box["max"]).c_str());
  }
  if (info.contains("check")) PrintCheck(info["check"]);
  for (const json& warning : info["warnings"]) {
    std::printf("warning    %s\n", warning.get<std::string>().c_str());
  }
  if (info["warnings"].empty()) std::printf("no inconsistency found\n");
}

json DescribeDevices() {
  const CudaDevices cuda = FindCudaDevices();
  json gpus = json::array();
  for (const CudaDevice& device : cuda.devices) {
    gpus.push_back(
        {{"name", device.name},
         {"compute_capability", std::to_string(device.major) + "." + std::to_string(device.minor)},
         {"memory_mib", device.memory >> 20},
         {"usable", device.trouble.empty()},
         {"trouble", device.trouble}});
  }
  Options cpu;
  cpu.max_seeds = 1;
  return {{"cpu", MakeCpuBackend(cpu)->name()},
          {"cores", std::thread::hardware_concurrency()},
          {"cuda", gpus},
          {"no_cuda", cuda.trouble}};
}

void PrintDevices(const json& devices) {
  std::printf("%s, %d cores    --backend cpu\n",
              devices["cpu"].get<std::string>().c_str(),
              devices["cores"].get<int>());
  for (const json& gpu : devices["cuda"]) {
    std::printf("%s, compute capability %s, %lld MiB    %s\n",
                gpu["name"].get<std::string>().c_str(),
                gpu["compute_capability"].get<std::string>().c_str(),
                gpu["memory_mib"].get<long long>(),
                gpu["usable"].get<bool>()
                    ? "--backend cuda"
                    : ("cannot be used: " + gpu["trouble"].get<std::string>()).c_str());
  }
  if (devices["cuda"].empty()) {
    std::printf("no GPU: %s\n", devices["no_cuda"].get<std::string>().c_str());
  }
}

}  // namespace

void AddInfoCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("info", "Say what a data set is and whether it agrees");
  auto options = std::make_shared<InfoOptions>();
  AddDatasetOptions(command, &options->dataset);
  command->get_option("--data")->required(false);
  command->add_option("IN", options->dataset.data, "Data set folder, or a video");
  command->add_flag("--json", options->as_json, "Print JSON for machines");
  command->add_flag("--quick", options->quick, "Do not compare pictures with poses");
  command->add_flag("--devices", options->devices, "List what can reconstruct on this machine");
  command->footer(
      "Examples:\n"
      "  livemvs info recordings/cube\n"
      "  livemvs info --devices\n"
      "  livemvs info film.mp4 --poses trajectory.txt --camera camera.yaml --json");
  command->callback([options] {
    if (options->devices) {
      const json devices = DescribeDevices();
      if (options->as_json) {
        std::printf("%s\n", devices.dump(2).c_str());
      } else {
        PrintDevices(devices);
      }
      return;
    }
    if (options->dataset.data.empty()) throw CLI::RequiredError("IN");
    const std::unique_ptr<Dataset> dataset = OpenDataset(options->dataset);
    const json info = Describe(*dataset, options->quick);
    if (options->as_json) {
      std::printf("%s\n", info.dump(2, ' ', false, json::error_handler_t::replace).c_str());
    } else {
      Print(info);
    }
  });
}

}  // namespace livemvs::app
