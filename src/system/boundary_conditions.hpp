// Supports and loads in force: prescribed displacements, motions, applied forces, at a load factor and a time.
//
// Symbols   a       vector of unknowns (model.hpp)                                                             [m]
//           lambda  load factor;  f_d dead loads that follow it, f_c the others, at the time in force          [N]
//           abar, h prescribed displacement at lambda = 1, and what puts supports where they took hold         [m]
//   off_i = a_i - lambda abar_i - motion_i(t) - h_i                                     fixed components
//           f_e     forces from outside, constant until they are set again                                        [N]
//   f     = lambda f_d + f_c + f_e + f_follower(a, lambda) + f_gas(a, lambda)            applied forces
// Theory: docs/theory/path-following.md, equilibrium.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "discretisation.hpp"
#include "energy/term.hpp"
#include "rigid_loads.hpp"

namespace voile::energy {
struct EdgeBend;
class FollowerTerm;
}  // namespace voile::energy

namespace voile::system {

template <class Kernel>
class ElementTerm;
class Gas;
struct LowRankChange;

/// Where a prescribed motion is differentiated: the time in force, a step, and the end of the run. Before 0 and beyond the end the
/// motion may not be defined. [s]
struct MotionTime {
  double time, step, end;
};

class BoundaryConditions {
 public:
  /// `on` must outlive it. Supports move with the load factor instead of the time if `motion_by_load` says so.
  /// Collective. Throws UserError.
  BoundaryConditions(const Discretisation& on, std::vector<Support> supports, const std::vector<Load>& loads,
                     const std::vector<PointMass>& masses, bool motion_by_load, std::vector<RigidGroup> rigid = {},
                     const std::vector<PeriodicPair>& periodic = {});
  ~BoundaryConditions();
  BoundaryConditions(const BoundaryConditions&) = delete;
  BoundaryConditions& operator=(const BoundaryConditions&) = delete;

  /// Load factor of all later evaluations. Collective.
  void set_load_factor(double factor);
  [[nodiscard]] double load_factor() const { return load_factor_; }
  /// Time of all later evaluations: supports with a motion go where they are then, loads with a history change.
  /// Collective.
  void set_time(double time);
  /// Forces from outside, f_e, in the unknowns; null: none. Not collective. [N]
  void set_external(petsc::VecHandle force);
  /// Those in force, which then are none. Not collective. [N]
  [[nodiscard]] petsc::VecHandle take_external() { return std::exchange(external_, {}); }
  [[nodiscard]] bool has_external() const { return static_cast<bool>(external_); }
  /// Adds f_e times a factor, also what of it acts on rigid bodies, where they are at the state taken last. Collective.
  void add_external(double factor, Vec f) const;
  /// Where an owned vertex goes that a support `follows` holds: its displacement from the start. Not collective. [m]
  void set_displacement(Index local, const Vec3& u);
  /// Sets the fixed components of a to their prescribed values. Collective.
  void enforce(Vec a) const;
  /// Accelerations of the fixed components at a time, by second differences within the run, with the load factor as a function of
  /// time; the others stay. Supports that follow an obstacle get none. Collective. [m/s^2]
  void prescribe_acceleration(const MotionTime& at, const std::function<double(double)>& factor, Vec acceleration);
  /// Velocities of the fixed components likewise, as they come to the time or, `from_here`, as they go on; they jump where a motion
  /// has a corner. What follows an obstacle is left as it is. Collective. [m/s]
  void prescribe_velocity(const MotionTime& at, bool from_here, const std::function<double(double)>& factor,
                          Vec velocity);
  /// Supports take hold of what they hold where it is in state a: from now on prescribed displacements and motions count
  /// from there, a change of the load factor from `load_factor`, of the time (or of the load factor in its place) from
  /// `time`. A motion with a rotation turns them about its centre from where they are. Collective.
  void take_hold(Vec a, double time, double load_factor);

  [[nodiscard]] const RigidLoads& rigid() const { return rigid_; }
  /// False if follower loads, or moments on rigid bodies, make the tangent unsymmetric.
  [[nodiscard]] bool symmetric() const { return !any_follower_ && rigid_.symmetric(); }
  /// Writes off_i into the fixed components of `out`, which may hold a copy of a, and leaves the others. Not collective.
  void write_off(const petsc::ReadArray& a, const petsc::WriteArray& out) const;
  /// Whether supports are prescribed to go anywhere, and abar.
  [[nodiscard]] bool has_prescribed() const { return has_prescribed_; }
  [[nodiscard]] Vec prescribed() const { return prescribed_; }
  /// Fixed components that supports hold or move, not those that follow an obstacle.
  [[nodiscard]] const std::vector<PetscInt>& led() const { return led_; }
  /// Rotation of each support, by number.
  [[nodiscard]] const std::vector<Mat3>& rotations() const { return rotations_; }
  /// The largest angle by which a clamp turns between two times [rad]; with `by_load`, between two load factors. 0 where
  /// clamps turn with the other of the two. Not collective.
  [[nodiscard]] double turn_between(double from, double to, bool by_load) const;

  /// Overwrites f with the applied forces. `scratch` has one entry per local point. Collective. [N]
  void applied_forces(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const;
  /// Adds the gradient that follower loads stand for, which is less their forces. Collective. [N]
  void add_followers(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const;
  /// Work potential of the loads that are not followers, -f.u, and energy of gases. Collective. [J]
  [[nodiscard]] double potential(const energy::Configuration& c, Vec a) const;
  /// Adds the blocks of follower loads and gases to the open values of a tangent; `change` becomes what gases add besides.
  /// Collective.
  void add_blocks(const energy::Configuration& c, const BlockMatrix& tangent, int pattern,
                  const BlockMatrix::Values& values, LowRankChange& change);
  /// Adds the blocks of rigid bodies on whose local points the forces `sheet` act, to be used up, in the state taken last.
  void add_body_blocks(const energy::Configuration& c, std::vector<Vec3>& sheet, const BlockMatrix& tangent,
                       const BlockMatrix::Values& values);
  /// What moments on edges add to the curvature of triangles that this rank owns. Not collective.
  [[nodiscard]] std::vector<energy::EdgeBend> edge_bends() const;
  /// The same of bodies without any forces.
  void add_free_body_blocks(const BlockMatrix& tangent, const BlockMatrix::Values& values) {
    if (rigid_.any()) rigid_.add_blocks(std::vector<BodyForce>(always_on_bodies_.size()), {}, tangent, values);
  }
  /// In the order of the loads (gas.hpp).
  [[nodiscard]] const std::vector<Gas>& gases() const { return gases_; }
  [[nodiscard]] bool has_gas() const { return !gas_factors_.empty(); }
  /// Gases that leak: from now on they do; a step has been accepted. Collective.
  void begin_leaks(const energy::Configuration& c, double time);
  void end_leaks(const energy::Configuration& c, double time);
  /// What is left of each gas (GasContent), two numbers; empty if none leaks. The other way round: throws UserError.
  [[nodiscard]] std::vector<double> leaks() const;
  void restore_leaks(const std::vector<double>& contents);
  /// df/dlambda; `work` is scratch. Collective. [N]
  void load_direction(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec work, Vec f);

 private:
  void build_loads(const std::vector<Load>& loads, const std::vector<PointMass>& masses);
  [[nodiscard]] Vec force_of(const Load& load);
  void add_follower(const Load& load);
  void add_gas(const Load& load);
  void add_vertex_force(Index v, const Vec3& f, const petsc::WriteArray& force) const;
  void add_differences(const std::vector<PeriodicPair>& periodic);
  [[nodiscard]] int factor_of(const Load& load) const;
  void move_supports(double time);
  /// Adds sum_k w_k u(t + k step) of the prescribed places to the fixed components; the last puts the time in force.
  void rebase_motions(Vec a, double time, double load_factor);
  void add_differences_in_time(const std::vector<std::pair<int, double>>& weights, double time, double step,
                               const std::function<double(double)>& factor, const petsc::WriteArray& to);

  /// Of the loads on rigid bodies, all but moments.
  [[nodiscard]] std::vector<BodyForce> on_bodies() const;

  const Discretisation* on_;
  RigidLoads rigid_;
  std::vector<Support> supports_;
  bool motion_by_load_;
  struct Mover {  ///< a component of an owned vertex whose support moves
    Index local;
    int component, support;
    Vec3 rest;  ///< from which its motion is counted: where it starts, or would have to come from [m]
  };
  std::vector<Mover> movers_;  ///< those of a vertex and support one after the other
  std::vector<PetscInt> led_;
  std::vector<Mat3> rotations_;
  std::unique_ptr<ElementTerm<energy::FollowerTerm>> followers_;
  bool any_follower_ = false, has_prescribed_ = false;
  struct TimedLoad {  ///< with a history of its own
    std::function<double(double)> history;
    int factor;  ///< number among the follower term's
    petsc::VecHandle force;
    std::vector<BodyForce> on_bodies{};
    double now = 0.0;  ///< factor at the time in force
  };
  std::vector<TimedLoad> timed_;
  std::vector<Gas> gases_;
  std::vector<int> gas_factors_;           ///< of each, as those of follower loads
  mutable std::vector<Vec3> gas_scratch_;  ///< one entry per local point, with gases
  petsc::VecHandle dead_, constant_, prescribed_, motion_, hold_;
  petsc::VecHandle always_;    ///< the part of constant_ that does not change with time
  petsc::VecHandle external_;  ///< f_e, or none
  /// Parts of dead_, always_ and external_ that act on rigid bodies, which these do not hold.
  std::vector<BodyForce> dead_on_bodies_, always_on_bodies_, external_on_bodies_;
  double load_factor_ = 0.0;
};

/// Fractions of vertices in what is spread over a surface or curve, as loads are: calls add(vertex, share) with the force
/// of `load` on it. Not collective. Throws UserError for unknown groups.
void spread(const Discretisation& on, const Load& load, const std::function<void(Index, const Vec3&)>& add);

}  // namespace voile::system
