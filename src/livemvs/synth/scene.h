#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/core/point.h"
#include "livemvs/synth/printed_sheet.h"
#include "livemvs/synth/scene_mesh.h"
#include "livemvs/synth/texture.h"

namespace livemvs {

namespace synth {
class RayCaster;

/// A scene before its light is computed: what MakeScene's builders fill in.
struct SceneDescription {
  SceneMesh mesh;
  std::vector<Material> materials;
  std::shared_ptr<const PrintedSheet> sheet;      ///< As in SceneOptions.
  Box box;                                        ///< Holds what is to be reconstructed [m].
  Eigen::Vector3f lamp = {-0.65f, -0.5f, 0.95f};  ///< Centre of the lamp [m].
  float lamp_radius = 0.15f;                      ///< [m]
  float lamp_power = 0.85f;
  float sky_power = 0.42f;       ///< Light from all around ...
  float sky_distance = 0.5f;     ///< ... is kept off by surfaces nearer than this [m].
  float light_spacing = 0.004f;  ///< Distance of the points where light is computed [m].
  Eigen::Vector3f background_low, background_high;  ///< Of rays that hit nothing, linear.
};
}  // namespace synth

struct SceneOptions {
  /// table: still life of six solids on a sheet, 0.4 m across. relief: a carved temple front, 0.3
  /// m. house: a toy house with a garden, 0.3 m. room: a furnished room to walk in, 5 x 4 m. plane:
  /// a textured square of 2 x 2 m at z = 0, facing +z. hazards: what misleads a depth filter, 0.4
  /// m: plain, striped and glossy things, and a grating before a picture. bench: things on a desk,
  /// 0.5 m; kept for measuring what was tuned elsewhere. sheet: a printed sheet on a table, 0.42 m
  /// across or as `sheet` says. board: the table's still life on it.
  std::string name = "table";
  std::uint64_t seed = 1;  ///< Of the textures.
  /// What is printed on the sheet of the scenes sheet and board, which need it.
  std::shared_ptr<const synth::PrintedSheet> sheet;
  bool shadows = true;  ///< Compute the light, which takes a second; else it is even everywhere.

  void Check() const;  ///< @throws std::invalid_argument
};

/// A static world of textured triangles under a fixed light, z up, in metres. Surfaces are
/// Lambertian and their light is computed once, so that a point looks the same from everywhere; but
/// for glossy materials, which also mirror what is around them. Rays may be cast from several
/// threads at once. Move-only.
class SyntheticScene {
 public:
  explicit SyntheticScene(const SceneOptions& options);
  ~SyntheticScene();
  SyntheticScene(SyntheticScene&&) noexcept;
  SyntheticScene& operator=(SyntheticScene&&) noexcept;

  /// What a ray meets first.
  struct Hit {
    double distance = 0;  ///< In units of the direction's length.
    int face = -1;
    float u = 0, v = 0;  ///< Barycentric weights of the face's second and third corner.
  };

  /// Casts a ray. @return False where it hits nothing.
  bool Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Hit* hit) const;

  /// Casts neighbouring rays together, which is faster. `hits` is resized; its distances are those
  /// of single precision, and face is -1 where nothing is hit.
  struct Ray {
    Eigen::Vector3d origin, direction;
  };
  void Intersect(const std::vector<Ray>& rays, std::vector<Hit>* hits) const;

  /// Light that a ray's hit sends back along it: linear colour, 1 is white.
  /// @param direction  Of the ray, unit.
  /// @param footprint  Width of a pixel on the surface [m].
  Eigen::Vector3f Radiance(const Hit& hit, const Eigen::Vector3f& direction, float footprint) const;

  /// Its part that is the same in all directions.
  Eigen::Vector3f DiffuseRadiance(const Hit& hit, float footprint) const;

  /// Whether anything hides a place on a surface from an eye.
  bool Hidden(const Eigen::Vector3d& place, const Eigen::Vector3d& eye) const;

  /// Light of a ray that hits nothing. @param direction  Unit, in the world.
  Eigen::Vector3f Background(const Eigen::Vector3f& direction) const;

  /// Index into materials() of a face.
  std::uint8_t MaterialOf(int face) const { return description_.mesh.face_materials[face]; }
  const std::vector<synth::Material>& materials() const { return description_.materials; }

  /// Normal of a face in the world, unit.
  Eigen::Vector3f FaceNormal(int face) const;

  /// The surfaces as a mesh in the world, coloured at the vertices.
  TriangleMesh mesh() const;

  /// The region to reconstruct [m].
  const Box& box() const { return description_.box; }

 private:
  void PlanLight();
  void ComputeLight();
  Eigen::Vector3f MirroredRadiance(const Hit& hit,
                                   const Eigen::Vector3f& direction,
                                   const Eigen::Vector3f& normal,
                                   float footprint) const;
  Eigen::Vector2f LightAt(const Hit& hit) const;

  synth::SceneDescription description_;
  std::unique_ptr<synth::RayCaster> caster_;
  // Light, (sky, lamp) reflected by a white surface, linearly interpolated: of small faces at the
  // vertices, of the others at a triangular grid of points.
  struct LightGrid {
    std::size_t first;  // index into light_, behind the vertices
    int steps;          // intervals along each edge; 1: the corners
  };
  std::vector<LightGrid> grids_;
  std::vector<Eigen::Vector2f> light_;
};

}  // namespace livemvs
