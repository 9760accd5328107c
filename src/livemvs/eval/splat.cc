#include "livemvs/eval/splat.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr float kMinRadiusPx = 0.75f;
constexpr int kBandRows = 32;

/// A splat on the picture.
struct Disc {
  float u, v, z;
  float radius_px;                 ///< 0: not in the picture.
  float radius;                    ///< [scene]
  float slope_u = 0, slope_v = 0;  ///< How fast the disc's plane recedes. [scene / px]
};

/// The camera with `scale` times the pixels; pixel centres stay integers.
Camera ScaledCamera(Camera camera, int scale) {
  camera.width *= scale;
  camera.height *= scale;
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx = (camera.cx + 0.5) * scale - 0.5;
  camera.cy = (camera.cy + 0.5) * scale - 0.5;
  return camera;
}

FragmentImage EmptyFragments(const Camera& camera) {
  FragmentImage image;
  image.width = camera.width;
  image.height = camera.height;
  image.fragments.resize(static_cast<std::size_t>(camera.width) * camera.height);
  return image;
}

std::vector<Disc> ProjectSplats(const std::vector<Splat>& splats,
                                const RenderView& view,
                                const Camera& camera) {
  const Projector projector(camera);
  const Eigen::Matrix3f rotation = view.cam_from_world.rotation.cast<float>();
  // Something right in front of the viewer must not cover the picture.
  const double near = 0.02 * view.focus_depth;
  const float max_radius_px = static_cast<float>(camera.height) / 64;
  std::vector<Disc> discs(splats.size());
  ParallelForRange(0, splats.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i != last; ++i) {
      Disc& disc = discs[i];
      disc.radius_px = 0;
      const Eigen::Vector3d p = view.cam_from_world * splats[i].position.cast<double>();
      if (!(p.z() > near)) continue;
      const auto pixel = projector.Project(p);
      if (!pixel) continue;
      disc.z = static_cast<float>(p.z());
      disc.u = static_cast<float>(pixel->x());
      disc.v = static_cast<float>(pixel->y());
      const float scene_per_px = disc.z / static_cast<float>(std::abs(camera.fx));
      const float r = std::clamp(splats[i].radius / scene_per_px, kMinRadiusPx, max_radius_px);
      if (disc.u < -r || disc.v < -r || disc.u > static_cast<float>(camera.width) + r ||
          disc.v > static_cast<float>(camera.height) + r) {
        continue;
      }
      disc.radius_px = r;
      disc.radius = r * scene_per_px;
      // The plane through the point, but never so steep that it becomes a spike.
      constexpr float kSteepest = 2;
      const Eigen::Vector3f n = rotation * splats[i].normal;
      if (std::abs(n.z()) > 1e-3f) {
        disc.slope_u = std::clamp(-n.x() / n.z(), -kSteepest, kSteepest) * scene_per_px;
        disc.slope_v = std::clamp(-n.y() / n.z(), -kSteepest, kSteepest) * scene_per_px;
      }
    }
  });
  return discs;
}

/// The discs that touch each band of rows, in order.
std::vector<std::vector<std::uint32_t>> SortIntoBands(const std::vector<Disc>& discs, int height) {
  const int bands = (height + kBandRows - 1) / kBandRows;
  std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(bands));
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const Disc& d = discs[i];
    if (d.radius_px <= 0) continue;
    const int first = static_cast<int>(std::floor((d.v - d.radius_px) / kBandRows));
    const int last = static_cast<int>(std::floor((d.v + d.radius_px) / kBandRows));
    for (int b = std::max(first, 0); b <= std::min(last, bands - 1); ++b) {
      rows[static_cast<std::size_t>(b)].push_back(static_cast<std::uint32_t>(i));
    }
  }
  return rows;
}

/// Calls f(x, y, q, z) with the squared distance from the middle in radii and the plane's depth for
/// the pixels of a disc in the rows.
template <typename F>
void ForEachPixel(const Disc& d, int width, int first_row, int end_row, const F& f) {
  const int y0 = std::max(first_row, static_cast<int>(std::ceil(d.v - d.radius_px)));
  const int y1 = std::min(end_row - 1, static_cast<int>(std::floor(d.v + d.radius_px)));
  const int x0 = std::max(0, static_cast<int>(std::ceil(d.u - d.radius_px)));
  const int x1 = std::min(width - 1, static_cast<int>(std::floor(d.u + d.radius_px)));
  const float scale = 1 / (d.radius_px * d.radius_px);
  for (int y = y0; y <= y1; ++y) {
    const float dy = static_cast<float>(y) - d.v;
    for (int x = x0; x <= x1; ++x) {
      const float dx = static_cast<float>(x) - d.u;
      const float q = (dx * dx + dy * dy) * scale;
      if (q <= 1) f(x, y, q, d.z + d.slope_u * dx + d.slope_v * dy);
    }
  }
}

void DrawBand(const std::vector<Splat>& splats,
              const std::vector<Disc>& discs,
              const std::vector<std::uint32_t>& members,
              const Eigen::Matrix3f& rotation,
              int first_row,
              FragmentImage* image) {
  const int end_row = std::min(first_row + kBandRows, image->height);
  const auto for_each_pixel = [&](std::uint32_t i, const auto& f) {
    ForEachPixel(discs[i], image->width, first_row, end_row, f);
  };
  for (std::uint32_t i : members) {
    for_each_pixel(i, [&](int x, int y, float, float z) {
      float& depth = image->At(x, y).depth;
      depth = std::min(depth, z);
    });
  }
  // What lies within a radius behind the nearest disc is the same surface.
  struct Sum {
    float weight = 0, depth = 0;
  };
  std::vector<Sum> sums(static_cast<std::size_t>(image->width) * (end_row - first_row));
  const auto sum_at = [&](int x, int y) -> Sum& {
    return sums[static_cast<std::size_t>(y - first_row) * image->width + x];
  };
  for (std::uint32_t i : members) {
    const Eigen::Vector3f normal = rotation * splats[i].normal;
    for_each_pixel(i, [&](int x, int y, float q, float z) {
      Fragment& fragment = image->At(x, y);
      if (z > fragment.depth + 1.5f * discs[i].radius) return;
      const float weight = (1.01f - q) * (1.01f - q);
      fragment.color += weight * splats[i].color;
      fragment.normal += weight * normal;
      Sum& sum = sum_at(x, y);
      sum.weight += weight;
      sum.depth += weight * z;
    });
  }
  for (int y = first_row; y < end_row; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const Sum& sum = sum_at(x, y);
      Fragment& fragment = image->At(x, y);
      if (sum.weight <= 0) continue;
      fragment.depth = sum.depth / sum.weight;
      fragment.color /= sum.weight;
      const float length = fragment.normal.norm();
      if (length > 0) fragment.normal /= length;
    }
  }
}

}  // namespace

FragmentImage DrawSplats(const std::vector<Splat>& splats, const RenderView& view, int scale) {
  const Camera camera = ScaledCamera(view.camera, scale);
  FragmentImage image = EmptyFragments(camera);
  const std::vector<Disc> discs = ProjectSplats(splats, view, camera);
  const std::vector<std::vector<std::uint32_t>> bands = SortIntoBands(discs, camera.height);
  const Eigen::Matrix3f rotation = view.cam_from_world.rotation.cast<float>();
  ParallelFor(bands.size(), [&](std::size_t b) {
    DrawBand(splats, discs, bands[b], rotation, static_cast<int>(b) * kBandRows, &image);
  });
  return image;
}

FragmentImage DrawMesh(const TriangleMesh& mesh,
                       const std::vector<Eigen::Vector3f>& vertex_colors,
                       const RenderView& view,
                       int scale) {
  const Camera camera = ScaledCamera(view.camera, scale);
  const Projector projector(camera);
  const MeshSurface surface(mesh);
  FragmentImage image = EmptyFragments(camera);
  const Rigid3d world_from_cam = view.cam_from_world.Inverse();
  const Eigen::Vector3f center = world_from_cam.translation.cast<float>();
  const Eigen::Matrix3f rotation = view.cam_from_world.rotation.cast<float>();
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = projector.Unproject({x, y});
      if (!ray) continue;
      const Eigen::Vector3f direction = (world_from_cam.rotation * *ray).cast<float>();
      const auto hit = surface.FirstHit(center, direction);
      if (!hit) continue;
      Fragment& fragment = image.At(x, y);
      const Eigen::Vector3i& face = mesh.faces[hit->triangle];
      const Eigen::Vector3f& a = mesh.vertices[static_cast<std::size_t>(face[0])];
      const Eigen::Vector3f& b = mesh.vertices[static_cast<std::size_t>(face[1])];
      const Eigen::Vector3f& c = mesh.vertices[static_cast<std::size_t>(face[2])];
      fragment.depth = hit->distance;  // the ray advances 1 in z per length
      fragment.normal = rotation * (b - a).cross(c - a).normalized();
      for (int corner = 0; corner < 3; ++corner) {
        fragment.color +=
            hit->barycentric[corner] * vertex_colors[static_cast<std::size_t>(face[corner])];
      }
    }
  });
  return image;
}

}  // namespace livemvs
