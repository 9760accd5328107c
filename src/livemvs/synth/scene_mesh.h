#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "livemvs/core/pose.h"

namespace livemvs::synth {

inline constexpr float kTwoPi = 2.f * std::numbers::pi_v<float>;

/// Triangles with what shading needs. Columns of equal length per vertex and per face.
struct SceneMesh {
  std::vector<Eigen::Vector3f> positions;    ///< In the world [m].
  std::vector<Eigen::Vector3f> normals;      ///< Unit, outward, in the world.
  std::vector<Eigen::Vector3f> rest;         ///< In the object's own frame [m]: texture space.
  std::vector<Eigen::Vector3i> faces;        ///< Counter-clockwise seen from outside.
  std::vector<std::uint8_t> face_materials;  ///< Index of the material.
};

/// Adds solids to a mesh. Shapes are given in the object's frame, z up.
class MeshBuilder {
 public:
  explicit MeshBuilder(SceneMesh* mesh) : mesh_(mesh) {}

  /// Where, and of what, the shapes that follow are.
  void Place(const Rigid3d& world_from_object) { world_from_object_ = world_from_object; }
  void Use(std::uint8_t material) { material_ = material; }

  /// Flat polygons, corners counter-clockwise seen from outside.
  void AddTriangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c);
  void AddQuad(const Eigen::Vector3f& a,
               const Eigen::Vector3f& b,
               const Eigen::Vector3f& c,
               const Eigen::Vector3f& d);
  void AddBox(const Eigen::Vector3f& min, const Eigen::Vector3f& max);

  /// A prism with a gable along x: a rectangle at min.z, the ridge at max.z.
  void AddGable(const Eigen::Vector3f& min, const Eigen::Vector3f& max);

  /// A smooth surface over (u, v) in [0, 1]², columns x rows quads; du x dv points outward.
  using Surface = std::function<Eigen::Vector3f(float u, float v)>;
  void AddSurface(const Surface& surface, int columns, int rows);

  /// A surface of revolution about z: corners (radius, z) of the outline, smooth between them, from
  /// the bottom up on the outside.
  void AddRevolution(const std::vector<Eigen::Vector2f>& outline, int columns, int rows);
  void AddCylinder(float radius, float z0, float z1, int columns);
  void AddEllipsoid(const Eigen::Vector3f& center, const Eigen::Vector3f& radii, int columns);

 private:
  int AddVertex(const Eigen::Vector3f& rest, const Eigen::Vector3f& normal);
  void AddFace(int a, int b, int c);

  SceneMesh* mesh_;
  Rigid3d world_from_object_;
  std::uint8_t material_ = 0;
};

}  // namespace livemvs::synth
