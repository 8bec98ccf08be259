// Vertices of a periodic sheet that follow others: those of curves `to`, and the images beyond the mesh.
//
// Symbols   r, n   root of a vertex and periods from there (mesh/periodic.hpp)
//           d_i    displacement of curve `to` of pair i less that of its curve `from`                            [m]
//   u_w = u_r + sum n_i d_i
// d_i are the unknowns of a vertex of curve `to`, the carrier of the pair; the other vertices of `to` have none of their own.
#pragma once

#include <memory>
#include <vector>

#include "base/petsc.hpp"
#include "conditions.hpp"
#include "mesh/patch.hpp"
#include "mesh/periodic.hpp"

namespace voile::system {

struct Constraints;

struct Ties {
  std::shared_ptr<const mesh::ContinuedSurface> sheet{};  ///< null: the sheet is not periodic
  const mesh::SurfaceMesh* mesh = nullptr;                ///< that is continued
  std::vector<Index> carriers{};                          ///< of each pair

  [[nodiscard]] bool any() const { return sheet != nullptr; }
  /// Of a vertex of the continued surface. Requires any().
  [[nodiscard]] Index root(Index v) const { return sheet->root[v]; }
  [[nodiscard]] int periods(Index v, std::size_t pair) const { return sheet->shift[v][pair]; }
  [[nodiscard]] bool is_tied(Index v) const { return sheet->shift[v] != mesh::ContinuedSurface::Shift{}; }
  /// Vertices whose unknowns those of the continued surface depend on, ascending. Requires any().
  [[nodiscard]] std::vector<Index> unknowns_of(const std::vector<Index>& vertices) const;
  /// Marks every vertex of the mesh that repeats, or is repeated by, one that is marked; none without a periodic sheet.
  void spread(std::vector<char>& marked) const;
};

/// Continues the sheet and adds what it fixes to `constraints`, which are those of `supports`; what moves the pairs has the numbers
/// after these. Not collective. Throws UserError for curves that are no pair, and what supports contradict.
void resolve_periodic(const mesh::SurfaceMesh& mesh, const std::vector<PeriodicPair>& pairs,
                      const std::vector<Support>& supports, Constraints& constraints);

/// The mirrored sides of the continued surface: those of the mesh, then their images. `turned_by`: likewise, is extended.
[[nodiscard]] std::vector<mesh::MirrorSide> continued_mirrors(const mesh::ContinuedSurface& sheet,
                                                              const std::vector<mesh::MirrorSide>& mirrors,
                                                              std::vector<int>& turned_by);

/// The supports, then one that moves each difference.
[[nodiscard]] std::vector<Support> with_differences(std::vector<Support> supports,
                                                    const std::vector<PeriodicPair>& periodic);

class Discretisation;

/// Of each pair in state a with the unbalanced force f: the difference [m] and the force that holds it [N]; six numbers each on
/// rank 0. Collective.
[[nodiscard]] std::vector<double> periodic_values(const Discretisation& on, Vec a, Vec f);

}  // namespace voile::system
