#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "livemvs/mesh/mesh_topology.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;
using Pair = std::array<std::int32_t, 2>;

/// Six times the volume of the tetrahedron a b c d.
double Volume(const Eigen::Vector3d& a,
              const Eigen::Vector3d& b,
              const Eigen::Vector3d& c,
              const Eigen::Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool OppositeSides(double a, double b) { return (a < 0 && b > 0) || (a > 0 && b < 0); }

/// Whether the segment from p to q passes through the inside of the triangle.
bool Pierces(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Triangle& t) {
  if (!OppositeSides(Volume(t[0], t[1], t[2], p), Volume(t[0], t[1], t[2], q))) return false;
  const double a = Volume(p, q, t[0], t[1]);
  const double b = Volume(p, q, t[1], t[2]);
  const double c = Volume(p, q, t[2], t[0]);
  return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}

class Finder {
 public:
  explicit Finder(const TriangleMesh& mesh) : mesh_(mesh) {}

  std::vector<Pair> Find(std::size_t most) {
    Sort();
    std::vector<std::vector<std::int32_t>> hits(mesh_.faces.size());
    ParallelForRange(0, mesh_.faces.size(), 256, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) FindOf(i, &hits[i]);
    });
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      for (const std::int32_t j : hits[i]) {
        if (pairs.size() < most) pairs.push_back({static_cast<std::int32_t>(i), j});
      }
    }
    return pairs;
  }

 private:
  struct Entry {
    std::uint64_t cell;
    std::int32_t face;
    bool operator<(const Entry& o) const { return cell != o.cell ? cell < o.cell : face < o.face; }
  };

  Triangle Corners(std::size_t face) const {
    Triangle t;
    for (int k = 0; k < 3; ++k) {
      t[static_cast<std::size_t>(k)] =
          mesh_.vertices[static_cast<std::size_t>(mesh_.faces[face][k])].cast<double>();
    }
    return t;
  }

  /// The cells of a grid that the box of a face touches.
  template <typename F>
  void ForCells(std::size_t face, const F& f) const {
    const Triangle t = Corners(face);
    const Eigen::Array3d lo = t[0].cwiseMin(t[1]).cwiseMin(t[2]).array();
    const Eigen::Array3d hi = t[0].cwiseMax(t[1]).cwiseMax(t[2]).array();
    const Eigen::Array3i a = ((lo - min_) / cell_).floor().cast<int>();
    const Eigen::Array3i b = ((hi - min_) / cell_).floor().cast<int>();
    for (int z = a.z(); z <= b.z(); ++z) {
      for (int y = a.y(); y <= b.y(); ++y) {
        for (int x = a.x(); x <= b.x(); ++x) {
          f(static_cast<std::uint64_t>(z) << 42 | static_cast<std::uint64_t>(y) << 21 |
            static_cast<std::uint64_t>(x));
        }
      }
    }
  }

  void Sort() {
    if (mesh_.faces.empty()) return;
    double edges = 0;
    min_ = mesh_.vertices[0].cast<double>();
    Eigen::Array3d max = min_;
    for (std::size_t i = 0; i < mesh_.faces.size(); ++i) {
      const Triangle t = Corners(i);
      double longest = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        longest = std::max(longest, (t[k] - t[(k + 1) % 3]).norm());
        min_ = min_.min(t[k].array());
        max = max.max(t[k].array());
      }
      edges += longest;
    }
    constexpr double kMostCells = 1 << 20;
    cell_ = std::max({1.5 * edges / static_cast<double>(mesh_.faces.size()),
                      (max - min_).maxCoeff() / kMostCells,
                      1e-30});
    for (std::size_t i = 0; i < mesh_.faces.size(); ++i) {
      ForCells(i, [&](std::uint64_t cell) {
        entries_.push_back({cell, static_cast<std::int32_t>(i)});
      });
    }
    std::sort(entries_.begin(), entries_.end());
  }

  void FindOf(std::size_t face, std::vector<std::int32_t>* hits) const {
    std::vector<std::int32_t> near;
    ForCells(face, [&](std::uint64_t cell) {
      const Entry from{cell, static_cast<std::int32_t>(face) + 1};
      for (auto e = std::lower_bound(entries_.begin(), entries_.end(), from);
           e != entries_.end() && e->cell == cell;
           ++e) {
        near.push_back(e->face);
      }
    });
    std::ranges::sort(near);
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const std::int32_t other : near) {
      if (Intersect(face, static_cast<std::size_t>(other))) hits->push_back(other);
    }
  }

  bool Intersect(std::size_t f, std::size_t g) const {
    const Eigen::Vector3i &a = mesh_.faces[f], &b = mesh_.faces[g];
    int shared = 0, shared_a = -1, shared_b = -1;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (a[i] != b[j]) continue;
        ++shared;
        shared_a = i;
        shared_b = j;
      }
    }
    if (shared > 1) return false;
    const Triangle s = Corners(f), t = Corners(g);
    if (!BoxesMeet(s, t)) return false;
    for (int k = 0; k < 3; ++k) {
      // An edge that ends at the common corner touches there; the edge opposite to it counts.
      const auto i = static_cast<std::size_t>(k), j = static_cast<std::size_t>((k + 1) % 3);
      const bool s_free = shared == 0 || (k != shared_a && (k + 1) % 3 != shared_a);
      const bool t_free = shared == 0 || (k != shared_b && (k + 1) % 3 != shared_b);
      if (s_free && Pierces(s[i], s[j], t)) return true;
      if (t_free && Pierces(t[i], t[j], s)) return true;
    }
    return false;
  }

  static bool BoxesMeet(const Triangle& s, const Triangle& t) {
    const auto low = [](const Triangle& x) {
      return x[0].cwiseMin(x[1]).cwiseMin(x[2]).array().eval();
    };
    const auto high = [](const Triangle& x) {
      return x[0].cwiseMax(x[1]).cwiseMax(x[2]).array().eval();
    };
    return (low(s) <= high(t)).all() && (low(t) <= high(s)).all();
  }

  const TriangleMesh& mesh_;
  Eigen::Array3d min_ = Eigen::Array3d::Zero();
  double cell_ = 1;
  std::vector<Entry> entries_;
};

}  // namespace

std::vector<Pair> IntersectingFaces(const TriangleMesh& mesh, std::size_t most) {
  return Finder(mesh).Find(most);
}

}  // namespace livemvs
