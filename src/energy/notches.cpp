#include "notches.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <utility>

namespace voile::energy {

namespace {

constexpr double thicknesses = 20.0;                        ///< R below which it counts
constexpr double corner = 50.0 / 180.0 * std::numbers::pi;  ///< turn from which on a vertex is no part of an arc
constexpr double straight = 1e-6;                           ///< turn that is round-off of a straight edge

/// h sqrt(E_1/E_2), E_1 >= E_2: strains change faster across stiff fibres.
double thickness(const Material& m) {
  const double along = m.membrane(0, 0), across = m.membrane(1, 1), least = std::min(along, across);
  if (!(least > 0.0)) return 0.0;
  const double square = 12.0 * std::max(m.bending(0, 0) / along, m.bending(1, 1) / across);
  return std::sqrt(square * std::max(along, across) / least);
}

/// What vertices of the boundary know.
struct Rim {
  int edges = 0;
  double length = 0.0, angle = 0.0, thickness = 0.0;  ///< of both edges together; inside the sheet
};

class Search {
 public:
  Search(const Sheet& sheet, const std::vector<Index>& root)
      : sheet_(sheet),
        mesh_(sheet.mesh()),
        alike_(static_cast<std::size_t>(mesh_.vertex_count())),
        rims_(alike_.size()),
        near_(static_cast<std::size_t>(mesh_.triangle_count()), 0) {
    for (Index v = 0; v < mesh_.vertex_count(); ++v)
      root_.push_back(root.empty() ? v : root[static_cast<std::size_t>(v)]);
    for (Index v = 0; v < mesh_.vertex_count(); ++v) alike_[place(v)].push_back(v);
  }

  void find_rims() {
    std::map<std::pair<Index, Index>, int> sides;  // where a periodic sheet continues there are two
    each_side([&](Index, int, const std::pair<Index, Index>& ends) { ++sides[ends]; });
    each_side([&](Index t, int s, const std::pair<Index, Index>& ends) {
      if (sides[ends] > 1) return;
      const double length = (mesh_.rest_corner(t, (s + 1) % 3) - mesh_.rest_corner(t, (s + 2) % 3)).norm();
      for (const Index end : {ends.first, ends.second}) {
        Rim& rim = rims_[static_cast<std::size_t>(end)];
        ++rim.edges;
        rim.length += length;
        rim.thickness = std::max(rim.thickness, thickness(sheet_.material(t)));
      }
    });
    for (Index t = 0; t < mesh_.triangle_count(); ++t)
      for (int i = 0; i < 3; ++i) {
        Rim& rim = rims_[place(mesh_.triangles()[t][i])];
        if (rim.edges != 2) continue;
        const Vec3 a = mesh_.rest_corner(t, (i + 1) % 3) - mesh_.rest_corner(t, i),
                   b = mesh_.rest_corner(t, (i + 2) % 3) - mesh_.rest_corner(t, i);
        rim.angle += std::atan2(a.cross(b).norm(), a.dot(b));
      }
  }

  /// From each arc outwards along edges, as far as its radius.
  void mark() {
    std::vector<double> left(rims_.size(), -1.0);  // of the radius
    std::priority_queue<std::pair<double, Index>> next;
    const auto reach = [&](Index root, double rest) {
      if (rest <= left[static_cast<std::size_t>(root)]) return;
      left[static_cast<std::size_t>(root)] = rest;
      next.emplace(rest, root);
    };
    for (Index v = 0; v < mesh_.vertex_count(); ++v)
      if (const double radius = radius_at(rims_[static_cast<std::size_t>(v)]); radius > 0.0) reach(v, radius);
    while (!next.empty()) {
      const auto [rest, root] = next.top();
      next.pop();
      if (rest < left[static_cast<std::size_t>(root)]) continue;
      for (const Index v : alike_[static_cast<std::size_t>(root)])
        for (const Index t : mesh_.triangles_of_vertex(v)) {
          near_[static_cast<std::size_t>(t)] = 1;
          for (const Index w : mesh_.triangles()[t])
            if (const double there = rest - (mesh_.positions()[w] - mesh_.positions()[v]).norm(); there >= 0.0)
              reach(root_[static_cast<std::size_t>(w)], there);
        }
    }
  }

  [[nodiscard]] std::vector<char> take() {
    if (std::find(near_.begin(), near_.end(), 1) == near_.end()) near_.clear();
    return std::move(near_);
  }

 private:
  [[nodiscard]] std::size_t place(Index v) const {
    return static_cast<std::size_t>(root_[static_cast<std::size_t>(v)]);
  }

  /// Calls work(t, s, roots of its ends) for each side of the boundary.
  template <class Work>
  void each_side(const Work& work) const {
    for (Index t = 0; t < mesh_.triangle_count(); ++t)
      for (int s = 0; s < 3; ++s) {
        if (sheet_.patches().apex(t, s) != no_index) continue;
        const mesh::Triangle& v = mesh_.triangles()[t];
        const auto [a, b] = std::minmax(root_[static_cast<std::size_t>(v[(s + 1) % 3])],
                                        root_[static_cast<std::size_t>(v[(s + 2) % 3])]);
        work(t, s, std::pair<Index, Index>(a, b));
      }
  }

  /// Of the arc there, if it counts; else 0.
  [[nodiscard]] static double radius_at(const Rim& rim) {
    const double turn = rim.angle - std::numbers::pi;
    if (rim.edges != 2 || turn < straight || turn > corner) return 0.0;
    const double radius = 0.5 * rim.length / turn;
    return radius < thicknesses * rim.thickness ? radius : 0.0;
  }

  const Sheet& sheet_;
  const mesh::SurfaceMesh& mesh_;
  std::vector<Index> root_;
  std::vector<std::vector<Index>> alike_;  ///< vertices of each root
  std::vector<Rim> rims_;                  ///< of roots
  std::vector<char> near_;
};

}  // namespace

std::vector<char> near_notches(const Sheet& sheet, const std::vector<Index>& root) {
  Search search(sheet, root);
  search.find_rims();
  search.mark();
  return search.take();
}

}  // namespace voile::energy
