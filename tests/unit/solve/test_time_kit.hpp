// A motion for tests of time integration.
#pragma once

#include <doctest/doctest.h>

#include "solve/time_integration.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"

namespace voile::testing::motion {

using solve::TimeOptions;
using system::Dynamics;
using system::DynamicsOptions;
using LoadKind = system::Load::Kind;
using SupportKind = system::Support::Kind;

/// A cantilevered strip 1 x 0.25 of light cloth-like shell that begins to fall at t = 0.
struct Falling {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle u, v;

  explicit Falling(const system::ModelInput& in = input())
      : mesh(data()),
        model(PETSC_COMM_WORLD, mesh, in),
        u(model.dofs().create_vector()),
        v(model.dofs().create_vector()) {}
  static mesh::MeshData data() {
    mesh::MeshData d = grid(8, 2, false, 0.0);
    add_square_groups(d);
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.25 * x[1], 0.0); });
  }
  static system::ModelInput input() {
    system::ModelInput in;
    in.materials = {isotropic(1e5, 0.3, 0.01, 0.5)};
    in.supports = {support("left", SupportKind::clamped)};
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    return in;
  }
};

/// Runs to the end; returns the final positions and velocities on every rank.
template <class Problem>
std::vector<double> integrate(Problem& p, const DynamicsOptions& d, const TimeOptions& o, const Look& look = {},
                              int steps = -1) {
  Dynamics dynamics(p.model, d);
  solve::TimeIntegration time(dynamics, o);
  const Ended r = follow_from(state_of(p.u, p.v), time, look);
  CHECK(r.completed);
  CHECK(r.reason.empty());
  if (steps >= 0) CHECK(r.steps == steps);
  std::vector<double> state = values_of(p.model, p.u);
  const std::vector<double> speed = values_of(p.model, p.v);
  state.insert(state.end(), speed.begin(), speed.end());
  return state;
}

}  // namespace voile::testing::motion
