// The sheet and its obstacles at a state and a time: surface, rules between bodies, positions, and who is near whom.
//
// Symbols   a      vector of unknowns (model.hpp);  x_v = X_v + Q_v a_v positions                             [m]
//           t      time in force: where the obstacles are                                                   [s]
// Pairs are divided over the ranks: a rank has those that hold one of its vertices, so that its rows are complete
// without communication. It knows the positions of its own vertices, of those of other ranks that may come near
// (contact_halo.hpp), and of all obstacles; arrays have places for all points, most of them unused.
// Theory: docs/theory/contact.md.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/petsc.hpp"
#include "contact/contact_set.hpp"
#include "contact/obstacles.hpp"
#include "contact_halo.hpp"
#include "contact_input.hpp"
#include "contact_report.hpp"
#include "dofs.hpp"

namespace voile::system {

class ContactScene {
 public:
  /// Positions of all points, right for those that this rank sees [m].
  struct Points {
    std::vector<Vec3> now;    ///< at the state last taken, obstacles at the time in force
    std::vector<Vec3> end;    ///< of the trajectory looked at last
    std::vector<Vec3> start;  ///< of the step
  };

  /// `dofs` must outlive it. Collective. Throws UserError for unknown names in rules, a activation distance that is too
  /// large for the mesh, and obstacles that make no sense.
  ContactScene(const Dofs& dofs, ContactInput input);
  ContactScene(const ContactScene&) = delete;
  ContactScene& operator=(const ContactScene&) = delete;

  [[nodiscard]] const Dofs& dofs() const { return *dofs_; }
  /// With notes on the mesh and the activation distance added.
  [[nodiscard]] const ContactInput& input() const { return input_; }
  [[nodiscard]] const contact::Obstacles& obstacles() const { return *obstacles_; }
  /// Surface, planes at the time in force, pairs.
  [[nodiscard]] const contact::ContactSet& set() const { return *set_; }
  [[nodiscard]] contact::ContactSet& set() { return *set_; }
  [[nodiscard]] const Points& points() const { return points_; }
  [[nodiscard]] Points& points() { return points_; }

  /// The time in force [s]. Not collective.
  [[nodiscard]] double time() const { return time_; }
  /// That of begin_step() [s].
  [[nodiscard]] double start_time() const { return start_time_; }
  /// Puts the obstacles where they are at time t. Not collective.
  void set_time(double time);
  /// From now on obstacles stay where they are, whatever the time, until this is called with false. Not collective.
  void hold_obstacles(bool still);
  /// Puts the obstacles' points in x, and the planes, where they are at a time, or where they are held. Not collective.
  void place_obstacles(double time, std::vector<Vec3>& x, std::vector<contact::Plane>& planes) const;
  /// How far obstacles move between two times, over what each may in a step: its smallest extent, so that the sheet is not behind it,
  /// between one cell of this size [m] and so many. Of a half-space, a point above or below the sheet. Not collective.
  [[nodiscard]] double way_of_obstacles(double before, double now, double cell, double cells) const;

  /// Positions of own vertices and of those of other ranks that are seen, of which there may be others after cover().
  /// Collective.
  void locate(Vec a, std::vector<Vec3>& x) const;
  /// Candidates for all positions between two states; true if some were found anew. Collective.
  bool cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to);
  /// points().now at state a, covered. Collective.
  void take(Vec a);
  /// From now on slips count from the state last taken, at the time in force. Not collective.
  void begin_step();
  /// The planes at the start of the step. Not collective.
  [[nodiscard]] std::vector<contact::Plane> planes_at_start() const;
  /// Takes normal forces and directions of friction from the state last taken. Not collective.
  void lag_friction(double slip);

  /// Positions of all points at a state, obstacles' at the time in force; on every rank. Collective. [m]
  [[nodiscard]] std::vector<Vec3> positions(Vec a) const;

 private:
  /// Whether neighbours must be exempt; notes which. Throws UserError if that holds for much of the mesh.
  [[nodiscard]] bool lacks_room();
  void set_rules();
  [[nodiscard]] int body(const std::string& name) const;
  /// Tells friction how far the obstacles' surfaces have been carried since the start of the step.
  void carry();

  const Dofs* dofs_;
  ContactInput input_;
  std::optional<contact::Obstacles> obstacles_;
  std::unique_ptr<contact::ContactSet> set_;
  Points points_;
  std::unique_ptr<ContactHalo> halo_;  ///< null on a rank that is alone
  petsc::ScatterHandle to_all_;
  petsc::VecHandle all_;
  double time_ = 0.0, start_time_ = 0.0;
  std::optional<double> held_;  ///< time at which obstacles stand still [s]
};

/// Positions of the points of obstacle k at the time in force [m]; none for a plane. Not collective.
[[nodiscard]] std::vector<Vec3> obstacle_points(const ContactScene& scene, std::size_t k);
/// A pair in words: who, and where it is now. Not collective.
[[nodiscard]] std::string words(const ContactScene& scene, const contact::Pair& pair);
/// Contacts at state a, which is taken. Collective.
[[nodiscard]] ContactReport report(ContactScene& scene, Vec a);
/// Smallest gap of each vertex to anything that it can touch, or `limit`; the same on every rank. Collective. [m]
[[nodiscard]] std::vector<double> gaps(const ContactScene& scene, Vec a, double limit);

}  // namespace voile::system
