#pragma once

#include <cmath>

#include "livemvs/backend/mark_image.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/platform.h"
#include "livemvs/core/point.h"
#include "livemvs/core/posed_camera.h"

namespace livemvs {

// Which pixels a point covers, on the host and on devices.

/// What decides where a point covers; see Point.
struct CoverPoint {
  float position[3];
  float normal[3];
  float footprint;
};

inline CoverPoint CoverPointOf(const Point& p) {
  return {{p.position.x(), p.position.y(), p.position.z()},
          {p.normal.x(), p.normal.y(), p.normal.z()},
          p.footprint};
}

/// A frame's camera as points meet it.
struct CoverView {
  CameraParams<float> camera;
  float rotation[9];  ///< cam_from_world, row-major.
  float translation[3];
  float center[3];  ///< Of the camera, in the world.
  float width, height;
  float pixel_width;  ///< At unit depth.
  float min_cosine;   ///< Of the angle between directions from which a point covers.
};

/// @param angle_deg  Points seen from directions further apart than this do not cover each other.
inline CoverView MakeCoverView(const PosedCamera& frame, float angle_deg) {
  CoverView view;
  view.camera = MakeCameraParams<float>(frame.camera);
  const Eigen::Vector3d center = frame.cam_from_world.Center();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      view.rotation[3 * i + j] = static_cast<float>(frame.cam_from_world.rotation(i, j));
    }
    view.translation[i] = static_cast<float>(frame.cam_from_world.translation[i]);
    view.center[i] = static_cast<float>(center[i]);
  }
  view.width = static_cast<float>(frame.camera.width);
  view.height = static_cast<float>(frame.camera.height);
  view.pixel_width = static_cast<float>(1 / frame.camera.FocalLength());
  view.min_cosine = std::cos(angle_deg * static_cast<float>(M_PI / 180));
  return view;
}

/// Marks the pixel that a point projects to, on the levels on which it is not much wider than a
/// pixel, if it was seen from a similar direction.
/// @param marks  Of each level of the frame's pyramid.
template <typename Model>
LIVEMVS_DEVICE void MarkPoint(const CoverView& view,
                              const CoverPoint& point,
                              const MarkImage* marks,
                              int levels) {
  // A point whose pixel was this many times as wide as a pixel here does not cover it.
  constexpr float kCoarser = 1.5F;
  constexpr float kHalf = 0.5F;  // pixels per pixel of the next coarser level
  // Sums of three products in this order, which Eigen has.
  const auto dot = [](const float* a, const float* b) {
    return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
  };
  float p[3], towards[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = dot(view.rotation + 3 * i, point.position) + view.translation[i];
    towards[i] = view.center[i] - point.position[i];
  }
  if (!(p[2] > 0)) return;
  const float x = p[0] / p[2], y = p[1] / p[2];
  if (!(x * x + y * y <= view.camera.r2_max)) return;
  const auto distorted = Model::Distort(view.camera.k, x, y);
  float u = view.camera.fx * distorted.x + view.camera.cx;
  float v = view.camera.fy * distorted.y + view.camera.cy;
  if (!(u >= 0 && v >= 0 && u < view.width && v < view.height)) return;
  // The back of an object does not cover its front: compare the directions of view.
  const float distance = Sqrt(dot(p, p));
  if (!(dot(towards, point.normal) > view.min_cosine * distance)) return;
  // A coarse point does not stand for the finer ones that may still be found.
  float widest = kCoarser * distance * view.pixel_width;
  for (int level = 0; level < levels; ++level) {
    const MarkImage& picture = marks[level];
    const int column = static_cast<int>(Floor(u + kHalf)), row = static_cast<int>(Floor(v + kHalf));
    if (point.footprint <= widest && column >= 0 && row >= 0 && column < picture.width &&
        row < picture.height) {
      SetMark(picture.data + row * picture.stride + column);
    }
    u = (u + kHalf) * kHalf - kHalf;
    v = (v + kHalf) * kHalf - kHalf;
    widest *= 2;
  }
}

}  // namespace livemvs
