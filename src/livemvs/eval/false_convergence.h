#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/pixel_label.h"
#include "livemvs/core/pose.h"
#include "livemvs/core/seed_record.h"
#include "livemvs/eval/surface.h"

namespace livemvs {

/// A frame in which seeds were planted, and the PixelLabels of its pixels.
struct LabelledView {
  std::int64_t frame = 0;  ///< Its index.
  Camera camera;
  Rigid3d cam_from_world;
  Image<std::uint8_t> labels;  ///< Of the camera's size.
};

struct FalseConvergenceOptions {
  /// A converged seed is false where its depth is off by more than this share of the true depth,
  /// or nothing is there at all.
  double tolerance = 0.01;

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// What became of the seeds of some pixels.
struct ConvergenceCounts {
  std::size_t planted = 0;
  std::size_t converged = 0;
  std::size_t falsely_converged = 0;
  /// Those of them whose depth is that of another surface in the seed's patch: at an edge the patch
  /// follows the nearer one, so that things look fatter than they are. The others are phantoms.
  std::size_t beside = 0;
  std::size_t points = 0;        ///< Converged ones whose point was not taken out of the cloud.
  std::size_t false_points = 0;  ///< Of the falsely converged ones.
  std::vector<float> errors;     ///< |depth - truth| / truth of the converged ones, sorted.

  /// falsely_converged / planted; 0 where none was planted.
  double FalseRate() const;
  /// (falsely_converged - beside) / planted; 0 where none was planted.
  double PhantomRate() const;
  /// falsely_converged / converged; 0 where none converged.
  double FalseShare() const;
  /// false_points / planted; 0 where none was planted.
  double FalsePointRate() const;
};

/// A row of the report: pixels that have any of some labels (0: whatever they have) and none of
/// others.
struct LabelClass {
  const char* name;  ///< For the table.
  const char* key;   ///< For JSON.
  std::uint8_t any_of;
  std::uint8_t none_of = 0;

  bool Holds(std::uint8_t labels) const {
    return (any_of == 0 || (labels & any_of) != 0) && (labels & none_of) == 0;
  }
};

/// At a jump in depth a patch sees both surfaces, whatever its pixel's own is like: the rows "off
/// edges" tell what a label does by itself.
inline constexpr std::array<LabelClass, 12> kLabelClasses{{
    {"textureless", "textureless", kLabelTextureless},
    {"  off edges", "textureless_off_edges", kLabelTextureless, kLabelOccludingEdge},
    {"soon occluded", "soon_occluded", kLabelSoonOccluded},
    {"  off edges", "soon_occluded_off_edges", kLabelSoonOccluded, kLabelOccludingEdge},
    {"textureless or occluded", "textureless_or_occluded", kLabelTextureless | kLabelSoonOccluded},
    {"  off edges",
     "textureless_or_occluded_off_edges",
     kLabelTextureless | kLabelSoonOccluded,
     kLabelOccludingEdge},
    {"repetitive", "repetitive", kLabelRepetitive},
    {"specular", "specular", kLabelSpecular},
    {"occluding edge", "occluding_edge", kLabelOccludingEdge},
    {"background", "background", kLabelBackground},
    {"any label", "any_label", kAllPixelLabels},
    {"no label", "no_label", 0, kAllPixelLabels},
}};

struct FalseConvergence {
  std::array<ConvergenceCounts, kLabelClasses.size()> classes;  ///< As kLabelClasses.
  std::size_t views = 0;                                        ///< Labelled ones.
  std::size_t judged = 0;      ///< Seeds that were planted in a labelled view.
  std::size_t not_judged = 0;  ///< Seeds that were planted in another frame.
};

/// Compares what became of seeds with the surface that their rays truly meet. A seed counts in each
/// class that its pixel belongs to. Deterministic; multi-threaded.
/// @param views  Frames in any order, each once. Only seeds that were planted in them count.
/// @throws std::invalid_argument where labels are not of their camera's size or a frame comes
/// twice.
FalseConvergence MeasureFalseConvergence(std::span<const SeedRecord> seeds,
                                         std::span<const LabelledView> views,
                                         const MeshSurface& surface,
                                         const FalseConvergenceOptions& options);

/// A table for the screen, lines ending in '\n'.
std::string FalseConvergenceTable(const FalseConvergence& result,
                                  const FalseConvergenceOptions& options);

/// One JSON object; docs/data-formats.md describes the fields.
std::string FalseConvergenceJson(const FalseConvergence& result,
                                 const FalseConvergenceOptions& options);

}  // namespace livemvs
