#include "livemvs/exchange/model.h"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"

namespace livemvs {
namespace {

/// Normals of vertices: of the faces around, each by its area.
void AddFaceNormals(ExchangeModel* model) {
  std::vector<Eigen::Vector3d> sums(model->vertices.size(), Eigen::Vector3d::Zero());
  for (const Eigen::Vector3i& face : model->faces) {
    const auto corner = [&](int i) {
      return model->vertices[static_cast<std::size_t>(face[i])].position.cast<double>().eval();
    };
    const Eigen::Vector3d twice_area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    for (int i = 0; i < 3; ++i) sums[static_cast<std::size_t>(face[i])] += twice_area;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double length = sums[i].norm();
    model->vertices[i].normal =
        length > 0 ? (sums[i] / length).cast<float>().eval() : Eigen::Vector3f::Zero().eval();
  }
  model->has_normals = true;
}

}  // namespace

void ExchangeModel::Check() const {
  if (vertices.empty()) throw std::invalid_argument("model: has no points");
  for (const Point& v : vertices) {
    if (!v.position.allFinite()) throw std::invalid_argument("model: a position is not finite");
  }
  for (const Eigen::Vector3i& face : faces) {
    if (face.minCoeff() < 0 || static_cast<std::size_t>(face.maxCoeff()) >= vertices.size()) {
      throw std::invalid_argument("model: a face names a vertex that does not exist");
    }
  }
}

ExchangeModel MakeExchangeModel(PlyContents contents, const std::string& place) {
  if (contents.cloud.empty()) {
    throw BadInput(place + ": holds no point" +
                   (contents.dropped_vertices > 0 ? " with a finite position" : "") +
                   "; there is nothing to export");
  }
  if (contents.dropped_vertices > 0) {
    LogWarning(place + ": " + std::to_string(contents.dropped_vertices) +
               " points without a finite position are left out, and " +
               std::to_string(contents.dropped_faces) + " faces with them");
  }
  ExchangeModel model;
  model.vertices = std::move(contents.cloud);
  model.faces = std::move(contents.faces);
  model.has_normals = contents.has_normals;
  model.has_colors = contents.has_colors;
  if (model.IsMesh() && !model.has_normals) AddFaceNormals(&model);
  model.Check();
  return model;
}

ExchangeModel MakeExchangeModel(const TriangleMesh& mesh) {
  ExchangeModel model;
  model.vertices.resize(mesh.vertices.size());
  model.has_colors = !mesh.colors.empty();
  if (model.has_colors && mesh.colors.size() != mesh.vertices.size()) {
    throw std::invalid_argument("mesh: has not one colour per vertex");
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    model.vertices[i].position = mesh.vertices[i];
    if (model.has_colors) model.vertices[i].color = mesh.colors[i];
  }
  model.faces = mesh.faces;
  model.Check();
  AddFaceNormals(&model);
  return model;
}

void ThinCloud(std::size_t max_points, int min_views, ExchangeModel* model) {
  if (max_points == 0 && min_views <= 0) return;
  if (model->IsMesh()) throw std::invalid_argument("a mesh cannot be thinned, only a cloud");
  PointCloud& points = model->vertices;
  if (min_views > 0) {
    std::erase_if(points, [&](const Point& p) { return p.views < min_views; });
  }
  const std::size_t count = points.size();
  if (max_points == 0 || count <= max_points) return;
  for (std::size_t i = 0; i < max_points; ++i) points[i] = points[i * count / max_points];
  points.resize(max_points);
}

Eigen::Vector3f UnitNormal(const Point& point) {
  const Eigen::Vector3d n = point.normal.cast<double>();
  const double length = n.norm();
  if (!std::isfinite(length) || length < 1e-6) return Eigen::Vector3f::UnitZ();
  return (n / length).cast<float>();
}

Extent ExtentOf(const ExchangeModel& model) {
  Extent extent{model.vertices.at(0).position.cast<double>(),
                model.vertices.at(0).position.cast<double>()};
  for (const Point& v : model.vertices) {
    extent.min = extent.min.cwiseMin(v.position.cast<double>());
    extent.max = extent.max.cwiseMax(v.position.cast<double>());
  }
  return extent;
}

}  // namespace livemvs
