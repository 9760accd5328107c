#include "livemvs/eval/report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "livemvs/core/format_text.h"
#include "livemvs/eval/plot.h"

namespace livemvs {
namespace {

/// Mean and root mean square of the distances. [scene]
struct Moments {
  double mean = 0, rms = 0;
};

Moments MomentsOf(const std::vector<float>& distances) {
  Moments m;
  for (float d : distances) {
    m.mean += d;
    m.rms += static_cast<double>(d) * d;
  }
  const double n = static_cast<double>(std::max<std::size_t>(distances.size(), 1));
  return {m.mean / n, std::sqrt(m.rms / n)};
}

nlohmann::json Number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

}  // namespace

void ReportOptions::Check() const {
  if (!(units_per_scene > 0 && std::isfinite(units_per_scene))) {
    throw std::invalid_argument("units_per_scene: must be > 0 and finite");
  }
  if (taus.empty()) throw std::invalid_argument("taus: none given");
  for (double tau : taus) {
    if (!(tau > 0 && std::isfinite(tau))) {
      throw std::invalid_argument("taus: each must be > 0 and finite");
    }
  }
  for (double q : percentiles) {
    if (!(q >= 0 && q <= 100)) throw std::invalid_argument("percentiles: must be in [0, 100]");
  }
}

std::string EvaluationTable(const Evaluation& e, const ReportOptions& options) {
  options.Check();
  const char* unit = options.unit.c_str();
  std::string table = FormatText("points            %zu", e.points);
  table += FormatText("  (in the box: %zu, not finite: %zu)\n", e.accuracy.size(), e.not_finite);
  table += FormatText(
      "surface samples   %zu judged of %zu in the box", e.completeness.size(), e.samples_in_box);
  if (e.cameras > 0) table += FormatText(", seen by enough of %zu cameras", e.cameras);
  table += "\n\n";
  if (e.accuracy.empty()) {
    table += "distance of the points to the surface: no points in the box\n";
  } else {
    const Moments m = MomentsOf(e.accuracy);
    table += "distance of the points to the surface\n ";
    for (double q : options.percentiles) table += FormatText("%9s%%", ShortNumber(q).c_str());
    table += FormatText("%10s%10s\n ", "mean", "rms");
    for (double q : options.percentiles) {
      table += FormatText("%10.3f", *Percentile(e.accuracy, q) * options.units_per_scene);
    }
    table += FormatText("%10.3f%10.3f  %s\n",
                        m.mean * options.units_per_scene,
                        m.rms * options.units_per_scene,
                        unit);
  }
  table += FormatText("\n%10s   %10s %14s %10s\n", "within", "accuracy", "completeness", "F-score");
  for (double tau : options.taus) {
    const double a = ShareWithin(e.accuracy, tau / options.units_per_scene);
    const double c = ShareWithin(e.completeness, tau / options.units_per_scene);
    table += FormatText("%7s %-4s %9.2f%% %13.2f%% %9.2f%%\n",
                        ShortNumber(tau).c_str(),
                        unit,
                        100 * a,
                        100 * c,
                        100 * FScore(a, c));
  }
  return table;
}

std::string EvaluationJson(const Evaluation& e, const ReportOptions& options) {
  options.Check();
  const double scale = options.units_per_scene;
  nlohmann::ordered_json json;
  json["points"] = e.points;
  json["points_in_box"] = e.accuracy.size();
  json["not_finite"] = e.not_finite;
  json["cameras"] = e.cameras;
  json["samples_in_box"] = e.samples_in_box;
  json["samples_judged"] = e.completeness.size();
  json["unit"] = options.unit;
  for (const auto& [name, distances] :
       {std::pair{"accuracy", &e.accuracy}, std::pair{"completeness", &e.completeness}}) {
    nlohmann::ordered_json summary;
    const Moments m = MomentsOf(*distances);
    for (double q : options.percentiles) {
      const auto p = Percentile(*distances, q);
      summary["percentiles"][ShortNumber(q)] = p ? Number(*p * scale) : nlohmann::json(nullptr);
    }
    summary["mean"] = distances->empty() ? nlohmann::json(nullptr) : Number(m.mean * scale);
    summary["rms"] = distances->empty() ? nlohmann::json(nullptr) : Number(m.rms * scale);
    json[name] = summary;
  }
  json["within"] = nlohmann::ordered_json::array();
  for (double tau : options.taus) {
    const double a = ShareWithin(e.accuracy, tau / scale);
    const double c = ShareWithin(e.completeness, tau / scale);
    json["within"].push_back(
        {{"tau", tau}, {"accuracy", a}, {"completeness", c}, {"f_score", FScore(a, c)}});
  }
  return json.dump(2) + "\n";
}

RgbImage EvaluationPlot(const Evaluation& e,
                        const std::string& title,
                        const ReportOptions& options) {
  options.Check();
  constexpr int kSteps = 400;
  const auto [lo, hi] = std::minmax_element(options.taus.begin(), options.taus.end());
  CurvePlot plot;
  plot.title = title;
  plot.x_label = "distance allowed [" + options.unit + "]";
  plot.y_label = "share";
  plot.x_min = *lo / 5;
  plot.x_max = *hi * 2;
  plot.curves = {{"accuracy: points near the surface", {214, 96, 39}, {}},
                 {"completeness: surface near a point", {38, 103, 178}, {}},
                 {"F-score", {120, 124, 132}, {}}};
  for (int i = 0; i <= kSteps; ++i) {
    const double x =
        plot.x_min * std::pow(plot.x_max / plot.x_min, i / static_cast<double>(kSteps));
    const double a = ShareWithin(e.accuracy, x / options.units_per_scene);
    const double c = ShareWithin(e.completeness, x / options.units_per_scene);
    plot.curves[0].points.push_back({x, a});
    plot.curves[1].points.push_back({x, c});
    plot.curves[2].points.push_back({x, FScore(a, c)});
  }
  return plot.Draw();
}

}  // namespace livemvs
