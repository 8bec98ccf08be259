// What holds and loads rigid bodies: prescribed motions of reference points, forces and moments there, and the loads that the
// sheet spreads over the vertices of bodies. Symbols: rigid_bodies.hpp.
#pragma once

#include <optional>
#include <vector>

#include "base/petsc.hpp"
#include "discretisation.hpp"

namespace voile::system {

class RigidLoads {
 public:
  /// `on` must outlive it. Not collective.
  RigidLoads(const Discretisation& on, std::vector<RigidGroup> groups);

  [[nodiscard]] bool any() const { return !groups_.empty(); }
  /// Whether a body is prescribed to go anywhere.
  [[nodiscard]] bool moves() const;
  /// Whether a moment acts on a body that may turn about more than one axis: it has no potential then.
  [[nodiscard]] bool symmetric() const;
  /// Forces at the reference points themselves, at load factor 1: those that grow with it, or the constant ones.
  [[nodiscard]] std::vector<BodyForce> forces(bool constant) const;
  /// Takes forces on vertices of bodies out of a vector of forces by vertex: that of a body acts on its carriers. Collective.
  [[nodiscard]] std::vector<BodyForce> take(Vec force) const;
  /// Writes the prescribed unknowns at a time. Not collective.
  void move(double time, const petsc::WriteArray& unknowns) const;
  /// The rotation vector of a prescribed turn with whole turns in it; absent: there is none, or another turn came before [rad].
  [[nodiscard]] std::optional<Vec3> prescribed_turn(std::size_t body, double time) const;
  /// The largest angle by which a body is turned between two times [rad].
  [[nodiscard]] double turn_between(double from, double to) const;

  // At the state that the unknowns took last
  /// Adds forces on bodies to the rows of the carriers. Not collective. [N]
  void add(const std::vector<BodyForce>& on, Vec f) const;
  /// Likewise moments at a load factor, with the constant ones or without. [N]
  void add_moments(double load_factor, bool constant, Vec f) const;
  /// Work potential of the same; that of moments only where they have one. [J]
  [[nodiscard]] double potential(const std::vector<BodyForce>& on, double load_factor) const;
  /// Adds the second derivatives of what acts: `total` of the sheet less `applied`, and, at a load factor, moments. [N/m]
  void add_blocks(const std::vector<BodyForce>& total, std::optional<double> load_factor, const BlockMatrix& tangent,
                  const BlockMatrix::Values& values) const;

 private:
  [[nodiscard]] const Dofs& dofs() const { return on_->dofs(); }
  [[nodiscard]] Vec3 moment(std::size_t i, double load_factor) const {
    return (groups_[i].constant ? 1.0 : load_factor) * groups_[i].moment;
  }
  [[nodiscard]] const RigidBody& body(std::size_t i) const { return on_->constraints().bodies[i]; }

  const Discretisation* on_;
  std::vector<RigidGroup> groups_;
};

/// Of each body in state a with the unbalanced force f: displacement of the reference point [m], rotation vector [rad], force
/// [N] and moment [N m] about it that hold the body; twelve numbers each on rank 0. `linear`: of small rotations. Collective.
[[nodiscard]] std::vector<double> rigid_values(const Discretisation& on, Vec a, Vec f, bool linear);

}  // namespace voile::system
