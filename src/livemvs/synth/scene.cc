#include "livemvs/synth/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "livemvs/parallel/parallel_for.h"
#include "livemvs/synth/ray_caster.h"
#include "livemvs/synth/scene_builders.h"

namespace livemvs {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kSkyRays = 96;
constexpr int kLampRays = 24;
constexpr float kGroundBrightness = 0.4f;   // of light from below, relative to that from above
constexpr float kShadowBrightness = 0.25f;  // of surfaces that hide the sky: light between them
const Vector3f kSkyColor(0.93f, 0.98f, 1.08f);
const Vector3f kLampColor(1.08f, 1.0f, 0.86f);

// Directions spread evenly over the sphere. The same everywhere, so that light is free of noise.
std::array<Vector3f, kSkyRays> SkyDirections() {
  std::array<Vector3f, kSkyRays> directions;
  for (int i = 0; i < kSkyRays; ++i) {
    const double z = 1 - (2.0 * i + 1) / kSkyRays;
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    directions[i] = Vector3d(r * std::cos(angle), r * std::sin(angle), z).cast<float>();
  }
  return directions;
}

// Points spread evenly over a disc of radius 1, facing down.
std::array<Vector3f, kLampRays> LampPoints() {
  std::array<Vector3f, kLampRays> points;
  for (int i = 0; i < kLampRays; ++i) {
    const double r = std::sqrt((i + 0.5) / kLampRays);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    points[i] = Vector3d(r * std::cos(angle), r * std::sin(angle), 0).cast<float>();
  }
  return points;
}

// Place of grid point (i, j), j <= steps, in the points of a face: rows get shorter upwards.
std::size_t GridIndex(int steps, int i, int j) {
  return static_cast<std::size_t>(j) * (steps + 1) - static_cast<std::size_t>(j) * (j - 1) / 2 + i;
}

// Light at one point: (sky, lamp) reflected by a white surface.
Vector2f LightAtPoint(const synth::SceneDescription& scene,
                      const synth::RayCaster& caster,
                      const Vector3f& point,
                      const Vector3f& normal) {
  static const auto sky_directions = SkyDirections();
  static const auto lamp_points = LampPoints();
  const Vector3f origin = point + normal * (0.02f * scene.light_spacing);
  float sky = 0.f;
  for (const Vector3f& direction : sky_directions) {
    const float cosine = direction.dot(normal);
    if (cosine <= 0.f) continue;
    const bool hidden = caster.Occluded(origin, direction, scene.sky_distance);
    sky += cosine * (hidden ? kShadowBrightness : direction.z() > 0.f ? 1.f : kGroundBrightness);
  }
  const float distance2_at_origin = scene.lamp.squaredNorm();
  float lamp = 0.f;
  for (const Vector3f& on_disc : lamp_points) {
    const Vector3f to_lamp = scene.lamp + scene.lamp_radius * on_disc - origin;
    const float cosine = to_lamp.normalized().dot(normal);
    if (cosine <= 0.f || caster.Occluded(origin, to_lamp, 0.999f)) continue;
    lamp += cosine * distance2_at_origin / to_lamp.squaredNorm();
  }
  return {scene.sky_power * 4.f * sky / kSkyRays, scene.lamp_power * lamp / kLampRays};
}

}  // namespace

void SceneOptions::Check() const {
  if (!synth::HasScene(name)) {
    throw std::invalid_argument("scene \"" + name + "\": unknown; choose from " +
                                synth::SceneNames());
  }
  if ((name == "sheet" || name == "board") && sheet == nullptr) {
    throw std::invalid_argument("scene \"" + name + "\": needs what is printed on its sheet");
  }
}

SyntheticScene::SyntheticScene(const SceneOptions& options) {
  options.Check();
  description_ = synth::DescribeScene(options);
  caster_ = std::make_unique<synth::RayCaster>(description_.mesh);
  if (options.shadows) ComputeLight();
}

SyntheticScene::~SyntheticScene() = default;
SyntheticScene::SyntheticScene(SyntheticScene&&) noexcept = default;
SyntheticScene& SyntheticScene::operator=(SyntheticScene&&) noexcept = default;

void SyntheticScene::PlanLight() {
  constexpr int kMaxSteps = 160;
  const synth::SceneMesh& mesh = description_.mesh;
  const auto& p = mesh.positions;
  grids_.resize(mesh.faces.size());
  std::size_t count = p.size();
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& c = mesh.faces[f];
    const float longest = std::max(
        {(p[c[0]] - p[c[1]]).norm(), (p[c[1]] - p[c[2]]).norm(), (p[c[2]] - p[c[0]]).norm()});
    const int steps =
        std::clamp(static_cast<int>(std::ceil(longest / description_.light_spacing)), 1, kMaxSteps);
    grids_[f] = {count, steps};
    if (steps > 1) count += static_cast<std::size_t>(steps + 1) * (steps + 2) / 2;
  }
  light_.assign(count, Vector2f::Zero());
}

void SyntheticScene::ComputeLight() {
  PlanLight();
  const synth::SceneMesh& mesh = description_.mesh;
  ParallelFor(mesh.positions.size(), [&](std::size_t i) {
    light_[i] = LightAtPoint(description_, *caster_, mesh.positions[i], mesh.normals[i]);
  });
  ParallelFor(mesh.faces.size(), [&](std::size_t f) {
    const auto [first, steps] = grids_[f];
    if (steps == 1) return;
    const Eigen::Vector3i& c = mesh.faces[f];
    for (int j = 0; j <= steps; ++j) {
      for (int i = 0; i + j <= steps; ++i) {
        const float u = static_cast<float>(i) / static_cast<float>(steps);
        const float v = static_cast<float>(j) / static_cast<float>(steps);
        const auto blend = [&](const std::vector<Vector3f>& of) -> Vector3f {
          return (1.f - u - v) * of[c[0]] + u * of[c[1]] + v * of[c[2]];
        };
        light_[first + GridIndex(steps, i, j)] = LightAtPoint(
            description_, *caster_, blend(mesh.positions), blend(mesh.normals).normalized());
      }
    }
  });
}

bool SyntheticScene::Intersect(const Vector3d& origin, const Vector3d& direction, Hit* hit) const {
  synth::RayCaster::Hit found;
  if (!caster_->Intersect(origin.cast<float>(), direction.cast<float>(), &found)) return false;
  // The distance again in double: in float it is wrong by 1e-7 of the scene's size.
  const synth::SceneMesh& mesh = description_.mesh;
  const Eigen::Vector3i& c = mesh.faces[found.face];
  const Vector3d a = mesh.positions[c[0]].cast<double>();
  const Vector3d normal =
      (mesh.positions[c[1]].cast<double>() - a).cross(mesh.positions[c[2]].cast<double>() - a);
  const double slope = normal.dot(direction);
  const double distance = slope != 0 ? normal.dot(a - origin) / slope : found.distance;
  *hit = {distance, found.face, found.u, found.v};
  return true;
}

void SyntheticScene::Intersect(const std::vector<Ray>& rays, std::vector<Hit>* hits) const {
  std::vector<synth::RayCaster::Ray> single(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    single[i] = {rays[i].origin.cast<float>(), rays[i].direction.cast<float>()};
  }
  std::vector<synth::RayCaster::Hit> found(rays.size());
  caster_->Intersect(single, found);
  hits->resize(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    (*hits)[i] = {found[i].distance, found[i].face, found[i].u, found[i].v};
  }
}

Vector2f SyntheticScene::LightAt(const Hit& hit) const {
  if (light_.empty()) return {0.4f, 0.4f};
  const LightGrid& grid = grids_[hit.face];
  if (grid.steps == 1) {
    const Eigen::Vector3i& c = description_.mesh.faces[hit.face];
    return (1.f - hit.u - hit.v) * light_[c[0]] + hit.u * light_[c[1]] + hit.v * light_[c[2]];
  }
  const float last = static_cast<float>(grid.steps);
  const float x = std::clamp(hit.u * last, 0.f, last);
  const float y = std::clamp(hit.v * last, 0.f, last - x);
  const int i = std::min(static_cast<int>(x), grid.steps - 1);
  const int j = std::min(static_cast<int>(y), grid.steps - 1 - i);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const auto at = [&](int ii, int jj) {
    return light_[grid.first + GridIndex(grid.steps, ii, jj)];
  };
  if (fx + fy <= 1.f || i + j + 2 > grid.steps) {
    return (1.f - fx - fy) * at(i, j) + fx * at(i + 1, j) + fy * at(i, j + 1);
  }
  return (fx + fy - 1.f) * at(i + 1, j + 1) + (1.f - fy) * at(i + 1, j) + (1.f - fx) * at(i, j + 1);
}

bool SyntheticScene::Hidden(const Vector3d& place, const Vector3d& eye) const {
  // Not all the way: the place itself does not hide itself.
  constexpr float kUnblocked = 1 - 2e-3f;
  return caster_->Occluded(eye.cast<float>(), (place - eye).cast<float>(), kUnblocked);
}

Vector3f SyntheticScene::DiffuseRadiance(const Hit& hit, float footprint) const {
  const synth::SceneMesh& mesh = description_.mesh;
  const Eigen::Vector3i& c = mesh.faces[hit.face];
  const Vector3f& a = mesh.rest[c[0]];
  const Vector3f ab = mesh.rest[c[1]] - a, ac = mesh.rest[c[2]] - a;
  const Vector3f color = synth::Reflectance(description_.materials[mesh.face_materials[hit.face]],
                                            a + hit.u * ab + hit.v * ac,
                                            ab.cross(ac).normalized(),
                                            footprint);
  const Vector2f light = LightAt(hit);
  return color.cwiseProduct(light.x() * kSkyColor + light.y() * kLampColor);
}

Vector3f SyntheticScene::Radiance(const Hit& hit,
                                  const Vector3f& direction,
                                  float footprint) const {
  const Vector3f diffuse = DiffuseRadiance(hit, footprint);
  const synth::SceneMesh& mesh = description_.mesh;
  const float gloss = description_.materials[mesh.face_materials[hit.face]].gloss;
  if (gloss <= 0.f) return diffuse;
  const Eigen::Vector3i& c = mesh.faces[hit.face];
  Vector3f normal = ((1.f - hit.u - hit.v) * mesh.normals[c[0]] + hit.u * mesh.normals[c[1]] +
                     hit.v * mesh.normals[c[2]])
                        .normalized();
  if (normal.dot(direction) > 0.f) normal = -normal;
  // Fresnel's law in Schlick's approximation.
  const float grazing = 1.f + normal.dot(direction);
  const float share = gloss + (1.f - gloss) * std::pow(grazing, 5.f);
  return (1.f - share) * diffuse + share * MirroredRadiance(hit, direction, normal, footprint);
}

Vector3f SyntheticScene::MirroredRadiance(const Hit& hit,
                                          const Vector3f& direction,
                                          const Vector3f& normal,
                                          float footprint) const {
  constexpr float kSharpness = 300.f;      // of the lamp's image
  constexpr float kLampBrightness = 30.f;  // of the lamp itself, per unit of its power
  const auto& p = description_.mesh.positions;
  const Eigen::Vector3i& c = description_.mesh.faces[hit.face];
  const Vector3f mirrored = direction - 2.f * normal.dot(direction) * normal;
  const Vector3f place = (1.f - hit.u - hit.v) * p[c[0]] + hit.u * p[c[1]] + hit.v * p[c[2]] +
                         0.02f * description_.light_spacing * normal;
  synth::RayCaster::Hit seen;
  // What is seen in a mirror is taken to be matt: one bounce is enough to mislead a matcher.
  Vector3f light = caster_->Intersect(place, mirrored, &seen)
                       ? DiffuseRadiance({seen.distance, seen.face, seen.u, seen.v}, footprint)
                       : Background(mirrored);
  const Vector3f to_lamp = description_.lamp - place;
  const float towards = mirrored.dot(to_lamp.normalized());
  if (towards > 0.f && !caster_->Occluded(place, to_lamp, 0.999f)) {
    light += kLampBrightness * description_.lamp_power * std::pow(towards, kSharpness) * kLampColor;
  }
  return light;
}

Vector3f SyntheticScene::Background(const Vector3f& direction) const {
  const float height = std::clamp(0.5f + 0.7f * direction.z(), 0.f, 1.f);
  return description_.background_low +
         height * (description_.background_high - description_.background_low);
}

Vector3f SyntheticScene::FaceNormal(int face) const {
  const auto& p = description_.mesh.positions;
  const Eigen::Vector3i& c = description_.mesh.faces[face];
  return (p[c[1]] - p[c[0]]).cross(p[c[2]] - p[c[0]]).normalized();
}

TriangleMesh SyntheticScene::mesh() const {
  const synth::SceneMesh& from = description_.mesh;
  TriangleMesh mesh;
  mesh.vertices = from.positions;
  mesh.faces = from.faces;
  mesh.colors.resize(from.positions.size());
  for (int f = 0; f < static_cast<int>(from.faces.size()); ++f) {
    for (int corner = 0; corner < 3; ++corner) {
      const Hit hit{0, f, corner == 1 ? 1.f : 0.f, corner == 2 ? 1.f : 0.f};
      mesh.colors[from.faces[f][corner]] = synth::ToSrgb(DiffuseRadiance(hit, 0.002f));
    }
  }
  return mesh;
}

}  // namespace livemvs
