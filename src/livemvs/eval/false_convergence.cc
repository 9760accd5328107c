#include "livemvs/eval/false_convergence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "livemvs/core/format_text.h"
#include "livemvs/eval/evaluate.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr std::array<int, 3> kPercentiles = {50, 90, 99};
constexpr float kNothingThere = std::numeric_limits<float>::infinity();

// A labelled view, prepared for many seeds.
struct Birthplace {
  const LabelledView* view;
  Projector projector;
  Rigid3d world_from_cam;
};

std::map<std::int64_t, Birthplace> Prepare(std::span<const LabelledView> views) {
  std::map<std::int64_t, Birthplace> places;
  for (const LabelledView& view : views) {
    if (view.labels.width() != view.camera.width || view.labels.height() != view.camera.height) {
      throw std::invalid_argument("labels of frame " + std::to_string(view.frame) +
                                  ": not of the size of its camera");
    }
    const bool fresh =
        places.insert({view.frame, {&view, Projector(view.camera), view.cam_from_world.Inverse()}})
            .second;
    if (!fresh) {
      throw std::invalid_argument("frame " + std::to_string(view.frame) + ": has labels twice");
    }
  }
  return places;
}

// How a converged seed compares with the truth.
struct Verdict {
  float error = 0;      // of the depth, as a share of the true one
  bool beside = false;  // false, and at the depth of another surface in the patch
};

// The error of a z depth at a pixel, as a share of the true one there.
float RelativeError(double z_depth,
                    const Eigen::Vector2d& pixel,
                    const Birthplace& p,
                    const MeshSurface& surface) {
  const auto ray = p.projector.Unproject(pixel);
  if (!ray) return kNothingThere;
  // The ray's z is 1, so that its parameter is the z depth.
  const Eigen::Vector3d direction = p.world_from_cam.rotation * *ray;
  const auto hit =
      surface.FirstHit(p.world_from_cam.translation.cast<float>(), direction.cast<float>());
  if (!hit) return kNothingThere;
  const double truth = hit->distance;
  return static_cast<float>(std::abs(z_depth - truth) / truth);
}

Verdict Judge(const SeedRecord& seed,
              const Birthplace& place,
              const MeshSurface& surface,
              double tolerance) {
  const Eigen::Vector2d pixel(seed.x, seed.y);
  const auto ray = place.projector.Unproject(pixel);
  if (!ray) return {kNothingThere};
  const double z_depth = seed.depth / ray->norm();
  Verdict verdict{RelativeError(z_depth, pixel, place, surface)};
  if (verdict.error <= tolerance) return verdict;
  const int reach = kPatchRadius << seed.level;
  const int step = 1 << seed.level;
  for (int dy = -reach; dy <= reach && !verdict.beside; dy += step) {
    for (int dx = -reach; dx <= reach && !verdict.beside; dx += step) {
      const Eigen::Vector2d neighbour = pixel + Eigen::Vector2d(dx, dy);
      verdict.beside = RelativeError(z_depth, neighbour, place, surface) <= tolerance;
    }
  }
  return verdict;
}

bool Converged(const SeedRecord& seed) {
  return seed.fate == Fate::kConverged || seed.fate == Fate::kTakenOut;
}

std::uint8_t LabelAt(const SeedRecord& seed, const Image<std::uint8_t>& labels) {
  const auto nearest = [](float v, int size) {
    return static_cast<int>(std::lround(std::clamp(v, 0.F, static_cast<float>(size - 1))));
  };
  const int x = nearest(seed.x, labels.width()), y = nearest(seed.y, labels.height());
  std::uint8_t label = labels(x, y);
  if (seed.level == 0) return label;
  // The patch of a coarse level reaches further than an edge's label does.
  const int reach = kPatchRadius << seed.level;
  for (int v = std::max(y - reach, 0); v <= std::min(y + reach, labels.height() - 1); ++v) {
    for (int u = std::max(x - reach, 0); u <= std::min(x + reach, labels.width() - 1); ++u) {
      label |= static_cast<std::uint8_t>(labels(u, v) & kLabelOccludingEdge);
    }
  }
  return label;
}

void Count(const SeedRecord& seed,
           const Verdict& verdict,
           double tolerance,
           ConvergenceCounts* counts) {
  ++counts->planted;
  if (!Converged(seed)) return;
  ++counts->converged;
  counts->falsely_converged += verdict.error > tolerance;
  if (seed.fate == Fate::kConverged) {
    ++counts->points;
    counts->false_points += verdict.error > tolerance;
  }
  counts->beside += verdict.beside;
  if (std::isfinite(verdict.error)) counts->errors.push_back(verdict.error);
}

double Ratio(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

}  // namespace

void FalseConvergenceOptions::Check() const {
  if (!(tolerance > 0 && std::isfinite(tolerance))) {
    throw std::invalid_argument("tolerance: must be > 0 and finite");
  }
}

double ConvergenceCounts::FalseRate() const { return Ratio(falsely_converged, planted); }

double ConvergenceCounts::PhantomRate() const { return Ratio(falsely_converged - beside, planted); }

double ConvergenceCounts::FalseShare() const { return Ratio(falsely_converged, converged); }

double ConvergenceCounts::FalsePointRate() const { return Ratio(false_points, planted); }

FalseConvergence MeasureFalseConvergence(std::span<const SeedRecord> seeds,
                                         std::span<const LabelledView> views,
                                         const MeshSurface& surface,
                                         const FalseConvergenceOptions& options) {
  options.Check();
  const std::map<std::int64_t, Birthplace> places = Prepare(views);
  std::vector<Verdict> verdicts(seeds.size());
  ParallelFor(seeds.size(), [&](std::size_t i) {
    const auto place = places.find(seeds[i].birth_frame);
    if (place != places.end() && Converged(seeds[i])) {
      verdicts[i] = Judge(seeds[i], place->second, surface, options.tolerance);
    }
  });
  FalseConvergence result;
  result.views = views.size();
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const auto place = places.find(seeds[i].birth_frame);
    if (place == places.end()) {
      ++result.not_judged;
      continue;
    }
    ++result.judged;
    const std::uint8_t labels = LabelAt(seeds[i], place->second.view->labels);
    for (std::size_t k = 0; k < kLabelClasses.size(); ++k) {
      if (kLabelClasses[k].Holds(labels)) {
        Count(seeds[i], verdicts[i], options.tolerance, &result.classes[k]);
      }
    }
  }
  for (ConvergenceCounts& counts : result.classes) {
    std::sort(counts.errors.begin(), counts.errors.end());
  }
  return result;
}

std::string FalseConvergenceTable(const FalseConvergence& result,
                                  const FalseConvergenceOptions& options) {
  std::string table = FormatText(
      "seeds             %zu planted in the %zu frames with labels", result.judged, result.views);
  table += FormatText("  (in others: %zu)\n", result.not_judged);
  table +=
      FormatText("false             off by more than %g %% of the true depth, or nothing there;\n",
                 100 * options.tolerance);
  table += "beside            of the false ones: at the depth of another surface in the patch\n";
  table += "phantoms          the other false ones\n";
  table += "points            converged seeds that the finished cloud keeps\n\n";
  table += FormatText("%-23s%8s%10s%7s%7s%9s%9s%10s%8s%7s%9s   error [%% of depth]\n",
                      "",
                      "",
                      "",
                      "",
                      "",
                      "false of",
                      "phantoms",
                      "false of",
                      "",
                      "false",
                      "of pl.");
  table += FormatText("%-23s%8s%10s%7s%7s%9s%9s%10s%8s%7s%9s%7s%7s%7s\n",
                      "pixels",
                      "planted",
                      "converged",
                      "false",
                      "beside",
                      "planted",
                      "of pl.",
                      "converged",
                      "points",
                      "points",
                      "",
                      "50%",
                      "90%",
                      "99%");
  for (std::size_t k = 0; k < kLabelClasses.size(); ++k) {
    const ConvergenceCounts& c = result.classes[k];
    table += FormatText("%-23s%8zu%10zu%7zu%7zu%8.2f%%%8.2f%%%9.2f%%%8zu%7zu%8.2f%%",
                        kLabelClasses[k].name,
                        c.planted,
                        c.converged,
                        c.falsely_converged,
                        c.beside,
                        100 * c.FalseRate(),
                        100 * c.PhantomRate(),
                        100 * c.FalseShare(),
                        c.points,
                        c.false_points,
                        100 * c.FalsePointRate());
    for (const int q : kPercentiles) {
      const auto p = Percentile(c.errors, q);
      table += p ? FormatText("%7.2f", 100 * *p) : FormatText("%7s", "-");
    }
    table += "\n";
  }
  return table;
}

std::string FalseConvergenceJson(const FalseConvergence& result,
                                 const FalseConvergenceOptions& options) {
  nlohmann::ordered_json json;
  json["tolerance"] = options.tolerance;
  json["labelled_frames"] = result.views;
  json["seeds_judged"] = result.judged;
  json["seeds_not_judged"] = result.not_judged;
  for (std::size_t k = 0; k < kLabelClasses.size(); ++k) {
    const ConvergenceCounts& c = result.classes[k];
    nlohmann::ordered_json row{{"planted", c.planted},
                               {"converged", c.converged},
                               {"false", c.falsely_converged},
                               {"beside", c.beside},
                               {"false_of_planted", c.FalseRate()},
                               {"phantoms_of_planted", c.PhantomRate()},
                               {"false_of_converged", c.FalseShare()},
                               {"points", c.points},
                               {"false_points", c.false_points},
                               {"false_points_of_planted", c.FalsePointRate()}};
    for (const int q : kPercentiles) {
      const auto p = Percentile(c.errors, q);
      row["error_percentiles"][std::to_string(q)] =
          p ? nlohmann::ordered_json(*p) : nlohmann::ordered_json(nullptr);
    }
    json["labels"][kLabelClasses[k].key] = row;
  }
  return json.dump(2) + "\n";
}

}  // namespace livemvs
