#include "track_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "livemvs/io/atomic_file.h"

namespace livemvs::app {
namespace {

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

void TrackReport::Add(std::int64_t frame,
                      double timestamp,
                      const PoseEstimate& estimate,
                      double milliseconds) {
  rows_.push_back({frame, timestamp, estimate, milliseconds});
}

std::string TrackReport::commonest_problem() const {
  std::map<std::string, int> counts;
  for (const Row& row : rows_) {
    if (!row.estimate.cam_from_world) ++counts[row.estimate.problem];
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  return most == counts.end() ? "no frames" : most->first;
}

void TrackReport::Print() const {
  std::vector<double> rms, corners, sigma, times;
  std::int64_t tracked = 0, gaps = 0, longest = 0, gap = 0;
  double squares = 0;
  for (const Row& row : rows_) {
    times.push_back(row.milliseconds);
    if (!row.estimate.cam_from_world) {
      gaps += gap == 0 ? 1 : 0;
      longest = std::max(longest, ++gap);
      continue;
    }
    gap = 0;
    ++tracked;
    squares += row.estimate.rms_px * row.estimate.rms_px;
    corners.push_back(row.estimate.observations);
    sigma.push_back(row.estimate.sigma_px);
  }
  std::printf("tracked %lld of %lld frames, %lld gaps, the longest of %lld frames\n",
              static_cast<long long>(tracked),
              static_cast<long long>(frames()),
              static_cast<long long>(gaps),
              static_cast<long long>(longest));
  if (tracked > 0) {
    std::printf(
        "corners %.3f px rms, %.0f of them in the middle frame, expected error in the room above "
        "the "
        "sheet %.3f px\n",
        std::sqrt(squares / static_cast<double>(tracked)),
        Quantile(corners, 0.5),
        Quantile(sigma, 0.5));
  }
  std::printf(
      "%.2f ms a frame (median), %.2f ms (99 %%)\n", Quantile(times, 0.5), Quantile(times, 0.99));
  const double readout = rows_.empty() ? 0 : rows_.back().estimate.rolling_readout;
  if (readout > 0) {
    std::printf(
        "the shutter seems to roll (%.0f %% of a frame's time from the first row to the last): "
        "move slowly\n",
        100 * readout);
  }
  if (tracked < frames())
    std::printf("most frames without a pose: %s\n", commonest_problem().c_str());
}

void TrackReport::WriteTable(const std::filesystem::path& file) const {
  std::string table = "frame,time_s,tracked,corners,rms_px,sigma_px,blur_px,ms,problem\n";
  for (const Row& row : rows_) {
    const PoseEstimate& e = row.estimate;
    char text[200];
    std::snprintf(text,
                  sizeof text,
                  "%lld,%.6f,%d,%d,%.4f,%.4f,%.2f,%.3f,",
                  static_cast<long long>(row.frame),
                  row.timestamp,
                  e.cam_from_world ? 1 : 0,
                  e.observations,
                  e.rms_px,
                  e.sigma_px,
                  e.blur_px,
                  row.milliseconds);
    table += text + Quoted(e.problem) + "\n";
  }
  AtomicFile out(file);
  out.Write(table);
  out.Commit();
}

}  // namespace livemvs::app
