#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/mesh.h"
#include "livemvs/eval/surface.h"
#include "livemvs/mesh/sight_lines.h"

namespace livemvs {

/// Colours for the vertices of a mesh from pictures in which they are seen. Frontal and near views
/// count most; of what they say the median is taken, so that a highlight, a shadow or a slip in
/// one of them does not show.
class MeshColorizer {
 public:
  /// @param mesh       Must outlive the colorizer.
  /// @param thickness  A surface this close to a vertex does not hide it. [scene]
  MeshColorizer(const TriangleMesh& mesh, double thickness);

  /// Takes the colours that a picture shows. Multi-threaded.
  void AddFrame(const PosedFrame& frame);

  /// Colours of the vertices; that of `otherwise`, one for each, where no picture showed it.
  std::vector<Rgb> Take(std::vector<Rgb> otherwise) const;

  /// Vertices that a picture showed.
  std::size_t seen() const;

 private:
  /// Views of one vertex that are kept.
  static constexpr std::size_t kMostViews = 8;
  struct Views {
    std::array<float, kMostViews> weight{};
    std::array<Rgb, kMostViews> color{};
    std::uint8_t count = 0;

    void Add(float weight_of_new, const Rgb& color_of_new);
    Rgb Blend() const;
  };

  const TriangleMesh& mesh_;
  MeshSurface surface_;
  std::vector<Eigen::Vector3f> normals_;
  float thickness_;
  std::vector<Views> views_;
};

/// Colours of the points near each vertex, blended.
std::vector<Rgb> ColorsOfPoints(const TriangleMesh& mesh, const SightLines& points);

/// How sharp a picture is: the mean square of its second differences; comparable between pictures
/// of the same scene.
double SharpnessOf(const Picture& picture);

}  // namespace livemvs
