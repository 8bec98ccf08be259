// Smooth curves through the feature lines of the first mesh, in its rest charts.
//
// Symbols   P_k   points of a line;  T_k   unit tangents there;  l_k = |P_(k+1) - P_k|
// Between P_k and P_(k+1) the cubic with end points P and end slopes l_k T. T_k is that of the circle through P_(k-1), P_k
// and P_(k+1), or the direction of a straight neighbour: a line that goes over into an arc has its own direction there.
// Theory: docs/theory/remeshing.md, operations.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "features.hpp"

namespace voile::adapt {

class RestCurves {
 public:
  RestCurves(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, const Features& features);
  [[nodiscard]] std::optional<Vec3> middle(const Vec3& a, const Vec3& b) const;
  [[nodiscard]] double deviation(const Vec3& a, const Vec3& b) const;

 private:
  struct Curve {
    std::vector<Vec3> points;         ///< of a closed curve the first is repeated at the end
    std::vector<Vec3> before, after;  ///< tangents at the points, of the pieces that end and begin there
    bool closed = false;
  };
  /// A point of a curve: piece plus fraction of its parameter.
  struct Place {
    Index curve = no_index;
    double at = 0.0;
  };
  void add(std::vector<Vec3> points, bool closed);
  void index_pieces();
  [[nodiscard]] Vec3 point(const Place& p) const;
  [[nodiscard]] std::vector<Place> places_of(const Vec3& x) const;
  [[nodiscard]] std::optional<std::array<Place, 2>> between(const Vec3& a, const Vec3& b) const;
  [[nodiscard]] std::array<std::int64_t, 3> cell_of(const Vec3& x) const;

  std::vector<Curve> curves_;
  double cell_ = 1.0;
  std::vector<std::pair<std::array<std::int64_t, 3>, std::array<Index, 2>>> grid_;  ///< cell; curve and piece
};

}  // namespace voile::adapt
