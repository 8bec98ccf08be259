// Parts of contact.hpp: barriers that grow, obstacles that are ignored, predictors that hit nothing. Private to src/system.
#pragma once

#include <string>
#include <vector>

#include "contact/contact_set.hpp"
#include "contact_memory.hpp"
#include "contact_scene.hpp"

namespace voile::system {

/// How far barriers reach at a time, as ContactSet::set_reaches() takes it. Not collective.
[[nodiscard]] std::vector<double> reaches_at(const ContactScene& scene, const ContactMemory& memory, double time);
/// Sets the distances at which barriers begin at the time in force. Not collective.
void settle(ContactScene& scene, const ContactMemory& memory);
/// Puts the obstacles where they are at a time, and the barriers that grow. Not collective.
void set_time(ContactScene& scene, const ContactMemory& memory, double time);
/// Which vertices pass through which obstacles, for the pairs. Not collective.
void set_passing(ContactScene& scene, const ContactMemory& memory);
/// Of obstacles that another stage has had.
void forget_absent(const ContactScene& scene, ContactMemory& memory);
/// Vertices that are free again see the obstacles again. Collective.
void end_passing(ContactScene& scene, ContactMemory& memory);

/// The trajectory of a predictor from one state to another, while obstacles move; made clear by moving its end.
class PredictorTrajectory {
 public:
  /// From state `from` at time t0 to state `to` at t1. All must outlive it.
  PredictorTrajectory(ContactScene& scene, ContactMemory& memory, Vec from, double t0, Vec to, double t1);

  /// One attempt: changes the free components of `to` until nothing collides; false if no such end is found. Sets the
  /// time to t1. Collective.
  [[nodiscard]] bool clear();
  /// Attempts in which more and more of what is found blocked passes through passable obstacles. Collective.
  [[nodiscard]] bool clear_passing();
  /// The pair that collided last or was pinched, in words; the same on every rank.
  [[nodiscard]] const std::string& obstruction() const { return obstruction_; }

 private:
  /// What a pair that collides asks one of its points to do.
  struct Motion {
    Index point;
    Vec3 displacement;  ///< [m]
  };
  /// The motion that the points of a pair that collides are given in common: that of the obstacle or support in it, or
  /// the mean of two free parts. [m]
  [[nodiscard]] Vec3 common_motion(const contact::Pair& pair) const;
  /// Those of all pairs of this rank that collide, by point; says in obstruction_ what the first is. Collective.
  [[nodiscard]] std::vector<Motion> blocked_motions(const std::vector<char>& asked);
  void move_along(const std::vector<Motion>& motions) const;
  void note_blocked(const contact::Pair& pair);
  /// What clear() found blocked passes through passable obstacles; false if there are none. Collective.
  bool pass_blocked();
  /// Begins to let out what passes through obstacles since `before`. Collective.
  void let_out(const std::vector<double>& before);

  ContactScene& scene_;
  ContactMemory& memory_;
  Vec from_, to_;
  double t0_, t1_;
  std::vector<contact::Plane> planes_, planes_end_;  ///< at t0 and t1
  std::string obstruction_;
  std::vector<double> blocked_;  ///< as ContactMemory::passing, for what the last attempt found in its way
};

}  // namespace voile::system
