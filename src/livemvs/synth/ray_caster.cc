#include "livemvs/synth/ray_caster.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "livemvs/core/error.h"

namespace livemvs::synth {

struct RayCaster::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

RayCaster::RayCaster(const SceneMesh& mesh) : impl_(std::make_unique<Impl>()) {
  impl_->device = rtcNewDevice(nullptr);
  if (impl_->device == nullptr) {
    throw Error(ErrorKind::kOutOfResource, "Embree: no device; is the processor too old for SSE2?");
  }
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry,
                                           RTC_BUFFER_TYPE_VERTEX,
                                           0,
                                           RTC_FORMAT_FLOAT3,
                                           sizeof(Eigen::Vector3f),
                                           mesh.positions.size());
  void* faces = rtcSetNewGeometryBuffer(geometry,
                                        RTC_BUFFER_TYPE_INDEX,
                                        0,
                                        RTC_FORMAT_UINT3,
                                        sizeof(Eigen::Vector3i),
                                        mesh.faces.size());
  if (vertices == nullptr || faces == nullptr) {
    rtcReleaseGeometry(geometry);
    throw Error(ErrorKind::kOutOfResource, "Embree: out of memory for the scene's triangles");
  }
  // NOLINTBEGIN(bugprone-undefined-memory-manipulation): Eigen's vectors of fixed size are plain
  // data.
  std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(Eigen::Vector3f));
  std::memcpy(faces, mesh.faces.data(), mesh.faces.size() * sizeof(Eigen::Vector3i));
  // NOLINTEND(bugprone-undefined-memory-manipulation)
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene, geometry);
  rtcReleaseGeometry(geometry);
  // In one thread: the order of triangles in the tree, and with it which of two that share an edge
  // is reported, must not depend on the number of threads.
  tbb::task_arena one_thread(1);
  one_thread.execute([this] { rtcJoinCommitScene(impl_->scene); });
}

RayCaster::~RayCaster() = default;

bool RayCaster::Intersect(const Eigen::Vector3f& origin,
                          const Eigen::Vector3f& direction,
                          Hit* hit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit query{};
  query.ray.org_x = origin.x();
  query.ray.org_y = origin.y();
  query.ray.org_z = origin.z();
  query.ray.dir_x = direction.x();
  query.ray.dir_y = direction.y();
  query.ray.dir_z = direction.z();
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = ~0u;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  *hit = {query.ray.tfar, query.hit.u, query.hit.v, static_cast<int>(query.hit.primID)};
  return true;
}

void RayCaster::Intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
  constexpr std::size_t kWidth = 8;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t first = 0; first < rays.size(); first += kWidth) {
    const std::size_t count = std::min(kWidth, rays.size() - first);
    alignas(32) int valid[kWidth] = {};
    RTCRayHit8 query{};
    for (std::size_t i = 0; i < count; ++i) {
      const Ray& ray = rays[first + i];
      valid[i] = -1;
      query.ray.org_x[i] = ray.origin.x();
      query.ray.org_y[i] = ray.origin.y();
      query.ray.org_z[i] = ray.origin.z();
      query.ray.dir_x[i] = ray.direction.x();
      query.ray.dir_y[i] = ray.direction.y();
      query.ray.dir_z[i] = ray.direction.z();
      query.ray.tfar[i] = std::numeric_limits<float>::infinity();
      query.ray.mask[i] = ~0u;
      query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid, impl_->scene, &context, &query);
    for (std::size_t i = 0; i < count; ++i) {
      const bool none = query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID;
      hits[first + i] = {query.ray.tfar[i],
                         query.hit.u[i],
                         query.hit.v[i],
                         none ? -1 : static_cast<int>(query.hit.primID[i])};
    }
  }
}

bool RayCaster::Occluded(const Eigen::Vector3f& origin,
                         const Eigen::Vector3f& direction,
                         float distance) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tfar = distance;
  ray.mask = ~0u;
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0.f;
}

}  // namespace livemvs::synth
