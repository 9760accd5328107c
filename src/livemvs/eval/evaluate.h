#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/posed_camera.h"
#include "livemvs/eval/surface.h"

namespace livemvs {

struct EvaluationOptions {
  std::optional<Box> box;        ///< Points and surface outside of it are not judged.
  std::size_t samples = 200000;  ///< Points spread over the surface, for completeness.
  std::uint64_t seed = 1;        ///< Of the samples.
  int min_cameras = 5;           ///< Of the cameras given, those that must see a surface sample.
  double border_px = 4;          ///< A camera does not see this close to its image's edge. [px]
  /// A camera sees a sample where the surface blocks the line between them nowhere before this
  /// share of its length.
  double unblocked = 1 - 2e-3;

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// Distances between a cloud and its reference, sorted. [scene]
struct Evaluation {
  std::size_t points = 0;           ///< In the cloud, finite ones.
  std::size_t not_finite = 0;       ///< Points with a coordinate that is no number.
  std::size_t cameras = 0;          ///< Asked what they see; 0: all of the surface is judged.
  std::size_t samples_in_box = 0;   ///< Samples of the reference in the box, seen or not.
  std::vector<float> accuracy;      ///< From each point in the box to the reference.
  std::vector<float> completeness;  ///< From each judged sample to the nearest point in the box.
};

/// Compares a cloud with a mesh. With cameras, only surface is judged for completeness that at
/// least min_cameras of them see. Deterministic; multi-threaded.
Evaluation EvaluateAgainstMesh(const PointCloud& cloud,
                               const MeshSurface& reference,
                               std::span<const PosedCamera> cameras,
                               const EvaluationOptions& options);

/// Compares a mesh with a mesh: as a cloud of options.samples points spread uniformly over its area
/// would be, but completeness is measured to the surface itself, as far as it has a triangle in the
/// box. Vertices that are not finite are counted, their triangles left out.
Evaluation EvaluateMesh(const TriangleMesh& mesh,
                        const MeshSurface& reference,
                        std::span<const PosedCamera> cameras,
                        const EvaluationOptions& options);

/// As above, against a cloud, whose points are the surface.
Evaluation EvaluateMesh(const TriangleMesh& mesh,
                        const PointCloud& reference,
                        const EvaluationOptions& options);

/// Compares a cloud with another cloud, whose points are the surface and all its samples.
Evaluation EvaluateAgainstCloud(const PointCloud& cloud,
                                const PointCloud& reference,
                                const EvaluationOptions& options);

/// Those of the samples that at least options.min_cameras of the cameras see, in order.
std::vector<Eigen::Vector3f> SeenSamples(const std::vector<Eigen::Vector3f>& samples,
                                         const MeshSurface& surface,
                                         std::span<const PosedCamera> cameras,
                                         const EvaluationOptions& options);

/// Share of the sorted distances less than tau, in [0, 1]; 0 where there are none.
double ShareWithin(const std::vector<float>& sorted_distances, double tau);

/// The percentile q in [0, 100] of sorted distances, linear between neighbours; nothing where there
/// are none.
std::optional<double> Percentile(const std::vector<float>& sorted_distances, double q);

/// Harmonic mean of the shares of accurate points and of covered surface; 0 where both are 0.
double FScore(double accuracy, double completeness);

}  // namespace livemvs
