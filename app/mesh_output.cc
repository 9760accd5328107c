#include "mesh_output.h"

#include <cstdio>
#include <stdexcept>
#include <string>

#include "livemvs/core/log.h"
#include "livemvs/exchange/glb.h"
#include "livemvs/exchange/obj.h"
#include "livemvs/io/lower_case.h"
#include "livemvs/io/ply.h"

namespace livemvs::app {
namespace {

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

std::vector<Output> MeshOutputs(const std::filesystem::path& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".glb") return {{path, "the mesh", "a GLB file", "glTF"}};
  if (extension == ".ply") return {{path, "the mesh", "a mesh", "ply"}};
  if (extension == ".obj") {
    std::filesystem::path material = path;
    return {{path, "the mesh", "", ""},
            {material.replace_extension(".mtl"), "the mesh's material", "", ""}};
  }
  throw std::invalid_argument("--output " + path.string() +
                              ": the name must end with .glb, .obj or .ply");
}

void WriteMesh(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const std::string extension = LowerExtension(path);
  if (extension == ".ply") {
    WritePly(path, mesh);
  } else if (extension == ".obj") {
    WriteObj(path, MakeExchangeModel(mesh));
  } else {
    WriteGlb(path, MakeExchangeModel(mesh));
  }
}

nlohmann::json MeshJson(const BuiltMesh& built) {
  const MeshStatistics& s = built.statistics;
  return {
      {"vertices", built.mesh.vertices.size()},
      {"faces", built.mesh.faces.size()},
      {"points", s.points},
      {"points_seen", s.points_seen},
      {"left_out", {{"not_finite", s.not_finite}, {"repeated", s.repeated}, {"lonely", s.lonely}}},
      {"voxel", s.voxel},
      {"levels", s.levels},
      {"voxels", s.voxels},
      {"removed",
       {{"unsupported_faces", s.trimmed.unsupported_faces},
        {"sideways_faces", s.trimmed.sideways_faces},
        {"specks", s.trimmed.specks}}},
      {"check",
       {{"bad_edges", s.bad_edges},
        {"pinched_vertices", s.pinched},
        {"intersecting_faces", s.intersections},
        {"border_edges", s.border_edges}}},
      {"seconds",
       {{"cut", s.seconds_cut}, {"surface", s.seconds_surface}, {"finish", s.seconds_finish}}}};
}

void WarnOfMesh(const MeshStatistics& s, const MeshOptions& options) {
  if (s.not_finite > 0) {
    LogWarning(std::to_string(s.not_finite) + " points were left out: their position is no number");
  }
  if (s.lonely > 0) {
    LogWarning(std::to_string(s.lonely) + " points were left out: they are far from all others");
  }
  if (s.points_seen == 0) {
    LogWarning(
        "no point knows the camera that saw it (--data, and a cloud with frame numbers): normals "
        "stand for lines of sight, so that what is empty is known near the points only");
  } else if (s.points_seen < s.points) {
    LogWarning(std::to_string(s.points - s.points_seen) + " of " + std::to_string(s.points) +
               " points do not know the camera that saw them; their normals stand for it");
  }
  if (options.resolution > 0 && s.voxel > 1.01 * options.resolution) {
    LogWarning("voxels of " + Number(options.resolution) +
               " do not fit the memory; those used are " + Number(s.voxel) +
               " wide; allow more with --memory");
  }
  if (!s.simplified) {
    LogWarning("--faces: so few would fold the surface onto itself; it keeps more");
  }
  if (s.bad_edges + s.pinched + s.intersections > 0) {
    LogWarning("the surface has defects: " + std::to_string(s.bad_edges) + " edges and " +
               std::to_string(s.pinched) + " vertices are not of a manifold, " +
               std::to_string(s.intersections) + " pairs of faces intersect");
  }
}

void PrintMesh(const BuiltMesh& built, const std::filesystem::path& path) {
  const MeshStatistics& s = built.statistics;
  std::printf("%zu faces, %zu vertices from %zu points, voxels of %s, in %.1f s\n",
              built.mesh.faces.size(),
              built.mesh.vertices.size(),
              s.points,
              Number(s.voxel).c_str(),
              s.seconds_cut + s.seconds_surface + s.seconds_finish);
  std::printf("%s\n", std::filesystem::absolute(path).c_str());
}

}  // namespace livemvs::app
