#include "seam_tension.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "mesh/weld.hpp"

namespace voile::system {

namespace {

/// A segment of the line.
struct Side {
  int layers = 0;       ///< triangles at it
  bool shared = false;  ///< another seam has it too
};

struct Fabric {
  const energy::Sheet& sheet;
  const std::vector<double>& force;  ///< TriangleFields::membrane_force
  const std::vector<Vec3>& places;
  std::map<mesh::Segment, Side> line{};  ///< by its vertices, the smaller one first
  bool has_own_edge = false;             ///< an edge that is still open, and in no other seam

  [[nodiscard]] const mesh::SurfaceMesh& mesh() const { return sheet.mesh(); }
  [[nodiscard]] const mesh::Triangle& corners(Index t) const { return mesh().triangles()[static_cast<std::size_t>(t)]; }
};

/// Derivative of the membrane energy of a triangle with respect to its corner i: A F N grad(phi_i). [N]
Vec3 corner_force(const Fabric& f, Index t, int i) {
  const mesh::Frame frame = f.sheet.frame(t);
  const mesh::Triangle& v = f.corners(t);
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const Vec2 foot = frame.to_plane(f.mesh().rest_corner(t, j));
  Mat2 rest;
  rest << frame.to_plane(f.mesh().rest_corner(t, i)) - foot, frame.to_plane(f.mesh().rest_corner(t, k)) - foot;
  Eigen::Matrix<double, 3, 2> now;
  now << f.places[v[i]] - f.places[v[j]], f.places[v[k]] - f.places[v[j]];
  const double* n = f.force.data() + 3 * static_cast<std::size_t>(t);
  Mat2 membrane;
  membrane << n[0], n[2], n[2], n[1];
  const Mat2 inverse = rest.inverse();
  return 0.5 * std::abs(rest.determinant()) * (now * inverse * membrane * inverse.row(0).transpose());
}

/// In the deformed triangle, out of it across its side s; as long as that side is at rest. [m]
Vec3 outward_normal(const Fabric& f, Index t, int s) {
  const mesh::Triangle& v = f.corners(t);
  const int i = (s + 1) % 3, j = (s + 2) % 3;
  const Vec3 edge = (f.places[v[j]] - f.places[v[i]]).normalized(), to_edge = f.places[v[i]] - f.places[v[s]];
  return (to_edge - edge * edge.dot(to_edge)).normalized() *
         (f.mesh().rest_corner(t, i) - f.mesh().rest_corner(t, j)).norm();
}

/// The triangles at a vertex by the side of the line that they lie on: neighbours across an edge that is not of the line.
std::vector<std::vector<Index>> sides_of_line(const Fabric& f, Index v) {
  const std::vector<Index> all = f.mesh().triangles_of_vertex(v);
  std::vector<std::size_t> side(all.size());
  std::iota(side.begin(), side.end(), std::size_t{0});
  const auto share_an_edge = [&](Index a, Index b) {
    return std::ranges::any_of(f.corners(a), [&](Index w) {
      return w != v && f.mesh().side_of(b, v, w) >= 0 && !f.line.contains(mesh::ascending(v, w));
    });
  };
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = a + 1; b < all.size(); ++b)
      if (side[a] != side[b] && share_an_edge(all[a], all[b]))
        std::replace(side.begin(), side.end(), std::max(side[a], side[b]), std::min(side[a], side[b]));
  std::vector<std::vector<Index>> sides(all.size());
  for (std::size_t a = 0; a < all.size(); ++a) sides[side[a]].push_back(all[a]);
  return sides;
}

struct Pull {
  double force = 0.0, length = 0.0;  ///< [N], [m]
  int layers = 0;                    ///< that meet there
};

/// What the triangles on one side of the line pull a vertex of it with, and the length at rest that this acts on.
Pull pull_of_side(const Fabric& f, Index v, const std::vector<Index>& triangles) {
  Vec3 force = Vec3::Zero(), normal = Vec3::Zero();
  double length = 0.0;
  int layers = 0;
  for (const Index t : triangles) {
    const mesh::Triangle& corners = f.corners(t);
    for (int i = 0; i < 3; ++i) {
      if (corners[i] == v) {
        force += corner_force(f, t, i);
        continue;
      }
      const auto at = f.line.find(mesh::ascending(v, corners[i]));
      if (at == f.line.end()) continue;
      // An open edge that several seams pull at bears them all: the other edge tells what this one does.
      if (at->second.layers == 1 && at->second.shared && f.has_own_edge) return {};
      const Vec3 out = 0.5 * outward_normal(f, t, f.mesh().side_of(t, v, corners[i]));
      normal += out;
      length += out.norm();
      layers = std::max(layers, at->second.layers);
    }
  }
  // Where a line ends amid the fabric both of its sides are one.
  if (!(normal.norm() > 0.5 * length)) return {};
  return {force.dot(normal.normalized()), normal.norm(), layers};
}

/// The segments of the line, and which of them others have too.
void find_line(Fabric& f, const mesh::Group& line) {
  for (const mesh::Segment& s : line.segments) {
    Side& side = f.line[mesh::ascending(s[0], s[1])];
    side.layers = 0;
    for (const Index t : f.mesh().triangles_of_vertex(s[0]))
      side.layers += f.mesh().side_of(t, s[0], s[1]) >= 0 ? 1 : 0;
  }
  const std::string prefix = mesh::seam_group("");
  for (const mesh::Group& other : f.mesh().groups()) {
    if (other.dimension != 1 || other.name == line.name || !other.name.starts_with(prefix)) continue;
    for (const mesh::Segment& s : other.segments)
      if (const auto at = f.line.find(mesh::ascending(s[0], s[1])); at != f.line.end()) at->second.shared = true;
  }
  f.has_own_edge = std::ranges::any_of(f.line, [](const auto& s) { return s.second.layers == 1 && !s.second.shared; });
}

/// Mean of the lengths at rest of both sides, or of all layers.
double length_at_rest(const Fabric& f) {
  double sum = 0.0;
  for (const auto& [segment, side] : f.line) {
    double sides = 0.0;
    for (const Index t : f.mesh().triangles_of_vertex(segment[0])) {
      const int s = f.mesh().side_of(t, segment[0], segment[1]);
      if (s < 0) continue;
      sides += (f.mesh().rest_corner(t, (s + 1) % 3) - f.mesh().rest_corner(t, (s + 2) % 3)).norm();
    }
    sum += sides / std::max(side.layers, 2);  // each side of an open seam is a segment of its own
  }
  return sum;
}

/// Of the tension from one vertex of the line to the next: what changes smoothly along it is none.
double scatter(const Fabric& f, const std::map<Index, Pull>& pulls) {
  double sum = 0.0;
  int count = 0;
  for (const auto& [segment, side] : f.line) {
    const auto a = pulls.find(segment[0]), b = pulls.find(segment[1]);
    if (a == pulls.end() || b == pulls.end()) continue;
    sum += 0.5 * std::pow(a->second.force / a->second.length - b->second.force / b->second.length, 2);
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

}  // namespace

SeamTension seam_tension(const energy::Sheet& sheet, const mesh::Group& line, const std::vector<double>& force,
                         const std::vector<Vec3>& places) {
  Fabric fabric{sheet, force, places};
  find_line(fabric, line);
  std::set<Index> vertices;
  for (const auto& [segment, side] : fabric.line) vertices.insert(segment.begin(), segment.end());
  SeamTension tension{line.name, length_at_rest(fabric)};
  std::map<Index, Pull> pulls;
  double total = 0.0, length = 0.0;
  for (const Index v : vertices) {
    Pull here;
    for (const std::vector<Index>& side : sides_of_line(fabric, v)) {
      const Pull one = pull_of_side(fabric, v, side);
      if (!(one.length > 0.0)) continue;
      here.force += one.force;
      here.length += one.length * 2.0 / std::max(one.layers, 2);
      tension.largest = std::max(tension.largest, one.force / one.length);
    }
    if (!(here.length > 0.0)) continue;
    total += here.force;
    length += here.length;
    pulls[v] = here;
  }
  if (pulls.empty()) return tension;
  tension.mean = total / length;
  tension.error = scatter(fabric, pulls);
  return tension;
}

}  // namespace voile::system
