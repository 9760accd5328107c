#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace livemvs {

/// How points become a surface. Lengths marked [voxel] are in sides of the finest voxels.
struct MeshOptions {
  double resolution = 0;  ///< Side of the finest voxels, h [scene]; 0: the points' median spacing.
  std::size_t memory_mb = 2000;  ///< What the grids may take; the voxels grow until they fit.
  bool whole_surface = false;    ///< Keeps the surface also where nothing was seen.

  // The cut: docs/meshing.md, Eq. (1) to (4).
  double free_gain = 0.3;      ///< Log-odds of 'empty' that one line of sight through a voxel adds.
  double free_limit = 4;       ///< Most that all of them add.
  double inside_gain = 0.5;    ///< Log-odds of 'solid' that one point adds just behind it.
  double inside_limit = 4;     ///< Most that all of them add.
  double inside_prior = 0.02;  ///< Log-odds of 'solid' where nothing was seen.
  double coarse_trust = 2;     ///< Log-odds that the label of the next coarser level adds.
  double vote_gain = 1.5;      ///< kappa of rho = exp(-kappa votes).
  double rho_min = 0.02;       ///< Least cost of surface, where the points agree.
  double lambda = 0.5;         ///< Weight of the log-odds against the surface's area.

  // The surface.
  double reach = 2.5;         ///< Points act on the surface within so much of it. [voxel]
  int smoothing_rounds = 80;  ///< Of the field between the points.
  double smoothing = 30;      ///< Weight of smoothness against the points; 0: as they say.
  double held = 2;            ///< Surface this close to a point is held by it. [voxel]
  double least_facing =
      0.35;                  ///< Other surface must be seen at this cosine to its normal, at least.
  int fairing_rounds = 100;  ///< That draw surface taut which no point holds.
  double support = 9;        ///< Surface farther from every point is open. [voxel]
  double least_component = 0.002;  ///< Smaller parts are specks: share of the largest's area.
  std::size_t faces = 0;           ///< Most faces after decimation; 0: as they come.

  /// @throws std::invalid_argument naming the field and its value.
  void Check() const;
};

/// Told how far the mesh is.
struct MeshWatch {
  std::function<void(const std::string& stage, double share)> progress;  ///< May be empty.
  std::function<bool()> stop;  ///< Asked often; true: the work ends with MeshInterrupted.

  void Show(const std::string& stage, double share) const {
    if (progress) progress(stage, share);
  }
  /// @throws MeshInterrupted where it is to stop.
  void Check() const;
};

/// The user ended the work; there is no mesh.
struct MeshInterrupted {};

}  // namespace livemvs
