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
// 89 (2012) 509-536, eq. (3) of the abstract; the curved form is rotation invariant and free of stress at rest.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "voile/energy/curvature.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/term.hpp"

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
class CurvedBendingTerm {
 public:
  /// `local`: the element's points in local numbering, in its order.
  void add(const BendingElement& element, const std::vector<Index>& local, bool owned);

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return points_.data() + elements_[e].start; }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].count; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const;
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const Element& el = elements_[e];
    const Normal n = normal(el, c);
    const Vec3 v = coupled(el, c);
    const Vec3 change = el.normal - n.unit;
    const Vec3 q = -(v - n.unit.dot(v) * n.unit) / n.length;
    const Vec3 g1 = n.b.cross(q), g2 = q.cross(n.a);
    emit(0, coupling_[el.start] * change - g1 - g2);
    emit(1, coupling_[el.start + 1] * change + g1);
    emit(2, coupling_[el.start + 2] * change + g2);
    for (int i = 3; i < el.count; ++i) emit(i, coupling_[el.start + i] * change);
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const Element& el = elements_[e];
    std::array<std::array<Mat3, 3>, 3> centre;
    std::array<Mat3, 3> mixed;
    blocks_of(el, c, centre, mixed);
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) emit(j, i, centre[j][i]);
    for (int i = 3; i < el.count; ++i)
      for (int j = 0; j < 3; ++j) {
        const Mat3 k = coupling_[el.start + i] * mixed[j];
        emit(j, i, k);
        emit(i, j, k.transpose());
      }
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) emit(j, i);
    for (int i = 3; i < elements_[e].count; ++i)
      for (int j = 0; j < 3; ++j) {
        emit(j, i);
        emit(i, j);
      }
  }

 private:
  struct Element {
    std::size_t start;
    int count;
    bool owned;
    double rest_energy;
    Vec3 normal, start_coupling;  ///< N_s, w
  };
  struct Normal {
    Vec3 a, b, unit;
    double length;
  };
  [[nodiscard]] Normal normal(const Element& el, const Configuration& c) const;
  /// v = e0 N_s + w + sum_i c_i u_i, equal to A kappa0.D k'(x).
  [[nodiscard]] Vec3 coupled(const Element& el, const Configuration& c) const;
  void blocks_of(const Element& el, const Configuration& c, std::array<std::array<Mat3, 3>, 3>& centre,
                 std::array<Mat3, 3>& mixed) const;

  std::vector<Element> elements_;
  std::vector<Index> points_;
  std::vector<double> coupling_;
};

}  // namespace voile::energy
