// Bending energy: a constant quadratic form, plus a normal-dependent term where the rest shape is curved.
//
// Symbols   B        constant curvature operator (see curvature.hpp), k(x) = B x, three vectors
//           X        rest shape in the chart of the triangle, N its unit normal there, e_a its axes
//           x_s, N_s place and unit normal at the start;  n current unit normal;  G_a x convected base vectors
//           kappa0   N.k(X), rest curvature;  tau^a = e_a.k(X), spurious in-plane part
//           r        = k'(x_s) - kappa0 N_s, by how much the start is bent beyond the rest shape; 0 if it is that
//           D, A     bending stiffness [N m], rest area [m^2]
//   k'(x) = k(x) - tau^a G_a x                                   (at rest k' = kappa0 N exactly)
//   E     = A/2 [ k'.D k' - 2 kappa0.D (n.k') + kappa0.D kappa0 ]
// With u = x - x_s and c_i = A kappa0.D B'_i this is
//   E     = 1/2 u.K u + f.u + e_r  +  e0 (1 - n.N_s) + (N_s - n).(w + sum_i c_i u_i)
//   K     = A B'^T D B' (x) I3,  f_i = A B'_i.D r,  e_r = A/2 r.D r,  w = A kappa0.D r,  e0 = A kappa0.D kappa0
// where K, f and e_r are constant, so a flat sheet needs nothing but these, assembled once. Source of the flat form: Zhou & Sze, Int. J. Numer. Meth. Engng
// 89 (2012) 509-536, eq. (3) of the abstract; the curved form is rotation invariant and free of stress at rest. Theory: docs/theory/curved-rest-shapes.md (1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "batches.hpp"
#include "curvature.hpp"
#include "sheet.hpp"
#include "term.hpp"

namespace voile::energy {

/// Bending data of one triangle, in mesh point numbering.
struct BendingElement {
  std::vector<Index> points;                           ///< the triangle's vertices first, then the others
  Eigen::Matrix<double, 3, Eigen::Dynamic> operator_;  ///< B'
  Eigen::MatrixXd stiffness;                           ///< A B'^T D B', scalar per pair of points [N/m]
  Eigen::VectorXd coupling;                            ///< c_i [N/m]; empty for a flat patch
  double rest_energy = 0.0;                            ///< e0 [J]
  Vec3 start_normal = Vec3::UnitZ();                   ///< N_s
  Vec3 rest_curvature = Vec3::Zero();                  ///< kappa0 [1/m]
  Mat3 start_bend = Mat3::Zero();                      ///< r, one row per component of the curvature [1/m]
  Vec3 start_coupling = Vec3::Zero();                  ///< w [J]
  Eigen::MatrixX3d start_force;                        ///< f_i [N]; empty where r = 0
  double start_energy = 0.0;                           ///< e_r [J]
};

[[nodiscard]] BendingElement make_bending_element(const Sheet& sheet, Index t, const CurvatureOperator& op);

/// The normal-dependent part of the energy for curved patches; its points 0, 1, 2 are the triangle's vertices.
///
/// Where the natural curvature is kappa' instead of kappa0 (natural_state.hpp), with k_n = kappa' - kappa0, the energy has besides
///   -n.(w' + sum_i c'_i u_i) + A/2 (kappa'.D kappa' - kappa0.D kappa0),   w' = A k_n.D (r + kappa0 N_s),  c'_i = A k_n.D B'_i
/// which is the same term with N_s = 0 and twice the constant for e0.
class CurvedBendingTerm {
 public:
  /// An element whose natural curvature may change.
  void add_natural(const BendingElement& element, const Mat3& stiffness, const std::vector<Index>& local, bool owned);
  /// Of the element e, added by add_natural(): kappa'. `stiffness` above: A D.
  void set_natural(Index e, const Vec3& curvature);
  /// `local`: the element's points in local numbering, in its order.
  void add(const BendingElement& element, const std::vector<Index>& local, bool owned);

  [[nodiscard]] Index size() const { return batches_.size(); }
  [[nodiscard]] const Index* stencil(Index e) const { return batches_.stencil(e); }
  [[nodiscard]] int stencil_size(Index e) const { return batches_.stencil_size(e); }

  /// places_of(points, count, depends_on) gives the places of the blocks of pairs i <= j; `none` takes what goes nowhere.
  template <class PlacesOf>
  void locate(PlacesOf&& places_of, Index none) {
    for (Index e = 0; e < size(); ++e)
      batches_.set_slots(e, places_of(stencil(e), stencil_size(e), [](int) { return true; }), none);
  }

  /// All elements: forces added to those of the local points [N], energy of the owned ones [J], blocks added at the slots [N/m].
  double add_gradients(const Configuration& c, Vec3* force) const;
  void add_tangents(const Configuration& c, double* blocks) const;
  /// See MembraneTerm.
  [[nodiscard]] long version() const { return version_; }
  /// The kernels of another instruction set.
  void use(const ElementKernels& kernels) { kernels_ = &kernels; }

 private:
  struct Natural {
    Vec3 rest;                                    ///< kappa0
    Mat3 stiffness;                               ///< A D
    Mat3 start;                                   ///< A D (r + kappa0 N_s)
    Eigen::Matrix<double, 3, Eigen::Dynamic> of;  ///< A D B'_i
  };

  [[nodiscard]] CurvedBatch view(const Batches::Batch& b) const;

  long version_ = 0;
  std::vector<Natural> natural_;  ///< of each element, or empty
  const ElementKernels* kernels_ = &batch_kernels();
  Batches batches_{curved_fields::coupling, 1};
};

}  // namespace voile::energy
