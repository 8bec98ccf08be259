// What a sheet stores: bending with its constant stiffness, and the terms of the potential on the points of this rank.
//
// Symbols   a     vector of unknowns (model.hpp)                                                              [m]
//           K_b   constant bending stiffness, assembled once and copied into each tangent                     [N/m]
//                 (with the springs to the ground, which are constant too)
//           f_b   constant force of bending at a = 0 (bending_energy.hpp)                                     [N]
//           E_t   terms (term.hpp): membrane, bending of curved rest shapes beyond K_b, ties, seams, anchors  [J]
//   E(a) = 1/2 a.K_b a + f_b.a + E_0 + sum_t E_t,     internal forces K_b a + f_b + sum_t dE_t/da
// Elements that touch an owned vertex are evaluated by its rank, so that rows are complete without communication;
// energies count each triangle once, on its owner.
// Theory: docs/theory/curvature.md (1), docs/theory/membrane.md.
#pragma once

#include <memory>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "conditions.hpp"
#include "constant_matrices.hpp"
#include "energies.hpp"
#include "energy/term.hpp"
#include "half_blocks.hpp"
#include "recovery.hpp"

namespace voile::energy {
struct BendingElement;
struct CurvatureOperator;
struct EdgeBend;
class AnchorTerm;
class AngleBendingTerm;
class MembraneTerm;
class MirrorFoldTerm;
class CouplingTerm;
class JointTerm;
class SpringTerm;
class YarnFrictionTerm;
}  // namespace voile::energy

namespace voile::system {

class Attachments;
class Bands;
class BendingEnergy;
class BoundaryConditions;
class Contact;
class Discretisation;
class NaturalStates;
class SewingSprings;
class Term;
template <class Kernel>
class BatchTerm;
template <class Kernel>
class ElementTerm;

/// What is stored in besides the sheet itself.
struct PotentialInput {
  std::vector<PointMass> masses;  ///< they store nothing, but are part of what is constant
  std::vector<Spring> springs;
  Sewing sewing;
  std::vector<Attachment> attachments;
  NaturalInput natural;
};

class Potential {
 public:
  /// `conditions` turn clamps and are moved by hard attachments; `contact` has the obstacles, or is null. All references
  /// must outlive it. Collective. Throws UserError on every rank.
  Potential(Discretisation& on, BoundaryConditions& conditions, const Contact* contact, PotentialInput input);
  ~Potential();
  Potential(const Potential&) = delete;
  Potential& operator=(const Potential&) = delete;

  /// Bending stiffness, damping and mass.
  [[nodiscard]] const ConstantMatrices& constant() const { return constant_; }
  /// What is held to obstacles.
  [[nodiscard]] Attachments& attachments() const { return *attachments_; }
  /// Time of all later evaluations, on which bands, seams and attachments depend. Not collective.
  void set_time(double time);
  /// Whether what is stored changes with the time alone: clamps that turn, seams that are pulled, attachments. Not
  /// collective.
  [[nodiscard]] bool depends_on_time() const;
  /// Natural states (natural_states.hpp) are those of load factor 0, or follow it again. Not collective.
  void hold_natural_states(bool hold) { hold_natural_ = hold; }
  /// Whether they change with load factor or time.
  [[nodiscard]] bool natural_states_change() const;
  /// Whether hinges have folds that act in full at every load factor; the fraction of them that acts, which grows before the first
  /// step. Not collective.
  [[nodiscard]] bool has_constant_folds() const;
  void ease_folds(double fraction);
  /// Largest strain by which natural states grow per unit of the load factor, bending counted over a cell. Collective.
  [[nodiscard]] double natural_growth() const;
  /// Size of the nodal forces that hold the rest shape against its natural states; 0 where they are the same. Collective. [N]
  [[nodiscard]] double natural_force() const;
  /// Forces of membranes in state a that supports do not take, over natural_force(); 0 without natural states. Collective.
  [[nodiscard]] double unbalanced_membrane(Vec a);
  /// Adds -dF/dlambda at a, by the growth of natural states with the load factor, to f. Collective. [N]
  void add_load_direction(Vec a, Vec f);
  /// What fraction of the way from Discretisation::patches_before() to the sheet's rest shape gathers have gone; 1: all, or
  /// there are none.
  [[nodiscard]] double drawn_in() const { return drawn_in_; }
  /// Seams that are pulled together; null: none.
  [[nodiscard]] const SewingSprings* sewing() const { return sewing_.get(); }

  /// The local points at state a, which stay until the next call; clamps and anchors are where conditions and obstacles
  /// have put them. Collective.
  [[nodiscard]] energy::Configuration configuration(Vec a);

  /// Overwrites f with the internal forces at a, of which c is the configuration. Collective. [N]
  void force(const energy::Configuration& c, Vec a, Vec f);
  /// Forces of the terms on the local points at c, which stay until the next evaluation. Not collective. [N]
  [[nodiscard]] std::vector<Vec3>& point_forces(const energy::Configuration& c);
  /// Energies at a, of which c is the configuration; on request with the viscous part of the time step among that of the
  /// membrane. Collective. [J]
  [[nodiscard]] Energies energies(const energy::Configuration& c, Vec a, bool viscous);
  /// From now on bending energies are found by the change since a: K_b a sums stiff forces that nearly cancel, and near
  /// a the differences of energies would be lost in its round-off. Collective.
  void count_from(Vec a);
  /// y = K_b x with the bending stiffness of the sheet alone, which [damping] is in proportion to [N/m]. Collective.
  void multiply_bending(Vec x, Vec y) const;
  /// Whether yarns rub inside the fabric, bent (energy/yarn_friction.hpp) or sheared (energy/yarn_law.hpp).
  [[nodiscard]] bool has_yarn_friction() const;
  /// Energy that this friction takes in the step that leads to a. Collective. [J]
  [[nodiscard]] double yarn_loss(Vec a);
  /// The step is accepted at a: sliders stay where they have slipped to. Steppers call it once a step. Collective.
  void end_step(Vec a);
  /// What all steps so far have taken [J], then the slips of all triangles in mesh order [1/m], a fixed number each; empty
  /// without this friction, and away from rank 0. Collective.
  [[nodiscard]] std::vector<double> slips() const;
  /// As slips() gave them on rank 0; nothing: sliders are where the fabric is at rest. Collective. Throws UserError on every
  /// rank where they are of another number of sliders.
  void restore_slips(std::vector<double> slips);
  /// Taken by all steps so far [J].
  [[nodiscard]] double yarn_losses() const { return yarn_losses_; }
  /// Remembers state a as the start of a time step: viscosity = relaxation time / time step; the materials' own
  /// relaxation times count with inverse_step = 1 / time step. Collective.
  void start_step(Vec a, double viscosity, double inverse_step = 0.0);

  /// Works of internal forces in a displacement [J]; positive where they take energy from the motion.
  struct Work {
    double elastic = 0.0, viscous = 0.0;  ///< of what is stored, and of the viscosity of the time step
  };
  /// As force(), with its works. Collective.
  [[nodiscard]] Work work(const energy::Configuration& c, Vec a, Vec displacement, Vec f);

  /// Overwrites the open values of `tangent`, whose pattern has this number, with the second derivatives of the terms and
  /// `bending` times K_b, springs to the ground once. [N/m]
  void write_tangent(const energy::Configuration& c, const BlockMatrix& tangent, int pattern,
                     const BlockMatrix::Values& values, double bending);

  /// Strains, forces and curvatures of the triangles, with what moments on edges add. Collective; values on rank 0.
  [[nodiscard]] TriangleFields triangle_fields(Vec a, const std::vector<energy::EdgeBend>& edge_bends);
  /// Triangles that `six_node_corrected` leaves as `six_node` has them. Collective.
  [[nodiscard]] long uncorrected_triangles() const;

 private:
  /// A term of the potential and the name under which its energy is counted.
  struct Counted {
    std::unique_ptr<Term> term;
    double Energies::*part;
  };
  using Curvatures = std::vector<energy::CurvatureOperator>;

  void add_body_lengths(Vec f) const;
  void add_term_forces(const Term& term, const energy::Configuration& c, Vec f);

  // Construction, in this order.
  void build_terms(const Curvatures& curvatures, const PotentialInput& input);
  void build_sheet(const Curvatures& curvatures, NaturalInput input);
  /// Lets triangle t bend by the angles at edges where that is chosen and possible.
  bool add_angles(Index t, const energy::CurvatureOperator& op, const energy::BendingElement& el,
                  const std::vector<Index>& local, bool owned);
  /// Couples stretching and bending of triangle t, whose membrane element was added last.
  void add_coupling(Index t, const energy::BendingElement& el, bool owned);
  void update_coupling();
  void build_joints(bool hinges);
  void build_mirror_folds();
  void build_yarns(const Curvatures& curvatures);
  [[nodiscard]] std::size_t slips_per_triangle() const;
  void tie(const Spring& spring, ElementTerm<energy::SpringTerm>& ties) const;
  template <class AnyTerm>
  AnyTerm& add_term(double Energies::*part);
  [[nodiscard]] BlockPattern make_pattern(const Curvatures& curvatures) const;

  Discretisation* on_;
  BoundaryConditions* conditions_;
  std::vector<Vec3> u_, x_, force_;  ///< of the local points
  std::vector<Counted> terms_;
  BatchTerm<energy::MembraneTerm>* membrane_ = nullptr;  ///< one of terms_
  BatchTerm<energy::AngleBendingTerm>* angles_ = nullptr;
  /// Triangles whose stretching and bending are coupled.
  struct Coupled {
    Index triangle, membrane;
    Vec3 rest_curvature;
  };
  std::vector<Coupled> coupled_;
  energy::CouplingTerm* coupling_ = nullptr;              ///< kernel of one of terms_, or null
  long coupled_version_ = -1;                             ///< of the membrane whose natural states it has
  BatchTerm<energy::YarnFrictionTerm>* yarns_ = nullptr;  ///< null: no friction of bent yarns
  double yarn_losses_ = 0.0;
  energy::MirrorFoldTerm* folds_ = nullptr;  ///< kernel of one of them
  energy::JointTerm* joints_ = nullptr;      ///< kernel of one of them, or null: no sheets are joined
  energy::AnchorTerm* anchors_ = nullptr;    ///< kernel of one of them, or null
  Recovery recovery_;
  ConstantMatrices constant_;
  HalfBlocks halves_;
  std::unique_ptr<BendingEnergy> bending_;
  std::unique_ptr<Bands> bands_;
  std::unique_ptr<NaturalStates> natural_;  ///< null where the natural state is the rest shape
  bool hold_natural_ = false;
  double time_ = 0.0;
  std::unique_ptr<SewingSprings> sewing_;  ///< null where nothing is sewn
  std::unique_ptr<Attachments> attachments_;
  petsc::VecHandle work_;
  double drawn_in_ = 1.0;
};

}  // namespace voile::system
