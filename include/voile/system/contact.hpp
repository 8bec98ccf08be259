// Contact of a model: obstacles that move, rules between bodies, and the terms of contact on distributed unknowns.
//
// Symbols   a      vector of unknowns (model.hpp);  x_v = X_v + Q_v a_v positions                             [m]
//           t      time in force: where the obstacles are                                                   [s]
// Pairs are divided over the ranks: a rank has those that hold one of its vertices, so that its rows are complete
// without communication. It knows the positions of its own vertices, of those of other ranks that may come near
// (contact_halo.hpp), and of all obstacles; arrays have places for all points, most of them unused.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voile/base/petsc.hpp"
#include "voile/contact/contact_set.hpp"
#include "voile/contact/obstacles.hpp"
#include "voile/system/block_matrix.hpp"
#include "voile/system/contact_halo.hpp"
#include "voile/system/contact_input.hpp"
#include "voile/system/contact_memory.hpp"
#include "voile/system/contact_report.hpp"
#include "voile/system/dofs.hpp"

namespace voile::system {

/// Whether an obstacle gives way to what it pinches.
[[nodiscard]] bool has_yielding_obstacles(const ContactInput& input);
/// How many vertices some obstacle gives way to.
[[nodiscard]] long yielding_count(const ContactMemory& memory);

class Contact {
 public:
  /// `dofs` must outlive it. Collective. Throws UserError for unknown names in rules, a contact distance that is too
  /// large for the mesh, and obstacles that make no sense.
  Contact(const Dofs& dofs, ContactInput input);

  /// Puts the obstacles where they are at time t. Collective.
  void set_time(double time);
  /// From now on obstacles stay where they are, whatever the time, until this is called with false. Not collective.
  void hold_obstacles(bool still);
  /// Remembers friction from state a; `slip`: slip below which friction is smoothed [m]. Collective.
  void start_step(Vec a, double slip);
  /// Takes normal forces and directions of friction from state a, slips still counted from the start of the step.
  /// Collective.
  void lag_friction(Vec a);
  /// Begins a motion at state a and time t. Pairs nearer than the contact distance would be thrown apart. So the barrier
  /// of a point begins at its smallest gap, where it exerts no force, and grows to the contact distance within
  /// options.settle_time. A point whose contact force is balanced by other forces keeps its full barrier: where
  /// `residual`, the static residual at a (model.hpp) [N], is less than half of the contact force. Collective.
  void begin_settling(Vec a, Vec residual, double time);
  [[nodiscard]] const ContactMemory& memory() const { return memory_; }
  /// Goes on from what another contact of the same mesh, or a checkpoint, remembered. Not collective.
  void restore(ContactMemory memory);

  /// Energy of contact and friction, the same on every rank; infinite if something touches. Collective. [J]
  [[nodiscard]] double energy(Vec a);
  /// Adds the derivative of the energy to f (all components, fixed ones too). Collective. [N]
  void add_gradient(Vec a, Vec f, contact::ContactSet::Part part = contact::ContactSet::both);
  /// True if a pair that acts at state a lacks its place in the matrix on some rank; then `pattern` becomes `base`, of this rank's
  /// rows, with the columns that contacts within a few contact distances need. Collective.
  [[nodiscard]] bool extend_pattern(Vec a, const BlockMatrix& matrix, const BlockPattern& base, BlockPattern& pattern);
  /// Adds the second derivative at the state of the last call of extend_pattern(). `positive`: pairs without their negative
  /// part.
  void add_blocks(const BlockMatrix& matrix, const BlockMatrix::Values& values, bool positive);

  /// Largest fraction of the increment da that state a can take without touching, obstacles at rest. Collective.
  [[nodiscard]] double step_fraction(Vec a, Vec da);
  /// Changes the free components of the predictor `to` until nothing collides on straight paths from `from`, while the
  /// obstacles move from time t0 to t1: points that would be hit move along with what hits them. False if no such
  /// predictor is found. Sets the time to t1. With `may_yield`, obstacles that yield are ignored by the vertices that
  /// cannot evade them, until the triangles of these are the contact distance away from the obstacle at the start of
  /// a step. Collective.
  [[nodiscard]] bool clear_predictor(Vec from, double t0, Vec to, double t1, bool may_yield = false);
  /// The pair that collided in the last predictor that could not be cleared, in words; the same on every rank.
  [[nodiscard]] const std::string& obstruction() const { return obstruction_; }

  [[nodiscard]] ContactReport report(Vec a);
  /// Smallest gap of each vertex to anything that it can touch, or `limit`; the same on every rank. Collective. [m]
  [[nodiscard]] std::vector<double> gaps(Vec a, double limit);
  /// Surface, planes at the time in force, pairs.
  [[nodiscard]] const contact::ContactSet& set() const { return *set_; }
  /// Positions of all points, the obstacles' at the time in force; on every rank. Collective.
  [[nodiscard]] std::vector<Vec3> positions(Vec a) const;
  /// With notes on the mesh and the contact distance added.
  [[nodiscard]] const ContactInput& input() const { return input_; }
  [[nodiscard]] const Dofs& dofs() const { return *dofs_; }
  /// The time in force [s]. Not collective.
  [[nodiscard]] double time() const { return time_; }
  /// Positions of the points of obstacle k at the time in force [m]; none for a plane. Not collective.
  [[nodiscard]] std::vector<Vec3> obstacle_points(std::size_t k) const;

 private:
  /// What a pair that collides asks one of its points to do.
  struct Motion {
    Index point;
    Vec3 way;  ///< [m]
  };
  /// The motion that the points of a pair that collides between x_ and other_ are given in common: that of the obstacle
  /// or support in it, or the mean of two free parts. [m]
  [[nodiscard]] Vec3 common_motion(const contact::Pair& pair, const std::vector<contact::Plane>& planes,
                                   const std::vector<contact::Plane>& planes_end) const;
  /// Those of all pairs of this rank that collide, by point; says in obstruction_ what the first is. Collective.
  [[nodiscard]] std::vector<Motion> blocked_motions(const std::vector<contact::Plane>& planes,
                                                    const std::vector<contact::Plane>& planes_end,
                                                    const std::vector<char>& asked);
  void move_along(const std::vector<Motion>& motions, Vec to) const;
  /// Whether neighbours must be exempt; notes which. Throws UserError if that holds for much of the mesh.
  [[nodiscard]] bool lacks_room(const mesh::SurfaceMesh& mesh);
  /// Sets `balanced`, per vertex and alike on all ranks, to 0 where the other forces (minus `others`) do not balance the
  /// normal contact force; true if that is new for some vertex. Collective.
  [[nodiscard]] bool note_unbalanced(Vec a, Vec others, std::vector<double>& balanced);
  /// Sets the distances at which barriers begin at the time in force.
  void settle();
  /// One attempt of clear_predictor.
  [[nodiscard]] bool try_clear(Vec from, double t0, Vec to, double t1);
  void note_blocked(const contact::Pair& pair);
  /// Lets obstacles give way to what try_clear found blocked; false if none of them does. Collective.
  bool yield_to_blocked();
  /// Begins to let out, from state a, what obstacles have come to give way to since `before`. Collective.
  void let_out_yielding(Vec a, double time, const std::vector<double>& before);
  /// Vertices that are free again see the obstacles again.
  void end_yielding();
  /// Of a triangle that holds an own vertex, at x_.
  [[nodiscard]] bool is_free(const mesh::Triangle& t, std::size_t obstacle) const;
  void tell_yielding();
  [[nodiscard]] int body(const std::string& name) const;
  /// Candidates for all positions between two states; true if some were found anew. Collective.
  bool cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to);
  /// Positions of own vertices and ghosts, of which there may be others after cover(). Collective.
  void locate(Vec a, std::vector<Vec3>& x) const;
  /// x_ at state a, covered. Collective.
  void take_positions(Vec a);
  [[nodiscard]] Vec3 displacement(int body, const Vec3& place) const {
    return held_ ? Vec3(Vec3::Zero()) : obstacles_->displacement(body, place, start_time_, time_);
  }
  [[nodiscard]] std::string words(const contact::Pair& pair) const;
  [[nodiscard]] std::string lowest_rank_text(const std::string& own) const;

  const Dofs* dofs_;
  MPI_Comm comm_;
  const mesh::SurfaceMesh* mesh_;
  const mesh::Partition* partition_;
  ContactInput input_;
  Index first_row_ = 0, row_count_ = 0;
  std::optional<contact::Obstacles> obstacles_;
  std::unique_ptr<contact::ContactSet> set_;
  std::unique_ptr<ContactHalo> halo_;  ///< null on a rank that is alone
  petsc::ScatterHandle to_all_;
  petsc::VecHandle all_, change_;
  std::vector<Vec3> x_, other_, force_, start_;  ///< of all points, right for those that are seen
  double slip_ = 1.0;
  double time_ = 0.0, start_time_ = 0.0;
  std::optional<double> held_;  ///< time at which obstacles stand still [s]
  std::string obstruction_;
  ContactMemory memory_;
  std::vector<double> blocked_;  ///< as ContactMemory::yielding, for what the last attempt found in its way
};

/// Whether an obstacle gives way to a vertex of this triangle of the sheet. Not collective.
[[nodiscard]] bool gives_way(const Contact& contact, const std::array<Index, 3>& triangle, int body);

}  // namespace voile::system
