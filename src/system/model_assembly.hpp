// Element loops of Model, instantiated for each kind of term; private to src/system.
#pragma once

#include <Eigen/Geometry>

#include "voile/system/model.hpp"

namespace voile::system {

inline std::vector<Model::Share> Model::shares(Index point) const {
  const auto own_map = [&](Index vertex, const Mat3& map) -> Share {
    const Index axes = rotated_index_[vertex];
    return {vertex, axes == no_index ? map : Mat3(map * rotated_[axes].second)};
  };
  if (point < local_vertices_) return {own_map(point, Mat3::Identity())};
  const LocalMirror& g = mirrors_[point - local_vertices_];
  const Mat3 rest = Mat3::Identity() - g.reflection;
  return {own_map(g.apex, g.reflection), own_map(g.a, (1.0 - g.foot) * rest), own_map(g.b, g.foot * rest)};
}

inline void Model::add_special(Index a, Index b, const Mat3& block, const BlockMatrix& matrix,
                               const BlockMatrix::Values& values) const {
  const auto plain = [&](Index p) { return p < local_vertices_ && rotated_index_[p] == no_index; };
  if (plain(a) && plain(b)) {
    if (a < owned_) values.add(matrix.slot(a, row_of_local_[b]), block);
    return;
  }
  const std::vector<Share> columns = shares(b);
  for (const Share& row : shares(a)) {
    if (row.vertex >= owned_) continue;
    for (const Share& column : columns)
      values.add(matrix.slot(row.vertex, row_of_local_[column.vertex]), row.map.transpose() * block * column.map);
  }
}

template <class Term>
void Model::locate(Assembled<Term>& part) {
  const Term& term = part.term;
  part.slots.clear();
  part.first_slot.clear();
  part.special.clear();
  for (Index e = 0; e < term.size(); ++e) {
    const Index* stencil = term.stencil(e);
    const bool special = std::any_of(stencil, stencil + term.stencil_size(e),
                                     [&](Index p) { return p >= local_vertices_ || rotated_index_[p] != no_index; });
    part.special.push_back(special);
    part.first_slot.push_back(part.slots.size());
    if (special) continue;
    term.blocks(e, [&](int a, int b) {
      const Index row = stencil[a];
      part.slots.push_back(row < owned_ ? tangent_.slot(row, row_of_local_[stencil[b]]) : Slot{});
    });
  }
}

template <class Term>
void Model::add_forces(const Assembled<Term>& part, const energy::Configuration& c) {
  const Term& term = part.term;
  for (Index e = 0; e < term.size(); ++e) {
    const Index* stencil = term.stencil(e);
    term.gradient(e, c, [&](int a, const Vec3& f) { force_[stencil[a]] += f; });
  }
}

template <class Term>
double Model::owned_energy(const Assembled<Term>& part, const energy::Configuration& c) const {
  double sum = 0.0;
  for (Index e = 0; e < part.term.size(); ++e)
    if (part.term.owned(e)) sum += part.term.energy(e, c);
  return sum;
}

template <class Term>
void Model::add_blocks(const Assembled<Term>& part, const energy::Configuration& c,
                       const BlockMatrix::Values& values) const {
  const Term& term = part.term;
  for (Index e = 0; e < term.size(); ++e) {
    if (part.special[e]) {
      const Index* stencil = term.stencil(e);
      term.hessian(e, c,
                   [&](int a, int b, const Mat3& k) { add_special(stencil[a], stencil[b], k, tangent_, values); });
    } else {
      const Slot* slot = part.slots.data() + part.first_slot[e];
      term.hessian(e, c, [&](int, int, const Mat3& k) { values.add(*slot++, k); });
    }
  }
}

}  // namespace voile::system
