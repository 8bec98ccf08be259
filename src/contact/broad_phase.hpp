// Which pairs may come near: boxes around where points can be, sorted into the cells of a grid.
//
// A pair is a candidate if the boxes of its two figures, each the hull of its points' boxes, come within its reach
// (offset plus activation distance) of each other. Every rank asks for the pairs that hold a point it owns: it then has
// all that act on its rows, and the sets of all ranks together are those of one.
// Source: M. Teschner et al., Vision, Modeling, Visualization (2003) 47-54.
#pragma once

#include <vector>

#include "barrier.hpp"
#include "ccd.hpp"
#include "surface.hpp"

namespace voile::contact {

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
  void include(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  void include(const Box& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  [[nodiscard]] bool contains(const Vec3& x) const {
    return (x.array() >= low.array()).all() && (x.array() <= high.array()).all();
  }
  [[nodiscard]] bool within(const Box& b, double reach) const {
    return (low.array() <= b.high.array() + reach).all() && (b.low.array() <= high.array() + reach).all();
  }
};

/// Points in the order of distance.hpp; of a point and an edge the fourth is no_index.
struct Pair {
  std::array<Index, 4> points;
  PairKind kind;
  int body_a, body_b;
  /// Factor of the barrier [m^2], see contact_set.hpp.
  double area;
  double mollify;         ///< threshold of the mollifier of two edges [m^4]; 0: none
  double fraction = 1.0;  ///< of offset and activation distance that holds between neighbours, see neighbours.hpp
};

[[nodiscard]] inline bool operator<(const Pair& a, const Pair& b) {
  return a.kind != b.kind ? a.kind < b.kind : a.points < b.points;
}

/// Numbers of the points, edges and faces of a surface that are looked at, each ascending.
struct Figures {
  std::vector<Index> points, edges, faces;
};

[[nodiscard]] Figures all_figures(const Surface& surface);

/// All candidates among `figures` that hold an owned point, sorted. `boxes` per point; `owned` per point of the sheet;
/// `asked` per point: only candidates that hold one of these, empty: all.
[[nodiscard]] std::vector<Pair> find_pairs(const Surface& surface, const Figures& figures,
                                           const std::vector<Box>& boxes, const std::vector<char>& owned,
                                           double activation_distance, const std::vector<char>& asked = {});

/// The same by trying every pair: the oracle of the tests.
[[nodiscard]] std::vector<Pair> find_pairs_by_force(const Surface& surface, const std::vector<Box>& boxes,
                                                    const std::vector<char>& owned, double activation_distance);

}  // namespace voile::contact
