// Where rigid bodies are and how they move, from one stage to the next: the unknowns of a body begin at nothing in each stage, since
// they count from where the body is (rigid_bodies.hpp), and its keys with them.
//
// Numbers of each body, in the order of the groups: where the stage has begun (c_1, quaternion of R_1, its time, and 1, or 0 if no
// stage has), where the body is (c, quaternion of R), and its velocity and spin [m/s], [rad/s].
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "discretisation.hpp"
#include "state.hpp"

namespace voile::system {

inline constexpr std::size_t rigid_place_numbers = 22;

/// The vectors of a state whose unknowns of bodies are kept, in this order; each may be null.
[[nodiscard]] std::array<Vec, 5> rigid_vectors(const State& s);
/// These unknowns, of all bodies in one vector after the other, on rank 0, none on others. Collective.
[[nodiscard]] std::vector<double> rigid_unknowns(const Dofs& dofs, const State& s);

/// What a step of results keeps of bodies: their unknowns, and their places. On rank 0; empty without bodies. Collective.
[[nodiscard]] std::vector<double> rigid_record(const Discretisation& on, const State& s);
/// Takes it apart; nothing of one that makes no sense. Not collective.
void take_rigid_record(const std::vector<double>& record, std::vector<double>& unknowns, std::vector<double>& places);

/// The numbers of all bodies on rank 0, none on others; v: velocities of the unknowns, may be null. Collective.
[[nodiscard]] std::vector<double> rigid_places(const Discretisation& on, Vec u, Vec v);

/// Makes the places where bodies are those where a stage begins, at a time [s]. Not collective.
void begin_stage_at(double time, std::vector<double>& places);

/// Puts groups where a stage has begun. `in_time`: their motions are functions of the time, else of the load factor. Not
/// collective.
void put_rigid_groups(const std::vector<double>& places, bool in_time, std::vector<RigidGroup>& groups);

/// Velocities of the unknowns as a stage begins, as Dofs::scatter_bodies takes them. Not collective.
[[nodiscard]] std::vector<double> rates_at(const std::vector<double>& places, const std::vector<RigidBody>& bodies);

}  // namespace voile::system
