#pragma once

#include <string>
#include <vector>

#include "livemvs/eval/canvas.h"
#include "livemvs/eval/evaluate.h"

namespace livemvs {

/// How an evaluation is shown to people.
struct ReportOptions {
  std::string unit = "mm";       ///< Name of the unit that distances are shown in.
  double units_per_scene = 1e3;  ///< Length of one scene unit in that unit.
  std::vector<double> taus = {0.25, 0.5, 1, 2, 5};         ///< [unit]
  std::vector<double> percentiles = {50, 80, 90, 95, 99};  ///< Of the accuracy. [%]

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// A table for the screen, lines ending in '\n'.
std::string EvaluationTable(const Evaluation& evaluation, const ReportOptions& options);

/// One JSON object; docs/formats.md describes the fields.
std::string EvaluationJson(const Evaluation& evaluation, const ReportOptions& options);

/// The share of accurate points and of covered surface over the distance allowed.
RgbImage EvaluationPlot(const Evaluation& evaluation,
                        const std::string& title,
                        const ReportOptions& options);

}  // namespace livemvs
