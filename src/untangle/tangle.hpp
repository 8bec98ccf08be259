// What the parts of an untangling have in common: the points, and what belongs together; private to src/untangle.
//
// Symbols   x_i, P_i, c_i, w, D   as in untangle/untangle.hpp
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "regions.hpp"
#include "untangle.hpp"

namespace voile::untangle {

/// Fraction of the activation distance to which gaps are widened.
inline constexpr double wanted_gap = 1.05;
/// Piercing places count within so much of a triangle or edge beside it: the exact test has said that they meet.
inline constexpr double tolerance = 1e-9;

/// What FindIntersections returns.
using FacePairs = std::vector<std::pair<Index, Index>>;

struct Tangle {
  Tangle(const Surface& surface, const std::vector<Mat3>& free, const UntangleOptions& options, std::vector<Vec3>& x);

  const Surface& surface;
  const std::vector<Mat3>& free;  ///< P_i per sheet point
  const UntangleOptions& options;
  std::vector<Vec3>& x;       ///< of all points; moved only by what takes a Tangle that is not const [m]
  std::vector<Index> pieces;  ///< per sheet point: the connected part of the sheet
  std::map<Segment, std::vector<Index>> faces_of_edge;
  std::vector<std::vector<Index>> faces_of_point;  ///< of the sheet
  std::vector<char> on_border;                     ///< per sheet point

  [[nodiscard]] bool is_face(Index number) const { return number < static_cast<Index>(surface.faces.size()); }
  [[nodiscard]] Vec3 normal(Index face) const {
    const auto& [a, b, c] = surface.faces[face].points;
    return (x[b] - x[a]).cross(x[c] - x[a]).normalized();
  }
  /// Calls add(point, movement) for the movements that change w by d.
  template <class Add>
  void fraction(const std::array<Index, 4>& points, const Vec4& c, const Vec3& d, Add&& add) const;
};

/// The edges of a triangle, each with its lower point first.
[[nodiscard]] inline std::array<Segment, 3> edges_of(const Face& face) {
  const auto& [a, b, c] = face.points;
  return {ascending(a, b), ascending(b, c), ascending(c, a)};
}

template <class Add>
void Tangle::fraction(const std::array<Index, 4>& points, const Vec4& c, const Vec3& d, Add&& add) const {
  const double size = d.norm();
  if (!(size > 0.0)) return;
  const Vec3 n = d / size;
  double sum = 0.0;
  std::array<Vec3, 4> way;
  for (int i = 0; i < 4; ++i) {
    way[i].setZero();
    if (points[i] == no_index || !surface.is_sheet(points[i])) continue;
    way[i] = c[i] * (free[points[i]] * n);
    sum += c[i] * n.dot(way[i]);
  }
  if (sum < tolerance) return;  // nothing that may move
  for (int i = 0; i < 4; ++i)
    if (!way[i].isZero(0.0)) add(points[i], Vec3(way[i] * (size / sum)));
}

}  // namespace voile::untangle
