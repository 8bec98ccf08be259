// Membrane energy of the six-node patch, St Venant-Kirchhoff on Green strain.
//
// Symbols   G_s      convected base vectors (a_1, a_2) at the middle of side s in the material axes of T:
//                    a_alpha = sum_k d_{s,alpha,k} x_k over the triangle and the apex across s, equal to the
//                    area-weighted average of the two constant-strain gradients of the triangles that share s, each on
//                    its own rest shape
//           E_s      1/2 (a_a.a_b - A_a.A_b), Voigt (E11, E22, 2 E12);  E_c the same from the triangle alone
//           C        membrane stiffness per unit width [N/m];  A rest area;  s_c the constant-strain fraction
// cst                   W = A/2 E_c.C E_c
// six_node              W = A/2 [ (1-s_c) Em.C Em + s_c E_c.C E_c ],  Em = mean_s E_s
// six_node_corrected    the same with Em and E_c without the spurious strain of chords, and a term of fourth order in the curvature
//                       (chord_correction.hpp)
// Viscosity (Kelvin-Voigt in rest axes, over a time step dt from a state with strains E_n): every W(E) above becomes
//   W(E) + c W(E - E_n),  c = tau/dt, tau the relaxation time [s]: stress C (E + tau dE/dt), the rate by the backward
// difference of the step, which keeps a potential.
// Yarns whose tension stiffens, and which stiffen and rub in shear, add w to every W(E): yarn_law.hpp. Rubber has A w(E) instead of W(E),
// while C, its tangent at zero strain, remains for viscosity: hyperelastic.hpp.
// Source: mid-side gradients after Onate & Flores, Comput. Methods Appl. Mech. Engng 194 (2005) 2406-2443 (EBST);
// six-node membrane of the rotation-free triangle: Sze & Zhou, Int. J. Comput. Methods 13 (2016) 1650021. A side on a
// free boundary or on a crease uses the triangle's own gradient. Theory: docs/theory/membrane.md (2).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "batches.hpp"
#include "chord_correction.hpp"
#include "hyperelastic_laws.hpp"
#include "natural_state.hpp"
#include "sheet.hpp"
#include "term.hpp"
#include "yarn_laws.hpp"

namespace voile::energy {

/// The elements are evaluated in batches by the kernels of this machine's instruction set; single ones, for fields and tests, by the
/// scalar variant of the same source.
class MembraneTerm {
 public:
  static constexpr int nodes = 6;

  MembraneTerm() = default;
  explicit MembraneTerm(const Sheet& sheet);

  /// Points of the stencil of triangle t in mesh numbering; a missing apex is replaced by the first vertex (its weights
  /// are zero).
  [[nodiscard]] static std::array<Index, nodes> stencil_of(const Sheet& sheet, Index t);
  /// A strain of triangle t as a function of the points of its stencil: E_r = 1/2 sum_ij Q^r_ij x_i.x_j - rest, the mean
  /// one with a fraction `own` of that of the triangle alone.
  [[nodiscard]] static std::array<Eigen::Matrix<double, nodes, nodes>, 3> forms(const Sheet& sheet, Index t,
                                                                                double own);
  /// Room for so many elements.
  void reserve(std::size_t count) { batches_.reserve(count, corrects() ? 2 * nodes : nodes); }
  /// Adds the element of triangle t, with its stencil in local numbering. `owned`: counted on this rank.
  void add(const Sheet& sheet, Index t, const std::array<Index, nodes>& local, bool owned);
  /// Whether strains are corrected for chords; then each add() is followed by correct().
  [[nodiscard]] bool corrects() const { return shape_.corrected; }
  /// Completes the element added last, that of triangle t: its bending element, with points in local numbering.
  /// `trace`: see ChordForms::trace.
  void correct(const Sheet& sheet, const Mat3& trace, Index t, const BendingElement& bending,
               const std::vector<Index>& local);
  /// After add() and correct(): a triangle that is gathered in time, from the rest shape that `before`, patches of the same mesh, have to that of the sheet.
  void add_gather(const Sheet& sheet, const mesh::PatchMesh& before, Index t);
  /// Rest lengths of gathers go this fraction of the way.
  void gather(double fraction);
  /// After add() and correct(): the element added last may get a natural state that is not its rest shape.
  void add_natural();
  /// Gives it to element e, for which add_natural() was called.
  void set_natural(Index e, const NaturalState& state);
  /// Triangles of this rank that have too many points to be corrected.
  [[nodiscard]] long left_out() const { return left_out_; }

  [[nodiscard]] Index size() const { return batches_.size(); }
  [[nodiscard]] const Index* stencil(Index e) const { return batches_.stencil(e); }
  [[nodiscard]] int stencil_size(Index e) const { return batches_.stencil_size(e); }
  [[nodiscard]] bool owned(Index e) const { return batches_.owned(e); }
  /// Whether the energy depends on the point at position i: not where an apex is missing.
  [[nodiscard]] bool depends_on(Index e, int i) const;
  /// places_of(points, count, depends_on) gives the places of the blocks of pairs i <= j; `none` takes what goes nowhere.
  template <class PlacesOf>
  void locate(PlacesOf&& places_of, Index none) {
    for (Index e = 0; e < size(); ++e)
      batches_.set_slots(e, places_of(stencil(e), stencil_size(e), [&](int i) { return depends_on(e, i); }), none);
  }

  /// Starts a time step: viscosity acts against strains other than those of `c`. ratio = tau/dt for all materials, to
  /// which each adds its own relaxation time over dt; inverse_step = 1/dt, 0: they do not.
  void start_step(const Configuration& c, double ratio, double inverse_step = 0.0);
  /// c of each material; empty: no viscosity.
  [[nodiscard]] const std::vector<double>& viscosity() const { return viscosity_; }
  void set_viscosity(std::vector<double> ratios);

  /// Friction of yarns that are sheared (yarn_law.hpp); its steps end as those of YarnFrictionTerm do.
  [[nodiscard]] bool rubs() const { return yarns_.rub(); }
  /// What it takes at c, of the owned elements [J].
  [[nodiscard]] double lost(const Configuration& c) const;
  void end_step(const Configuration& c);
  [[nodiscard]] double slip(Index e) const { return yarns_.slip(batches_.place(e)); }
  void set_slip(Index e, double slip);

  /// All elements: forces added to those of the local points [N], energy of the owned ones [J], blocks added at the slots [N/m].
  double add_gradients(const Configuration& c, Vec3* force) const;
  void add_tangents(const Configuration& c, double* blocks) const;
  /// Another one after everything that changes energies of the same configuration.
  [[nodiscard]] long version() const { return version_; }
  /// The kernels of another instruction set.
  void use(const ElementKernels& kernels) { kernels_ = &kernels; }

  // Single elements
  [[nodiscard]] double energy(Index e, const Configuration& c) const;
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    double energy = 0.0;
    const std::vector<double> g = gradient_of(e, c, energy);
    for (int i = 0; i < stencil_size(e); ++i) emit(i, Vec3(Eigen::Map<const Vec3>(g.data() + 3 * i)));
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const std::vector<double> k = hessian_of(e, c);
    for (int i = 0; i < stencil_size(e); ++i)
      for (int j = i; j < stencil_size(e); ++j) {
        const double* at = k.data() + 9 * pair_place(i, j, batches_.batch_of(e).size);
        const Mat3 block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(at);
        emit(i, j, block);
        if (j != i) emit(j, i, Mat3(block.transpose()));
      }
  }

  /// Strain that the stress resultants are taken from: (E11, E22, 2 E12), the mean for six_node.
  [[nodiscard]] Vec3 strain(Index e, const Configuration& c) const;
  /// The same of all elements.
  [[nodiscard]] std::vector<Vec3> strains(const Configuration& c) const;
  /// What is taken off strain() of element e: half the metric of its natural state.
  [[nodiscard]] Vec3 natural_metric(Index e) const;
  /// Membrane force N = dW/dE / A in material axes [N/m] at a strain: that of the energy, shares included, without friction.
  [[nodiscard]] Vec3 force(Index e, const Vec3& strain) const {
    const auto m = static_cast<std::size_t>(material_[static_cast<std::size_t>(e)]);
    if (rubbers_[m].any()) return response(rubbers_[m], strain).force;
    return stiffness_[m] * strain + (laws_[m].any() ? added_force(laws_[m], strain) : Vec3(Vec3::Zero()));
  }

 private:
  using SideWeights = std::array<std::array<double, 4>, 2>;
  struct Element {
    double area;
    std::array<SideWeights, 3> side;           ///< d_{s,alpha,k}; k = 3 is the apex across s
    std::array<std::array<double, 3>, 2> own;  ///< constant-strain gradient
    std::array<Vec3, 4> metric;                ///< rest metric (A1.A1, A2.A2, 2 A1.A2)/2 of each side, and its own
  };
  using Metrics = std::array<Vec3, 3>;  ///< of the groups of samples
  /// An element whose rest shape changes in time.
  struct Gathered {
    Index element;
    std::array<std::array<Vec3, 2>, 4> before, drawn_in;  ///< base vectors of the sides and its own, in one chart
    Metrics correction;                                   ///< what is taken off besides
  };

  /// An element with a natural state, and what that is taken of.
  struct Natural {
    Index element;
    NaturalState state;
    Metrics rest, whole;  ///< what is taken off at rest; the part of it that stays, as `whole_strain` of the correction
    Mat3 in_plane, trace;  ///< and the rest as in ChordCorrection
    Vec3 rest_bend;
    std::array<double, 2> start_squares;
    bool fourth;
  };

  [[nodiscard]] static Element element_of(const Sheet& sheet, Index t);
  /// Changes what is taken off; viscosity acts against strains, not against a rest shape that changes in the step.
  void shift_metrics(Index e, const Metrics& metrics);
  [[nodiscard]] Natural* natural_of(Index e);
  [[nodiscard]] Metrics natural_metrics(const Natural& n) const;
  void set_shape(MembraneOperator kind, double cst_fraction);
  [[nodiscard]] Metrics metrics_of(const std::array<Vec3, 4>& samples) const;
  void set_metrics(Index e, const Metrics& metrics);
  [[nodiscard]] Metrics taken_off(Index e) const;
  void place(std::vector<double> numbers, const std::vector<Index>& stencil, bool fourth);
  [[nodiscard]] MembraneBatch view(const Batches::Batch& b) const;
  /// Only the lane of element e, its numbers by stencil positions.
  [[nodiscard]] MembraneBatch view(Index e) const;
  [[nodiscard]] Vec3 strain_in(const std::array<Line, 9>& groups, int lane) const;
  /// `energy`: that of the element.
  [[nodiscard]] std::vector<double> gradient_of(Index e, const Configuration& c, double& energy) const;
  [[nodiscard]] std::vector<double> hessian_of(Index e, const Configuration& c) const;
  /// Strains of the group that rubs, of all elements.
  [[nodiscard]] std::vector<Vec3> rubbing_strains(const Configuration& c) const;
  /// Calls f(batch, number of the batch).
  template <class F>
  void for_batches(F&& f) const {
    for (std::size_t b = 0; b < batches_.all().size(); ++b) f(view(batches_.all()[b]), b);
  }

  long version_ = 0;
  MembraneShape shape_;
  const ElementKernels* kernels_ = &batch_kernels();
  Batches batches_;
  std::vector<int> material_;  ///< of each element
  std::vector<Mat3> stiffness_;
  std::vector<YarnLaw> laws_;  ///< of each material
  YarnLaws yarns_;
  std::vector<Hyperelastic> rubbers_;  ///< of each material
  HyperelasticLaws rubber_;
  std::vector<Gathered> gathered_;
  std::vector<Natural> natural_;  ///< by ascending element
  long left_out_ = 0;
  // The element added last
  Element last_{};
  bool last_owned_ = false;
  Mat3 last_stiffness_ = Mat3::Zero();
  std::array<Index, nodes> last_points_{};
  Metrics last_correction_{};
  ChordCorrection last_chords_{};

  std::vector<double> viscous_time_, viscosity_;  ///< tau and c of each material; c is empty where all are 0
  std::vector<Line> start_, ratio_;               ///< of each batch: E_n, nine numbers, and c
};

}  // namespace voile::energy
