// Fields from the old mesh to the new one, and momentum kept.
//
// Vertices that were kept keep their values bit by bit. At new ones, in the unfolded plane of the old triangle they lie in:
//   linear      barycentric: the old surface itself
//   smooth      Clough-Tocher triangle with gradients from the quadratics fitted to one ring of vertices
//   smoother    the same with gradients from cubics over two rings: for velocities, whose waves it damps less
// New vertices of open seams get linear values, so that the two sides are as far apart as they were.
// The smooth ones are exact for fields that are quadratic in a flat chart; charts are carried across seams by their joins.
// Source: R. W. Clough & J. L. Tocher, Conf. Matrix Methods in Structural Mechanics (1965).
#pragma once

#include <functional>
#include <vector>

#include "remesh.hpp"

namespace voile::adapt {

enum class Interpolation { linear, smooth, smoother };

/// Values of a field, three per vertex of the old mesh, at the vertices of the new one. Not collective.
/// Throws InternalError if the field is not per vertex of the old mesh.
[[nodiscard]] std::vector<Vec3> transfer(const mesh::SurfaceMesh& old_mesh, const Remeshed& remeshed,
                                         const std::vector<Vec3>& field, Interpolation kind);

/// A set of moving points: masses [kg], places [m], velocities [m/s], each per vertex.
struct Motion {
  const std::vector<double>& mass;
  const std::vector<Vec3>& places;
  const std::vector<Vec3>& velocity;
};

/// Linear momentum [kg m/s] and angular momentum about the centre of mass [kg m^2/s].
struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
[[nodiscard]] Momentum momentum(const Motion& motion);

/// Adds a rigid motion to the velocities of the new mesh so that its momentum is that of the old one. `held` per vertex:
/// keeps its velocity; empty: none does. Not collective. Directions that the free vertices cannot turn in are left.
void conserve_momentum(const Motion& old_motion, const std::vector<double>& mass, const std::vector<Vec3>& places,
                       const std::vector<char>& held, std::vector<Vec3>& velocity);

/// The same so that the momentum that `of` finds is `wanted`; nearly, where mass is not at the vertices alone.
void conserve_momentum(const Momentum& wanted, const std::function<Momentum(const std::vector<Vec3>&)>& of,
                       const std::vector<double>& mass, const std::vector<Vec3>& places, const std::vector<char>& held,
                       std::vector<Vec3>& velocity);

/// Kinetic energy [J], and the largest fraction by which velocities may change for it.
struct Addition {
  double energy = 0.0, most = 0.0;
};
/// Adds kinetic energy (or takes it away) by one factor on what velocities of free vertices have beyond their rigid motion,
/// so that momentum stays. Returns the factor. Arguments as above. Not collective.
double add_kinetic_energy(const std::vector<double>& mass, const std::vector<Vec3>& places,
                          const std::vector<char>& held, const Addition& addition, std::vector<Vec3>& velocity);

}  // namespace voile::adapt
