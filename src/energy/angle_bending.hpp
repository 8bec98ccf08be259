// Bending by the angles at the edges around a triangle (element.type = "angles"; beside folds with the default): what happens in
// the plane of the sheet bends nothing.
//
// Symbols   B        curvature operator of edge_slope (curvature.hpp), zero on affine maps of the unfolded patch
//           h_e      x_q less the affine map of triangle (a, b, p) at the place of q, of an inner edge e = (a, b) of the patch between p and q
//           H_e      height of q over e in the unfolded patch [m];  theta_e the angle at e (edge_angle.hpp)
//           D, A     bending stiffness [N m], rest area [m^2];  B', r as in bending.hpp
// Since the h_e vanish on affine maps and are as many as it takes, B = sum_e c_e h_e. Then
//   kappa = sum_e c_e H_e theta_e,   E = A/2 (kappa - kappa0).D (kappa - kappa0),   kappa0 the same at rest.
// Where the sheet is nearly flat h_e = H_e theta_e n, so that kappa = n.B x to first order: patch test and convergence are those of edge_slope.
// An arc of n equal steps turns by theta = s/R at each whatever its chords, so that kappa = 1/R: no cosine is lost in the sum of vectors of
// different directions, and no term of fourth order (chord_correction.hpp) is needed. E does not depend on strains that leave angles alone.
// The constant part of edge_slope stays in K_b, where damping and the start take it from; the term adds
//   E - A/2 (r + B'u).D (r + B'u). Theory: docs/theory/curvature.md (3).
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "batches.hpp"
#include "bending.hpp"
#include "edge_angle.hpp"

namespace voile::energy {

/// kappa of one triangle, in mesh point numbering.
struct EdgeAngles {
  struct Edge {
    std::array<Index, 4> points;  ///< a, b, p, q
    Vec3 weight;                  ///< c_e H_e [1/m]
  };
  std::vector<Edge> edges;
  Vec3 rest = Vec3::Zero();  ///< kappa0
};

/// Between points of `bending`, the element of triangle t, whose operator without its correction for curved rest shapes is `op`. Nothing where its
/// edges do not make up B: fits over rings of a doubly curved rest shape, whose unfolding depends on the way around a vertex, and beside seams whose sides
/// differ in length, where slopes of two scales are averaged.
[[nodiscard]] std::optional<EdgeAngles> make_edge_angles(const Sheet& sheet, Index t, const CurvatureOperator& op,
                                                         const BendingElement& bending);

/// Whether triangle t bends by angles: all do with `edge_angle`, and with the corrected membrane those whose operator reaches
/// across an edge that is folded at rest by more than the crease angle, where slopes take motion in the plane of one side for
/// bending of the other; none where a fold at rest exceeds 150 degrees. Not collective.
[[nodiscard]] bool bends_by_angles(const Sheet& sheet, Index t);

/// Angles are found once per edge, and so are their derivatives; triangles add up what their edges have and hand back the pull at each,
/// the derivative of the energy by its angle.
class AngleBendingTerm {
 public:
  static constexpr int most = 64;

  /// `local`: the points of `bending` in local numbering, at most `most`. `stiffness`: A D.
  void add(const BendingElement& bending, const EdgeAngles& angles, const std::vector<Index>& local,
           const Mat3& stiffness, bool owned);
  /// After the last add().
  void end_adding();

  [[nodiscard]] Index size() const { return batches_.size(); }
  [[nodiscard]] const Index* stencil(Index e) const { return batches_.stencil(e); }
  [[nodiscard]] int stencil_size(Index e) const { return batches_.stencil_size(e); }
  [[nodiscard]] Index edge_count() const { return static_cast<Index>(edges_.size()); }

  /// kappa - kappa0 [1/m].
  [[nodiscard]] Vec3 curvature(Index e, const Configuration& c) const;
  /// kappa0.
  [[nodiscard]] Vec3 rest_curvature(Index e) const;
  /// Puts another one in its place: a natural curvature (natural_state.hpp).
  void set_rest_curvature(Index e, const Vec3& curvature);

  /// places_of(points, count, depends_on) gives the places of the blocks of pairs i <= j; `none` takes what goes nowhere.
  template <class PlacesOf>
  void locate(PlacesOf&& places_of, Index none) {
    const auto always = [](int) { return true; };
    for (Index e = 0; e < size(); ++e) batches_.set_slots(e, places_of(stencil(e), stencil_size(e), always), none);
    edge_slots_.assign(pairs_per_edge * edge_batches(), {});
    for (PerLane<int>& slots : edge_slots_) slots.fill(numbers_per_block * none);
    for (std::size_t k = 0; k < edges_.size(); ++k) {
      const std::vector<Index> places = places_of(edges_[k].data(), 4, always);
      for (std::size_t i = 0; i < pairs_per_edge; ++i)
        edge_slots_[pairs_per_edge * (k / batch_lanes) + i][k % batch_lanes] = numbers_per_block * places[i];
    }
  }

  /// All elements: forces added to those of the local points [N], energy of the owned ones [J], blocks added at the slots [N/m].
  double add_gradients(const Configuration& c, Vec3* force) const;
  void add_tangents(const Configuration& c, double* blocks) const;
  /// See MembraneTerm.
  [[nodiscard]] long version() const { return version_; }
  /// The kernels of another instruction set.
  void use(const ElementKernels& kernels) { kernels_ = &kernels; }

 private:
  static constexpr std::size_t pairs_per_edge = 10;
  using Ends = std::array<Index, 4>;  ///< a < b, p, q: local points

  [[nodiscard]] std::size_t edge_batches() const { return (edges_.size() + batch_lanes - 1) / batch_lanes; }
  void add_hinge(const EdgeAngles::Edge& edge, const BendingElement& bending, const std::vector<Index>& local,
                 const Mat3& factor);
  [[nodiscard]] Vec3 unscaled(Index e, const Vec3& kappa) const;
  [[nodiscard]] EdgeBatch edge_view(std::size_t batch) const;
  [[nodiscard]] AngleBatch view(std::size_t batch) const;

  long version_ = 0;
  const ElementKernels* kernels_ = &batch_kernels();
  Batches batches_{angle_fields::weights, 3};
  std::vector<PerLane<int>> first_hinge_, last_hinge_;  ///< of each batch
  std::vector<HingeAt> hinges_;
  std::vector<Line> hinge_weights_;            ///< of two hinges each, L^T c_e H_e and a zero
  std::vector<std::array<double, 6>> factor_;  ///< L of each element
  std::vector<Ends> edges_;
  std::map<Ends, Index> number_of_;  ///< of each edge, while elements are added
  std::vector<PerLane<int>> edge_points_, edge_slots_;
  mutable std::vector<Line> angle_, slopes_, pull_;  ///< of the edges, from one evaluation to its end
};

}  // namespace voile::energy
