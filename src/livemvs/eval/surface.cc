#include "livemvs/eval/surface.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "livemvs/eval/split_mix.h"

namespace livemvs {
namespace {

double PointSegmentDistance2(const Eigen::Vector3d& p,
                             const Eigen::Vector3d& a,
                             const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).squaredNorm();
}

void CheckMesh(const TriangleMesh& mesh) {
  if (mesh.vertices.empty() || mesh.faces.empty()) {
    throw std::invalid_argument("MeshSurface: the mesh has no triangles");
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      throw std::invalid_argument("MeshSurface: vertex " + std::to_string(i) + " is not finite");
    }
  }
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (static_cast<std::size_t>(mesh.faces[i][corner]) >= mesh.vertices.size()) {
        throw std::invalid_argument("MeshSurface: triangle " + std::to_string(i) +
                                    " names a vertex that does not exist");
      }
    }
  }
}

}  // namespace

double PointTriangleDistance(const Eigen::Vector3d& point,
                             const Eigen::Vector3d& a,
                             const Eigen::Vector3d& b,
                             const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double length2 = normal.squaredNorm();
  if (length2 > 0) {
    // Above the inside of the triangle where the point is on the inner side of all three edges.
    const bool inside = (b - a).cross(point - a).dot(normal) >= 0 &&
                        (c - b).cross(point - b).dot(normal) >= 0 &&
                        (a - c).cross(point - c).dot(normal) >= 0;
    if (inside) return std::abs((point - a).dot(normal)) / std::sqrt(length2);
  }
  return std::sqrt(std::min({PointSegmentDistance2(point, a, b),
                             PointSegmentDistance2(point, b, c),
                             PointSegmentDistance2(point, c, a)}));
}

struct MeshSurface::Impl {
  std::vector<Eigen::Vector3f> vertices;  ///< One more than the mesh has: Embree reads 16 bytes.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  Eigen::Vector3d Corner(std::size_t triangle, int corner) const {
    return vertices[triangles[triangle][static_cast<std::size_t>(corner)]].cast<double>();
  }
};

namespace {

/// What the callback of a closest-point query knows and finds.
struct ClosestPointQuery {
  const std::vector<Eigen::Vector3f>* vertices;
  const std::vector<std::array<std::uint32_t, 3>>* triangles;
  Eigen::Vector3d point;
  double distance = std::numeric_limits<double>::infinity();
};

bool VisitTriangle(RTCPointQueryFunctionArguments* args) {
  auto* query = static_cast<ClosestPointQuery*>(args->userPtr);
  const auto& triangle = (*query->triangles)[args->primID];
  const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
    return (*query->vertices)[triangle[i]].cast<double>();
  };
  const double distance = PointTriangleDistance(query->point, corner(0), corner(1), corner(2));
  if (!(distance < query->distance)) return false;
  query->distance = distance;
  // Rounded up, so that float32 boxes never cut off a closer triangle.
  const float radius = static_cast<float>(distance) * (1 + 1e-5f) + 1e-30f;
  if (!(radius < args->query->radius)) return false;
  args->query->radius = radius;
  return true;
}

RTCRayHit MakeRay(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float t_max) {
  RTCRayHit ray{};
  ray.ray.org_x = origin.x();
  ray.ray.org_y = origin.y();
  ray.ray.org_z = origin.z();
  ray.ray.dir_x = direction.x();
  ray.ray.dir_y = direction.y();
  ray.ray.dir_z = direction.z();
  ray.ray.tnear = 0;
  ray.ray.tfar = t_max;
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

}  // namespace

MeshSurface::MeshSurface(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>()) {
  CheckMesh(mesh);
  impl_->vertices.assign(mesh.vertices.begin(), mesh.vertices.end());
  impl_->vertices.push_back(Eigen::Vector3f::Zero());
  impl_->triangles.reserve(mesh.faces.size());
  for (const auto& t : mesh.faces) {
    impl_->triangles.push_back({static_cast<std::uint32_t>(t[0]),
                                static_cast<std::uint32_t>(t[1]),
                                static_cast<std::uint32_t>(t[2])});
  }
  impl_->device = rtcNewDevice(nullptr);
  if (impl_->device == nullptr) throw std::runtime_error("MeshSurface: Embree does not start");
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry,
                             RTC_BUFFER_TYPE_VERTEX,
                             0,
                             RTC_FORMAT_FLOAT3,
                             impl_->vertices.data(),
                             0,
                             sizeof(Eigen::Vector3f),
                             mesh.vertices.size());
  rtcSetSharedGeometryBuffer(geometry,
                             RTC_BUFFER_TYPE_INDEX,
                             0,
                             RTC_FORMAT_UINT3,
                             impl_->triangles.data(),
                             0,
                             sizeof(impl_->triangles[0]),
                             impl_->triangles.size());
  rtcSetGeometryPointQueryFunction(geometry, &VisitTriangle);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene);
  if (rtcGetDeviceError(impl_->device) != RTC_ERROR_NONE) {
    throw std::runtime_error("MeshSurface: Embree cannot build the scene");
  }
}

MeshSurface::~MeshSurface() = default;
MeshSurface::MeshSurface(MeshSurface&&) noexcept = default;

double MeshSurface::Distance(const Eigen::Vector3d& point) const {
  ClosestPointQuery closest{&impl_->vertices, &impl_->triangles, point};
  RTCPointQuery query{};
  query.x = static_cast<float>(point.x());
  query.y = static_cast<float>(point.y());
  query.z = static_cast<float>(point.z());
  query.radius = std::numeric_limits<float>::infinity();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &query, &context, nullptr, &closest);
  return closest.distance;
}

std::optional<MeshSurface::Hit> MeshSurface::FirstHit(const Eigen::Vector3f& origin,
                                                      const Eigen::Vector3f& direction) const {
  RTCRayHit ray = MakeRay(origin, direction, std::numeric_limits<float>::infinity());
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return Hit{ray.ray.tfar,
             ray.hit.primID,
             Eigen::Vector3f(1 - ray.hit.u - ray.hit.v, ray.hit.u, ray.hit.v)};
}

bool MeshSurface::IsBlocked(const Eigen::Vector3f& origin,
                            const Eigen::Vector3f& direction,
                            float t_max) const {
  RTCRay ray = MakeRay(origin, direction, t_max).ray;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0;
}

std::vector<Eigen::Vector3f> MeshSurface::Sample(std::size_t count,
                                                 std::uint64_t seed,
                                                 const std::optional<Box>& box) const {
  // Cumulative area over the triangles that may reach into the box.
  std::vector<std::size_t> candidates;
  std::vector<double> cumulative;
  double area = 0;
  for (std::size_t i = 0; i < impl_->triangles.size(); ++i) {
    const Eigen::Vector3d a = impl_->Corner(i, 0), b = impl_->Corner(i, 1), c = impl_->Corner(i, 2);
    if (box && ((a.cwiseMax(b).cwiseMax(c).array() < box->min.array()).any() ||
                (a.cwiseMin(b).cwiseMin(c).array() > box->max.array()).any())) {
      continue;
    }
    area += 0.5 * (b - a).cross(c - a).norm();
    candidates.push_back(i);
    cumulative.push_back(area);
  }
  std::vector<Eigen::Vector3f> samples;
  if (!(area > 0)) return samples;

  constexpr std::size_t kMaxTriesPerSample = 200;
  SplitMix64 random(seed);
  samples.reserve(count);
  for (std::size_t tries = 0; samples.size() < count && tries / kMaxTriesPerSample < count;
       ++tries) {
    const auto found =
        std::upper_bound(cumulative.begin(), cumulative.end(), random.Uniform() * area);
    const std::size_t chosen =
        std::min(static_cast<std::size_t>(found - cumulative.begin()), candidates.size() - 1);
    // Uniform in the triangle: fold the square over its diagonal.
    double u = random.Uniform(), v = random.Uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const std::size_t t = candidates[chosen];
    const Eigen::Vector3d a = impl_->Corner(t, 0);
    const Eigen::Vector3d p = a + u * (impl_->Corner(t, 1) - a) + v * (impl_->Corner(t, 2) - a);
    if (!box || box->Contains(p)) samples.push_back(p.cast<float>());
  }
  return samples;
}

}  // namespace livemvs
