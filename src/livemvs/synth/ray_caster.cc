#include "livemvs/synth/ray_caster.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

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
  std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(Eigen::Vector3f));
  std::memcpy(faces, mesh.faces.data(), mesh.faces.size() * sizeof(Eigen::Vector3i));
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
