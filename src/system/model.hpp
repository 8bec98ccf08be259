// The discrete problem of one mesh: what is stored, constraints, contact, matrices and loads, divided over the ranks.
//
// Symbols   a     vector of unknowns, three per vertex in the vertex's own axes Q_v (see constraints.hpp)       [m]
//           u_v   = Q_v a_v displacement;  mirror points follow from the vertices (see patch.hpp)
//           E     what the sheet and what is tied to it store (potential.hpp)                                  [J]
//           E_k   contact and friction (contact.hpp)                                                           [J]
//   r(a)  = dE/da + dE_k/da - f      free components, f the applied forces
//   r_i   = off_i                    fixed components (both in boundary_conditions.hpp)
// Theory: docs/theory/path-following.md, equilibrium.
#pragma once

#include <memory>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "boundary_conditions.hpp"
#include "conditions.hpp"
#include "contact_input.hpp"
#include "discretisation.hpp"
#include "energies.hpp"
#include "energy/element_options.hpp"
#include "energy/material.hpp"
#include "potential.hpp"
#include "tangent.hpp"

namespace voile::system {

class Contact;

/// What a model is built from besides the mesh.
struct ModelInput {
  energy::ElementOptions element;
  std::vector<energy::Material> materials;
  std::vector<Support> supports;
  std::vector<Load> loads;
  ContactInput contact;
  std::vector<PointMass> masses = {};
  std::vector<Spring> springs = {};
  bool motion_by_load = false;  ///< supports move with the load factor instead of the time
  Sewing sewing = {};
  std::vector<Attachment> attachments = {};
  std::vector<SeamRule> seams = {};
  NaturalInput natural = {};
  std::vector<RigidGroup> rigid = {};
  std::vector<PeriodicPair> periodic = {};
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
  /// What the sheet and what is tied to it store.
  [[nodiscard]] Potential& potential() const { return *potential_; }
  /// The tangent assembled last.
  [[nodiscard]] const Tangent& tangent() const { return tangent_; }
  /// Time of all later evaluations, for conditions and obstacles. Collective.
  void set_time(double time);
  /// From now on supports, loads and obstacles stay where and what they are, whatever the time, until this is called
  /// with false: for a motion that is only a way to an equilibrium. Not collective.
  void hold_still(bool still);
  [[nodiscard]] bool holds_still() const { return held_still_; }

  /// r(a) as above. Collective.
  void residual(Vec a, Vec r);
  /// Internal minus applied forces on every component, fixed ones included: there it is the reaction. Collective.
  void unbalanced_force(Vec a, Vec f);
  /// Overwrites f with all applied forces in state a. Collective. [N]
  void applied_forces(Vec a, Vec f);
  /// Overwrites f with the forces of follower loads in state a. Collective. [N]
  void follower_forces(Vec a, Vec f);
  /// Strains, forces and curvatures of the triangles. Collective; values on rank 0.
  [[nodiscard]] TriangleFields triangle_fields(Vec a);
  /// What moments on edges store in the slopes there, beyond the energy of free edges. In a motion it is left out, as is the work
  /// by which it came. Collective. [J]
  [[nodiscard]] double edge_energy() const;
  /// Norm of the largest of applied forces, reactions, forces of natural states and of contact at the last residual: what a
  /// residual is small against. [N]
  [[nodiscard]] double force_scale() const { return force_scale_; }
  /// Stored minus external energy, viscous part of the time step included; only meaningful for a symmetric model.
  /// Collective.
  [[nodiscard]] double energy(Vec a);
  /// Tangent at a. Fixed rows and columns are eliminated. Collective.
  void assemble_tangent(Vec a, const TangentRequest& request);
  /// f = -dr/dlambda at a: how the load grows with the load factor. Where displacements are prescribed it needs the
  /// tangent assembled last, which must be that at a. Collective.
  void load_direction(Vec a, Vec f);
  /// Pairs of vertices that contact has coupled in the tangent so far, besides the sheet: two numbers each, on rank 0. How
  /// exactly an incomplete factor solves depends on them, and so where a step ends within its tolerance. Collective.
  [[nodiscard]] std::vector<double> couplings() const;
  /// The same pairs again, in a model of the same mesh: as given on rank 0. Collective.
  void couple(std::vector<double> pairs);

 private:
  void add_lumped_mass(const TangentRequest& request, const BlockMatrix::Values& values);
  [[nodiscard]] MPI_Comm comm() const { return on_->comm(); }

  std::unique_ptr<Discretisation> on_;
  std::unique_ptr<BoundaryConditions> conditions_;
  std::unique_ptr<Contact> contact_;
  std::unique_ptr<Potential> potential_;
  Tangent tangent_;
  std::vector<Vec3> previous_u_, previous_x_, force_;  ///< of the local points
  petsc::VecHandle work_;
  double force_scale_ = 0.0, contact_force_ = 0.0;
  bool held_still_ = false;
};

/// What is stored, in parts, and the work potential of dead loads; without viscosity and friction, on request without
/// contact. Collective. [J]
[[nodiscard]] Energies energies(Model& model, Vec a, bool with_contact = true);

}  // namespace voile::system
