// Contact of a model: the terms of contact on distributed unknowns, how far steps may go, and what is remembered.
//
// Symbols   a      vector of unknowns (model.hpp)
//           t      time in force: where the obstacles are                                                   [s]
// Theory: docs/theory/contact.md.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "contact/contact_set.hpp"
#include "contact_memory.hpp"
#include "contact_scene.hpp"

namespace voile::system {

/// Whether what an obstacle pinches passes through it.
[[nodiscard]] bool has_passable_obstacles(const ContactInput& input);
/// How many vertices pass through some obstacle.
[[nodiscard]] long passing_count(const ContactMemory& memory);

class Contact {
 public:
  struct Clearance {
    bool clear = false;       ///< whether such a predictor was found
    std::string obstruction;  ///< the pair that collided last or was pinched, in words; the same on every rank
  };

  /// As ContactScene. Collective.
  Contact(const Dofs& dofs, ContactInput input);

  /// The sheet, the obstacles at the time in force, and their pairs.
  [[nodiscard]] const ContactScene& scene() const { return scene_; }
  [[nodiscard]] ContactScene& scene() { return scene_; }
  /// Puts the obstacles, and barriers that grow, where they are at time t. Not collective.
  void set_time(double time);
  [[nodiscard]] const ContactMemory& memory() const { return memory_; }
  /// Goes on from what another contact of the same mesh, or a checkpoint, remembered. Not collective.
  void restore(ContactMemory memory);

  /// Remembers friction from state a; `slip`: slip below which friction is smoothed [m]. Collective.
  void start_step(Vec a, double slip);
  /// Takes normal forces and directions of friction from state a, slips still counted from the start of the step.
  /// Collective.
  void lag_friction(Vec a);
  /// Begins a motion at state a and time t. Pairs nearer than the activation distance would be thrown apart. So the barrier
  /// of a point begins at its smallest gap, where it exerts no force, and grows to the activation distance within
  /// options.settle_time. A point whose contact force is balanced by other forces keeps its full barrier: where
  /// `residual`, the static residual at a (model.hpp) [N], is less than half of the contact force; and so does one that the
  /// stage before has left with this very force, which friction or its own inertia may balance. Collective.
  void begin_settling(Vec a, Vec residual, double time);
  /// The normal contact force on each vertex at state a, in global axes, on every rank. Collective. [N]
  [[nodiscard]] std::vector<double> push(Vec a);
  /// What barriers at state a have gained since time `before` because they grow. Collective. [J]
  [[nodiscard]] double grown_since(Vec a, double before);

  /// Energy of contact and friction, the same on every rank; infinite if something touches. Collective. [J]
  [[nodiscard]] double energy(Vec a, contact::ContactSet::Part part = contact::ContactSet::both);
  /// What friction takes from the start of the step to state a, with the forces there. Collective. [J]
  [[nodiscard]] double friction_work(Vec a);
  /// The force that the sheet exerts on each obstacle at state a, friction included, the same on every rank; NaN where that of a
  /// state from elsewhere is not known. Collective. [N]
  [[nodiscard]] std::vector<Vec3> forces_on_obstacles(Vec a);
  /// Work of what moves the obstacles from the start of the step, with the normal forces at state a. Collective. [J]
  [[nodiscard]] double obstacle_work(Vec a);
  /// Adds the derivative of the energy to f (all components, fixed ones too). Returns the norm of all forces on vertices, also of
  /// those that cancel at one. Collective. [N]
  double add_gradient(Vec a, Vec f, contact::ContactSet::Part part = contact::ContactSet::both);
  /// True if a pair that acts at state a lacks its place in the matrix on some rank; then `pattern` becomes `base`, of this rank's
  /// rows, with the columns that contacts within a few activation distances need. Collective.
  [[nodiscard]] bool extend_pattern(Vec a, const BlockMatrix& matrix, const BlockPattern& base, BlockPattern& pattern);
  /// Adds the second derivative at the state of the last call of extend_pattern(). `positive`: pairs without their negative
  /// part.
  void add_blocks(const BlockMatrix& matrix, const BlockMatrix::Values& values, bool positive);

  /// Largest fraction of the increment da that state a can take without touching, obstacles at rest. Collective.
  [[nodiscard]] double step_fraction(Vec a, Vec da);
  /// Changes the free components of the predictor `to` until nothing collides on straight paths from `from`, while the
  /// obstacles move from time t0 to t1: points that would be hit move along with what hits them. Sets the time to t1.
  /// With `may_pass`, passable obstacles are ignored by the vertices that cannot evade them, until the triangles of
  /// these are the activation distance away from the obstacle at the start of a step. Collective.
  [[nodiscard]] Clearance clear_predictor(Vec from, double t0, Vec to, double t1, bool may_pass = false);

 private:
  /// Lets points that a stage has pressed with another barrier begin where this one presses as much as `before`. Collective.
  void match_push(Vec a, const std::vector<double>& before, const std::vector<double>& gaps,
                  const std::vector<double>& balanced);
  /// Sets `balanced`, per vertex and alike on all ranks, to 0 where the other forces (minus `others`) do not balance the
  /// normal contact force, unless that is `before`; true if that is new for some vertex. Collective.
  [[nodiscard]] bool note_unbalanced(Vec a, Vec others, const std::vector<double>& before,
                                     std::vector<double>& balanced);

  ContactScene scene_;
  ContactMemory memory_;
  petsc::VecHandle change_;
  std::vector<Vec3> force_;  ///< of the sheet's vertices, right for those that are seen [N]
  double slip_ = 1.0;
};

/// Whether a vertex of this triangle of the sheet passes through the obstacle. Not collective.
[[nodiscard]] bool passes(const Contact& contact, const std::array<Index, 3>& triangle, int body);

}  // namespace voile::system
