// The discrete problem of one mesh: terms, constraints, matrices and loads, divided over the ranks.
//
// Symbols   a     vector of unknowns, three per vertex in the vertex's own axes Q_v (see constraints.hpp)       [m]
//           u_v   = Q_v a_v displacement;  mirror points follow from the vertices (see patch.hpp)
//           K_b   constant bending stiffness, assembled once and copied into each tangent                       [N/m]
//                 (with the springs to the ground, which are constant too)
//           f_b   constant force of bending at a = 0 (bending_energy.hpp)                                              [N]
//           E_t    terms of the potential (term.hpp): membrane, bending of curved rest shapes beyond K_b, ties  [J]
//           E_k    contact and friction (contact.hpp)                                                           [J]
//   r(a)  = K_b a + f_b + sum_t dE_t/da + dE_k/da - f      free components, f the applied forces
//   r_i   = off_i                                           fixed components (both in boundary_conditions.hpp)
// Elements that touch an owned vertex are evaluated by its rank, so that rows are complete without communication;
// energies count each triangle once, on its owner.
#pragma once

#include <memory>
#include <vector>

#include "voile/base/petsc.hpp"
#include "voile/energy/element_options.hpp"
#include "voile/energy/material.hpp"
#include "voile/system/attachments.hpp"
#include "voile/system/block_matrix.hpp"
#include "voile/system/boundary_conditions.hpp"
#include "voile/system/conditions.hpp"
#include "voile/system/constant_matrices.hpp"
#include "voile/system/contact_input.hpp"
#include "voile/system/discretisation.hpp"
#include "voile/system/recovery.hpp"
#include "voile/system/tangent.hpp"

namespace voile::energy {
struct CurvatureOperator;
class MembraneTerm;
class SpringTerm;
}  // namespace voile::energy

namespace voile::system {

class BendingEnergy;
class Contact;
class Bands;
class SewingSprings;
class Term;
template <class Kernel>
class ElementTerm;

/// What a model is built from besides the mesh.
struct ModelInput {
  energy::ElementOptions element;
  std::vector<energy::Material> materials;
  std::vector<Support> supports;
  std::vector<Load> loads;
  ContactInput contact;
  std::vector<PointMass> masses = {};
  std::vector<Spring> springs = {};
  bool motion_by_load = false;  ///< supports move with the load factor in place of the time
  Sewing sewing = {};
  std::vector<Attachment> attachments = {};
  std::vector<SeamRule> seams = {};
};

struct Energies {
  double membrane = 0.0, bending = 0.0;  ///< [J]
  double external = 0.0;                 ///< work potential of dead loads, -f.u [J]
  double contact = 0.0;                  ///< barriers [J]
  double springs = 0.0;                  ///< [J]
};

/// The supports, and those by which hard attachments hold, which are added to them.
[[nodiscard]] const std::vector<Support>& with_followers(ModelInput& input);

class Model {
 public:
  /// Builds everything. Collective; the mesh must be the same on all ranks and outlive the model.
  /// Throws UserError on every rank for unknown groups and contradictions.
  Model(MPI_Comm comm, const mesh::SurfaceMesh& mesh, ModelInput input);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  /// The mesh, its elements and how they are divided.
  [[nodiscard]] const Discretisation& discretisation() const { return *on_; }
  /// Numbering, halo, fixed components, and what needs nothing but these.
  [[nodiscard]] const Dofs& dofs() const { return on_->dofs(); }
  /// Supports and loads. Time and load factor count in all later evaluations.
  [[nodiscard]] BoundaryConditions& conditions() { return *conditions_; }
  [[nodiscard]] const BoundaryConditions& conditions() const { return *conditions_; }
  /// Contact, or null if the case has none.
  [[nodiscard]] Contact* contact() const { return contact_.get(); }
  /// What is held to obstacles.
  [[nodiscard]] Attachments& attachments() const { return *attachments_; }
  /// Time of all later evaluations, for conditions and obstacles. Collective.
  void set_time(double time);
  /// From now on supports, loads and obstacles stay where and what they are, whatever the time, until this is called
  /// with false: for a motion that is only a way to an equilibrium. Not collective.
  void hold_still(bool still);

  /// r(a) as above. Collective.
  void residual(Vec a, Vec r);
  /// Internal minus applied forces on every component, fixed ones included: there it is the reaction. Collective.
  void unbalanced_force(Vec a, Vec f);
  /// Norm of the larger of applied forces and reactions of the last residual: what a residual is small against. [N]
  [[nodiscard]] double force_scale() const { return force_scale_; }
  /// From now on bending energies are found by the change since a: K_b u sums stiff forces that nearly cancel, and near
  /// a the differences of energies would be lost in its round-off. Collective.
  void count_energy_from(Vec a);
  /// Stored minus external energy, viscous part of the time step included; only meaningful for a symmetric model.
  /// Collective.
  [[nodiscard]] double energy(Vec a);
  /// What share of the way from Discretisation::patches_before() to the sheet's rest shape gathers have gone; 1: all, or there are none.
  [[nodiscard]] double drawn_in() const { return drawn_in_; }
  /// What is stored, in parts, and the work potential of dead loads; without viscosity and friction, on request without
  /// contact. Collective.
  [[nodiscard]] Energies energies(Vec a, bool with_contact = true);
  /// Whether that changes with the time alone: clamps that turn, seams that are pulled, attachments. Not collective.
  [[nodiscard]] bool stores_by_time() const;

  /// Works of forces in a displacement [J]; positive where a load does it, or where the others take energy from the motion.
  struct Work {
    double internal = 0.0, viscous = 0.0;  ///< of what is stored, and of the viscosity of the time step
    double contact = 0.0, friction = 0.0, loads = 0.0;
  };
  /// Of the forces at a in `displacement`, all components. Overwrites f with the unbalanced force as above. Collective.
  [[nodiscard]] Work work(Vec a, Vec displacement, Vec f);

  /// Tangent at a. Fixed rows and columns are eliminated. Collective.
  void assemble_tangent(Vec a, const TangentRequest& request);
  /// Of the rank's own vertices in the state of the last evaluation, three coordinates each [m].
  [[nodiscard]] std::vector<double> owned_places() const;
  /// The one assembled last.
  [[nodiscard]] const Tangent& tangent() const { return tangent_; }
  /// f = -dr/dlambda at a: how the load grows with the load factor. Where displacements are prescribed it needs the
  /// tangent assembled last, which must be that at a. Collective.
  void load_direction(Vec a, Vec f);
  /// Bending stiffness, damping and mass.
  [[nodiscard]] const ConstantMatrices& constant() const { return constant_; }

  /// Remembers state a as the start of a time step: viscosity = relaxation time / time step; the materials' own
  /// relaxation times count with inverse_step = 1 / time step. Collective.
  void start_step(Vec a, double viscosity, double inverse_step = 0.0);
  /// Collective; values on rank 0.
  [[nodiscard]] TriangleFields triangle_fields(Vec a);
  /// Triangles that `six_node_corrected` leaves as `six_node` has them. Collective.
  [[nodiscard]] long uncorrected_triangles() const;

 private:
  /// A term of the potential and the name under which its energy is counted.
  struct Counted {
    std::unique_ptr<Term> term;
    double Energies::*part;
  };
  using Curvatures = std::vector<energy::CurvatureOperator>;

  [[nodiscard]] MPI_Comm comm() const { return on_->comm(); }
  [[nodiscard]] energy::Configuration configuration(Vec a);
  [[nodiscard]] Energies energies_of_sheet(Vec a);
  void add_term_forces(const Term& term, const energy::Configuration& c, Vec f);

  // Construction, in this order.
  void build_terms(const Curvatures& curvatures, const std::vector<Spring>& springs, Sewing sewing);
  void tie(const Spring& spring, ElementTerm<energy::SpringTerm>& ties) const;
  template <class Kernel>
  ElementTerm<Kernel>& add_term(double Energies::*part);
  [[nodiscard]] BlockPattern make_pattern(const Curvatures& curvatures) const;

  std::unique_ptr<Discretisation> on_;
  std::vector<Vec3> u_, x_, previous_u_, previous_x_, force_;  ///< of the local points
  std::vector<Counted> terms_;
  ElementTerm<energy::MembraneTerm>* membrane_ = nullptr;  ///< one of terms_
  Recovery recovery_;
  ConstantMatrices constant_;
  Tangent tangent_;
  std::unique_ptr<BendingEnergy> bending_;
  std::unique_ptr<Bands> bands_;
  std::unique_ptr<SewingSprings> sewing_;  ///< null where nothing is sewn
  std::unique_ptr<BoundaryConditions> conditions_;
  std::unique_ptr<Contact> contact_;
  std::unique_ptr<Attachments> attachments_;
  petsc::VecHandle work_;
  double force_scale_ = 0.0;
  double drawn_in_ = 1.0;
  bool held_still_ = false;
};

}  // namespace voile::system
