#include "livemvs/synth/scene_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace livemvs::synth {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// The angle of a fraction of a turn; the same at 0 and 1, so that surfaces close without a crack.
float Turn(float u) { return kTwoPi * (u - std::floor(u)); }

// Normal by central differences; moved off the borders, where poles have no tangent.
Vector3f SurfaceNormal(const MeshBuilder::Surface& surface, float u, float v) {
  constexpr float kStep = 1e-3f;
  const float v_inside = std::clamp(v, 2.f * kStep, 1.f - 2.f * kStep);
  const Vector3f du = surface(u + kStep, v_inside) - surface(u - kStep, v_inside);
  const Vector3f dv = surface(u, v_inside + kStep) - surface(u, v_inside - kStep);
  return du.cross(dv).normalized();
}

// Catmull-Rom interpolation of the corners of an outline.
Vector2f Outline(const std::vector<Vector2f>& corners, float v) {
  const int last = static_cast<int>(corners.size()) - 1;
  const float s = std::clamp(v, 0.f, 1.f) * static_cast<float>(last);
  const int i = std::min(static_cast<int>(s), last - 1);
  const float t = s - static_cast<float>(i);
  const Vector2f p0 = corners[std::max(i - 1, 0)], p1 = corners[i];
  const Vector2f p2 = corners[i + 1], p3 = corners[std::min(i + 2, last)];
  Vector2f p = 0.5f * (2.f * p1 + t * (p2 - p0) + t * t * (2.f * p0 - 5.f * p1 + 4.f * p2 - p3) +
                       t * t * t * (3.f * p1 - p0 - 3.f * p2 + p3));
  p.x() = std::max(p.x(), 0.f);
  return p;
}

}  // namespace

int MeshBuilder::AddVertex(const Vector3f& rest, const Vector3f& normal) {
  const Eigen::Matrix3d& rotation = world_from_object_.rotation;
  mesh_->rest.push_back(rest);
  mesh_->positions.push_back((world_from_object_ * rest.cast<double>()).cast<float>());
  mesh_->normals.push_back((rotation * normal.cast<double>()).cast<float>());
  return static_cast<int>(mesh_->rest.size()) - 1;
}

void MeshBuilder::AddFace(int a, int b, int c) {
  mesh_->faces.emplace_back(a, b, c);
  mesh_->face_materials.push_back(material_);
}

void MeshBuilder::AddTriangle(const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  const Vector3f normal = (b - a).cross(c - a).normalized();
  const int i = AddVertex(a, normal);
  AddVertex(b, normal);
  AddVertex(c, normal);
  AddFace(i, i + 1, i + 2);
}

void MeshBuilder::AddQuad(const Vector3f& a,
                          const Vector3f& b,
                          const Vector3f& c,
                          const Vector3f& d) {
  const Vector3f normal = (b - a).cross(c - a).normalized();
  const int i = AddVertex(a, normal);
  AddVertex(b, normal);
  AddVertex(c, normal);
  AddVertex(d, normal);
  AddFace(i, i + 1, i + 2);
  AddFace(i, i + 2, i + 3);
}

void MeshBuilder::AddBox(const Vector3f& min, const Vector3f& max) {
  const auto corner = [&](int x, int y, int z) {
    return Vector3f(x ? max.x() : min.x(), y ? max.y() : min.y(), z ? max.z() : min.z());
  };
  AddQuad(corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0));
  AddQuad(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1));
  AddQuad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1));
  AddQuad(corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0));
  AddQuad(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0));
  AddQuad(corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1));
}

void MeshBuilder::AddGable(const Vector3f& min, const Vector3f& max) {
  const float middle = 0.5f * (min.y() + max.y());
  const Vector3f a(min.x(), min.y(), min.z()), b(max.x(), min.y(), min.z());
  const Vector3f c(max.x(), max.y(), min.z()), d(min.x(), max.y(), min.z());
  const Vector3f e(min.x(), middle, max.z()), f(max.x(), middle, max.z());
  AddQuad(a, b, f, e);
  AddQuad(c, d, e, f);
  AddTriangle(a, e, d);
  AddTriangle(b, c, f);
  AddQuad(a, d, c, b);
}

void MeshBuilder::AddSurface(const Surface& surface, int columns, int rows) {
  const int first = static_cast<int>(mesh_->rest.size());
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(columns);
      const float v = static_cast<float>(j) / static_cast<float>(rows);
      AddVertex(surface(u, v), SurfaceNormal(surface, u, v));
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = first + j * (columns + 1) + i, b = a + 1;
      const int c = b + columns + 1, d = a + columns + 1;
      const auto& p = mesh_->positions;
      if (p[a] != p[b]) AddFace(a, b, c);  // the rows at poles have triangles of no area
      if (p[c] != p[d]) AddFace(a, c, d);
    }
  }
}

void MeshBuilder::AddRevolution(const std::vector<Vector2f>& outline, int columns, int rows) {
  AddSurface(
      [&](float u, float v) {
        const Vector2f p = Outline(outline, v);
        return Vector3f(p.x() * std::cos(Turn(u)), p.x() * std::sin(Turn(u)), p.y());
      },
      columns,
      rows);
}

void MeshBuilder::AddCylinder(float radius, float z0, float z1, int columns) {
  const auto rim = [&](float u, float z) {
    return Vector3f(radius * std::cos(Turn(u)), radius * std::sin(Turn(u)), z);
  };
  AddSurface([&](float u, float v) { return rim(u, z0 + v * (z1 - z0)); }, columns, 1);
  for (int i = 0; i < columns; ++i) {
    const float u = static_cast<float>(i) / static_cast<float>(columns);
    const float next = static_cast<float>(i + 1) / static_cast<float>(columns);
    AddTriangle(Vector3f(0, 0, z1), rim(u, z1), rim(next, z1));
    AddTriangle(Vector3f(0, 0, z0), rim(next, z0), rim(u, z0));
  }
}

void MeshBuilder::AddEllipsoid(const Vector3f& center, const Vector3f& radii, int columns) {
  AddSurface(
      [&](float u, float v) {
        const float latitude = (v - 0.5f) * 0.5f * kTwoPi;
        const Vector3f unit(std::cos(latitude) * std::cos(Turn(u)),
                            std::cos(latitude) * std::sin(Turn(u)),
                            std::sin(latitude));
        return Vector3f(center + radii.cwiseProduct(unit));
      },
      columns,
      columns / 2);
}

}  // namespace livemvs::synth
