// Membrane energy of the six-node patch, St Venant-Kirchhoff on Green strain.
//
// Symbols   G_s      convected base vectors (a_1, a_2) at the middle of side s in the material axes of T:
//                    a_alpha = sum_k d_{s,alpha,k} x_k over the triangle and the apex across s, equal to the
//                    area-weighted average of the two constant-strain gradients of the triangles that share s, each on
//                    its own rest shape
//           E_s      1/2 (a_a.a_b - A_a.A_b), Voigt (E11, E22, 2 E12);  E_c the same from the triangle alone
//           C        membrane stiffness per unit width [N/m];  A rest area;  s_c the constant-strain share
// cst                   W = A/2 E_c.C E_c
// six_node              W = A/2 [ (1-s_c) Em.C Em + s_c E_c.C E_c ],  Em = mean_s E_s
// six_node_corrected    the same with Em and E_c corrected for what chords feign, and a term of fourth order in the curvature
//                       (chord_correction.hpp)
// six_node_three_point  W = A/2 mean_s E_s.C E_s
// Viscosity (Kelvin-Voigt in rest axes, over a time step dt from a state with strains E_n): every W(E) above becomes
//   W(E) + c W(E - E_n),  c = tau/dt, tau the relaxation time [s]: stress C (E + tau dE/dt), the rate by the backward
// difference of the step, which keeps a potential.
// Source: mid-side gradients after Onate & Flores, Comput. Methods Appl. Mech. Engng 194 (2005) 2406-2443 (EBST);
// six-node membrane of the rotation-free triangle: Sze & Zhou, Int. J. Comput. Methods 13 (2016) 1650021. A side on a
// free boundary or on a crease uses the triangle's own gradient.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "voile/energy/chord_correction.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/term.hpp"

namespace voile::energy {

/// Three vectors in space as columns, with a fourth number, zero, so that they fill registers.
using Quads = Eigen::Matrix<double, 4, 3>;

class MembraneTerm {
 public:
  static constexpr int nodes = 6;

  MembraneTerm() = default;
  /// `shares`: 1 for elements counted on this rank. Stencils are local point numbers.
  MembraneTerm(const Sheet& sheet);

  /// Points of the stencil of triangle t in mesh numbering; a missing apex is replaced by the first vertex (its weights
  /// are zero).
  [[nodiscard]] static std::array<Index, nodes> stencil_of(const Sheet& sheet, Index t);
  /// A strain of triangle t as a function of the points of its stencil: E_r = 1/2 sum_ij Q^r_ij x_i.x_j - rest, the mean
  /// one with a share `own` of that of the triangle alone.
  [[nodiscard]] static std::array<Eigen::Matrix<double, nodes, nodes>, 3> forms(const Sheet& sheet, Index t,
                                                                                double own);
  /// Room for so many elements.
  void reserve(std::size_t count) { elements_.reserve(count); }
  /// Adds the element of triangle t, with its stencil in local numbering.
  void add(const Sheet& sheet, Index t, const std::array<Index, nodes>& local, bool owned);
  /// After add(): a triangle that is gathered in time, from the rest shape that `before`, patches of the same mesh, have to that of the sheet.
  void add_gather(const Sheet& sheet, const mesh::PatchMesh& before, Index t);
  /// Rest lengths of gathers go this share of the way.
  void gather(double share);
  /// Whether strains are corrected for chords; then each add() is followed by correct().
  [[nodiscard]] bool corrects() const { return kind_ == MembraneOperator::six_node_corrected; }
  /// The correction of the element added last, that of triangle t: its bending element, with points in local numbering.
  /// `trace`: see ChordForms::trace.
  void correct(const Sheet& sheet, const Mat3& trace, Index t, const BendingElement& bending,
               const std::vector<Index>& local);

  /// Whether the element has too many points to be corrected.
  [[nodiscard]] bool left_out(Index e) const { return corrects() && correction_.left_out(e); }

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const {
    return corrects() ? correction_.stencil(e) : elements_[e].points.data();
  }
  [[nodiscard]] int stencil_size(Index e) const { return corrects() ? correction_.stencil_size(e) : nodes; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  /// Starts a time step: viscosity acts against strains other than those of `c`. ratio = tau/dt for all materials, to
  /// which each adds its own relaxation time over dt; inverse_step = 1/dt, 0: they do not.
  void start_step(const Configuration& c, double ratio, double inverse_step = 0.0);
  /// c of each material; empty: no viscosity.
  [[nodiscard]] const std::vector<double>& viscosity() const { return viscosity_; }
  void set_viscosity(std::vector<double> ratios) { viscosity_ = std::move(ratios); }

  [[nodiscard]] double energy(Index e, const Configuration& c) const;
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    std::array<Vec3, nodes> g;
    Bends bent;
    gradient_of(e, c, g, bent);
    if (!corrects()) {
      for (int i = 0; i < nodes; ++i) emit(i, g[i]);
      return;
    }
    for (int i = 0; i < correction_.stencil_size(e); ++i) {
      const Vec3 more = bent * correction_.weight(e, i);
      emit(i, i < nodes ? Vec3(g[i] + more) : more);
    }
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    Workspace w;
    prepare(e, c, w);
    if (corrects()) return corrected_blocks(e, w, emit);
    for (int i = 0; i < nodes; ++i)
      for (int j = i; j < nodes; ++j) {
        emit(i, j, w.k[i][j].template topRows<3>());
        if (j != i) emit(j, i, w.k[i][j].template topRows<3>().transpose());
      }
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    const int count = stencil_size(e);
    for (int i = 0; i < count; ++i)
      for (int j = i; j < count; ++j) {
        emit(i, j);
        if (j != i) emit(j, i);
      }
  }

  /// Strain that the stress resultants are taken from: (E11, E22, 2 E12), the mean for six_node.
  [[nodiscard]] Vec3 strain(Index e, const Configuration& c) const;
  /// Membrane force N = dW/dE / A in material axes [N/m]: that of the energy, shares included.
  [[nodiscard]] Vec3 force(Index e, const Configuration& c) const;

 private:
  using SideWeights = std::array<std::array<double, 4>, 2>;
  struct Element {
    std::array<Index, nodes> points;
    double area;
    int material;
    bool owned;
    std::array<SideWeights, 3> side;           ///< d_{s,alpha,k}; k = 3 is the apex across s
    std::array<std::array<double, 3>, 2> own;  ///< constant-strain gradient
    std::array<Vec3, 3> side_metric;           ///< rest metric (A1.A1, A2.A2, 2 A1.A2)/2 of each side
    Vec3 own_metric;
  };
  /// Upper blocks of one element's Hessian; of a corrected one without the part of b, the derivatives of its strains.
  struct Workspace {
    std::array<std::array<Quads, nodes>, nodes> k;
    /// Of each point eight vectors b (columns, in quads), and what multiplies them: for
    /// each strain, mean and own, the rows of dE/dx and of A C dE/dx; for the term of fourth order two more.
    std::array<Eigen::Matrix<double, 4, 8>, ChordCorrection::most> b;
    std::array<Eigen::Matrix<double, 8, 3>, ChordCorrection::most> stiff;
    ChordCorrection::ChordBends bends;
    ChordCorrection::Form geometric;  ///< derivatives by K_A and K_B that are the same for x, y and z
  };
  template <class Emit>
  void corrected_blocks(Index e, const Workspace& w, Emit&& emit) const {
    const int count = correction_.stencil_size(e);
    for (int i = 0; i < count; ++i) {
      const BendWeights along = w.geometric * correction_.weight(e, i);
      for (int j = i; j < count; ++j) {
        Eigen::Matrix<double, 4, 3> product;
        product.noalias() = w.b[i].lazyProduct(w.stiff[j]);
        Mat3 k = product.topRows<3>();
        k.diagonal().array() += along.dot(correction_.weight(e, j));
        if (j < nodes) k += w.k[i][j].template topRows<3>();
        emit(i, j, k);
        if (j != i) emit(j, i, k.transpose());
      }
    }
  }

  /// Without stencil and owner.
  [[nodiscard]] static Element element_of(const Sheet& sheet, Index t);
  /// `bent`: derivative by k_A in column A, of a corrected element.
  void gradient_of(Index e, const Configuration& c, std::array<Vec3, nodes>& g, Bends& bent) const;
  void prepare(Index e, const Configuration& c, Workspace& w) const;
  /// Of `six_node` and `six_node_corrected`.
  struct Stress;
  /// Of a corrected element: bends; starts b, stiff and geometric.
  void prepare_bends(Index e, const Configuration& c, Workspace& w) const;
  void prepare_mean(Index e, const Configuration& c, const Stress& stress, Workspace& w) const;
  void prepare_own(Index e, const Configuration& c, const Stress& stress, Workspace& w) const;
  /// The strain with its correction. Fills the vectors b of the strain, to whose first points `own` belongs, and what multiplies
  /// them; `material`: A C.
  template <std::size_t n>
  [[nodiscard]] Vec3 corrected(Index e, ChordCorrection::Strain which, const Vec3& strain,
                               const std::array<Quads, n>& own, const Mat3& material, Workspace& w) const;
  [[nodiscard]] bool takes_mean() const {
    return kind_ == MembraneOperator::six_node || kind_ == MembraneOperator::six_node_corrected;
  }
  /// Strains of the samples that W is made of: the sides' or their mean, and the triangle's own.
  struct Samples {
    std::array<Vec3, 3> side;
    Vec3 own;
  };
  [[nodiscard]] Samples samples(Index e, const Configuration& c) const;
  void move_start(Index e, const Samples& metric);
  /// (1 + c) E - c E_n: the strain whose elastic stress is the whole stress.
  [[nodiscard]] double viscosity_of(const Element& el) const {
    return viscosity_.empty() ? 0.0 : viscosity_[static_cast<std::size_t>(el.material)];
  }
  [[nodiscard]] static Vec3 effective(const Vec3& strain, const Vec3& before, double viscosity) {
    return viscosity > 0.0 ? Vec3((1.0 + viscosity) * strain - viscosity * before) : strain;
  }

  /// An element whose rest shape changes in time.
  struct Gathered {
    Index element;
    std::array<std::array<Vec3, 2>, 4> before, drawn_in;  ///< base vectors of the sides and its own, in one chart
  };

  std::vector<Element> elements_;
  std::vector<Gathered> gathered_;
  ChordCorrection correction_;
  std::vector<Mat3> stiffness_;
  MembraneOperator kind_ = MembraneOperator::six_node;
  double cst_share_ = 0.0;
  std::vector<double> viscous_time_, viscosity_;  ///< tau and c of each material; c is empty where all are 0
  std::vector<Samples> start_;                    ///< E_n of each element; side[0] holds the mean for six_node
};

}  // namespace voile::energy
