#include "livemvs/mesh/build_mesh.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/mesh/color_mesh.h"
#include "livemvs/mesh/fair.h"
#include "livemvs/mesh/marching.h"
#include "livemvs/mesh/mesh_topology.h"
#include "livemvs/mesh/simplify.h"
#include "livemvs/mesh/surface_field.h"
#include "livemvs/mesh/volume_cut.h"

namespace livemvs {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void Begin(const char* stage, const MeshWatch& watch) {
  watch.Check();
  watch.Show(stage, 0);
}

void TakeCounts(const SightLines& sights, MeshStatistics* statistics) {
  statistics->points = sights.lines.size();
  statistics->points_seen = sights.seen;
  statistics->not_finite = sights.not_finite;
  statistics->repeated = sights.repeated;
  statistics->lonely = sights.lonely;
}

void CheckResult(BuiltMesh* result) {
  const MeshTopology topology(result->mesh);
  result->statistics.bad_edges = topology.bad_edges();
  result->statistics.border_edges = topology.border_edges();
  result->statistics.pinched = PinchedVertices(result->mesh, topology).size();
  result->statistics.intersections = IntersectingFaces(result->mesh).size();
}

void Fair(const SightLines& sights,
          const MeshOptions& options,
          const MeshWatch& watch,
          BuiltMesh* result) {
  Begin("fair", watch);
  const std::vector<float> distance = DistancesToPoints(sights, result->mesh);
  const auto held = static_cast<float>(options.held * result->statistics.voxel);
  std::vector<char> free(distance.size(), 0);
  for (std::size_t v = 0; v < free.size(); ++v) free[v] = distance[v] > held ? 1 : 0;
  FairMesh(free, options.fairing_rounds, watch, &result->mesh);
}

/// Decimation, a last check, and the colours of the points.
void Finish(const SightLines& sights,
            const MeshOptions& options,
            const MeshWatch& watch,
            BuiltMesh* result) {
  if (options.faces > 0) {
    Begin("simplify", watch);
    result->statistics.simplified = SimplifyMesh(options.faces, watch, &result->mesh);
  }
  Begin("check", watch);
  CheckResult(result);
  const auto colored = [](const Rgb& c) { return c != Rgb{0, 0, 0}; };
  if (std::ranges::any_of(sights.colors, colored)) {
    result->mesh.colors = ColorsOfPoints(result->mesh, sights);
  }
}

}  // namespace

BuiltMesh BuildMesh(const PointCloud& cloud,
                    const MeshCameras& cameras,
                    const MeshOptions& options,
                    const MeshWatch& watch) {
  options.Check();
  const Clock::time_point start = Clock::now();
  BuiltMesh result;
  Begin("points", watch);
  const SightLines sights = MakeSightLines(cloud, cameras);
  TakeCounts(sights, &result.statistics);
  {
    const LabelVolume volume = CutVolume(sights, options, watch);
    result.statistics.voxel = volume.finest().frame.h;
    result.statistics.levels = static_cast<int>(volume.levels.size());
    result.statistics.voxels = volume.finest().blocks.voxels();
    result.statistics.seconds_cut = SecondsSince(start);
    result.mesh = MarchField(MakeSurfaceField(sights, volume, options, watch), watch);
  }
  Begin("trim", watch);
  result.statistics.trimmed =
      TrimMesh(sights, cameras, result.statistics.voxel, options, &result.mesh);
  if (result.mesh.faces.empty()) {
    throw BadInput("no surface was found between the points; they may be too few or too far apart");
  }
  Fair(sights, options, watch, &result);
  result.statistics.seconds_surface = SecondsSince(start) - result.statistics.seconds_cut;
  Finish(sights, options, watch, &result);
  result.statistics.seconds_finish =
      SecondsSince(start) - result.statistics.seconds_cut - result.statistics.seconds_surface;
  return result;
}

}  // namespace livemvs
