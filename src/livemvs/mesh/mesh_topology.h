#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "livemvs/core/mesh.h"

namespace livemvs {

/// Which faces meet at the edges of a mesh. Edge k of a face runs from its corner k to the next.
class MeshTopology {
 public:
  static constexpr std::int32_t kNone = -1;

  explicit MeshTopology(const TriangleMesh& mesh);

  /// The face on the other side of an edge: kNone where there is none, or more than one.
  std::int32_t Neighbor(std::size_t face, int edge) const {
    return neighbors_[face][static_cast<std::size_t>(edge)];
  }
  /// Edges with three faces and more, or two that do not face the same side.
  std::size_t bad_edges() const { return bad_edges_; }
  /// The faces at such edges.
  const std::vector<std::int32_t>& bad_faces() const { return bad_faces_; }
  /// Edges with one face.
  std::size_t border_edges() const { return border_edges_; }
  /// The part of the surface that each face belongs to, by common edges; parts are numbered from 0.
  std::vector<std::int32_t> Components(std::size_t* count) const;

 private:
  std::vector<std::array<std::int32_t, 3>> neighbors_;
  std::size_t bad_edges_ = 0;
  std::vector<std::int32_t> bad_faces_;
  std::size_t border_edges_ = 0;
};

/// Vertices at which more than one fan of faces meets, ascending.
std::vector<std::int32_t> PinchedVertices(const TriangleMesh& mesh, const MeshTopology& topology);

/// Faces to leave out for no vertex to be pinched: of each one's fans all but the largest;
/// marked 1.
std::size_t MarkPinches(const TriangleMesh& mesh,
                        const MeshTopology& topology,
                        std::vector<char>* marks);

/// Removes the faces that are marked, and the vertices that no face uses any more.
void RemoveFaces(const std::vector<char>& marks, TriangleMesh* mesh);

/// Pairs of faces that intersect although they share no edge; at most `most` of them.
std::vector<std::array<std::int32_t, 2>> IntersectingFaces(const TriangleMesh& mesh,
                                                           std::size_t most = 1000000);

/// Area of a face. [scene^2]
double FaceArea(const TriangleMesh& mesh, std::size_t face);

}  // namespace livemvs
