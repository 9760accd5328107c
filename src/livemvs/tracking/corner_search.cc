#include "livemvs/tracking/corner_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "livemvs/tracking/dictionary.h"
#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// Moves points to their mean and scales them to unit distance from it.
Matrix3d Normaliser(const std::vector<Vector2d>& points) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p / static_cast<double>(points.size());
  double distance = 0;
  for (const Vector2d& p : points) distance += (p - mean).norm();
  const double scale = static_cast<double>(points.size()) / std::max(1e-12, distance);
  Matrix3d n;
  n << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return n;
}

}  // namespace

std::optional<Matrix3d> FitHomography(const std::vector<Vector2d>& points,
                                      const std::vector<Vector2d>& pixels) {
  if (points.size() < 4) return std::nullopt;
  const Matrix3d a = Normaliser(points), b = Normaliser(pixels);
  Eigen::Matrix<double, 9, 9> m = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p = a * points[i].homogeneous();
    const Vector2d q = (b * pixels[i].homogeneous()).head<2>();
    Eigen::Matrix<double, 2, 9> row = Eigen::Matrix<double, 2, 9>::Zero();
    row.block<1, 3>(0, 0) = p.transpose();
    row.block<1, 3>(1, 3) = p.transpose();
    row.block<1, 3>(0, 6) = -q.x() * p.transpose();
    row.block<1, 3>(1, 6) = -q.y() * p.transpose();
    m += row.transpose() * row;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(m);
  // The second smallest vanishes too where points lie on a line.
  if (!(eigen.eigenvalues()[1] > 1e-9 * eigen.eigenvalues()[8])) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = eigen.eigenvectors().col(0);
  Matrix3d normalised;
  normalised << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  const Matrix3d homography = b.inverse() * normalised * a;
  if (!homography.allFinite()) return std::nullopt;
  return homography;
}

CornerSearch::CornerSearch(const Board& board)
    : corners_(CornersOf(board)), markers_(MarkersOf(board)), square_(board.square) {
  geometry_.margin = 0.5 * (board.square - board.marker);
  // Beyond the white margin lies the marker's border, black on both sides of the corner.
  const int cells = BitsOf(board.dictionary, board.first_id).side + 2;
  geometry_.radius = geometry_.margin + 0.8 * board.marker / cells;
}

std::vector<std::optional<CornerView>> CornerSearch::ViewsFromPose(
    const Projector& projector, const Rigid3d& cam_from_world) const {
  std::vector<std::optional<CornerView>> views(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Eigen::Vector3d p = cam_from_world * corners_[i].point;
    const auto pixel = projector.Project(p);
    if (!pixel || !projector.camera().Contains(*pixel, 4)) continue;
    // The lens is linear in so small a neighbourhood, the perspective is kept: with the ray (x, y)
    // = (X, Y) / Z, pixel + J ((x, y) - (x0, y0)).
    const Eigen::Matrix2d j =
        ProjectWithDerivatives(projector.camera(), p, false).by_point.leftCols<2>() * p.z();
    Matrix3d pixel_from_ray = Matrix3d::Identity();
    pixel_from_ray.topLeftCorner<2, 2>() = j;
    pixel_from_ray.topRightCorner<2, 1>() = *pixel - j * (p.head<2>() / p.z());
    Matrix3d ray_from_sheet;
    ray_from_sheet << cam_from_world.rotation.col(0), cam_from_world.rotation.col(1), p;
    views[i] = CornerView{pixel_from_ray * ray_from_sheet, corners_[i].black_up_right};
  }
  return views;
}

std::vector<std::optional<CornerView>> CornerSearch::ViewsFromMarkers(
    const std::vector<DetectedMarker>& markers) const {
  std::vector<std::optional<CornerView>> views(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Vector2d corner = corners_[i].point.head<2>();
    std::vector<Vector2d> points, pixels;
    // The two markers at the corner, and those across the next squares.
    for (const double reach : {1.0, 2.2}) {
      points.clear();
      pixels.clear();
      for (const DetectedMarker& m : markers) {
        const BoardMarker& marker = markers_[m.index];
        const Vector2d middle = 0.5 * (marker.corners[0] + marker.corners[2]).head<2>();
        if ((middle - corner).lpNorm<Eigen::Infinity>() > reach * square_) continue;
        for (int k = 0; k < 4; ++k) {
          points.emplace_back(marker.corners[k].head<2>() - corner);
          pixels.push_back(m.corners[k]);
        }
      }
      if (points.size() >= 8) break;
    }
    if (points.size() < 8) continue;
    if (const auto h = FitHomography(points, pixels)) {
      views[i] = CornerView{*h, corners_[i].black_up_right};
    }
  }
  return views;
}

std::vector<FoundCorner> CornerSearch::Find(ImageView<std::uint8_t> image,
                                            const std::vector<std::optional<CornerView>>& views,
                                            const CornerFitOptions& options,
                                            int every) const {
  std::vector<FoundCorner> found;
  int expected = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i] || expected++ % every != 0) continue;
    if (const auto fit = FitCorner(image, *views[i], geometry_, options)) {
      found.push_back({static_cast<int>(i), *fit});
    }
  }
  return found;
}

std::vector<FoundCorner> CornerSearch::FindByMarkers(ImageView<std::uint8_t> image,
                                                     const std::vector<DetectedMarker>& markers,
                                                     const CornerFitOptions& options) const {
  std::vector<std::optional<CornerView>> views = ViewsFromMarkers(markers);
  CornerFitOptions coarse = options;
  coarse.max_shift_px = 2 * options.max_shift_px;
  const std::vector<FoundCorner> first = Find(image, views, coarse);
  // Only where something was found, and from there.
  std::vector<std::optional<CornerView>> again(views.size());
  for (const FoundCorner& corner : first) {
    CornerView view = *views[corner.index];
    const Vector2d shift = corner.fit.pixel - view.Pixel(0, 0);
    Matrix3d move = Matrix3d::Identity();
    move.topRightCorner<2, 1>() = shift;
    view.pixel_from_sheet = move * view.pixel_from_sheet;
    again[corner.index] = view;
  }
  return Find(image, again, options);
}

void CornerSearch::Bend(const Eigen::Vector3d& bend) {
  for (BoardCorner& corner : corners_) {
    Eigen::Vector3d& p = corner.point;
    p.z() = bend.dot(Eigen::Vector3d(p.x() * p.x(), p.x() * p.y(), p.y() * p.y()));
  }
}

std::vector<PointObservation> CornerSearch::Observations(
    const std::vector<FoundCorner>& found) const {
  std::vector<PointObservation> observations;
  observations.reserve(found.size());
  for (const FoundCorner& corner : found) {
    observations.push_back({corners_[corner.index].point, corner.fit.pixel, corner.fit.sigma_px});
  }
  return observations;
}

}  // namespace livemvs
