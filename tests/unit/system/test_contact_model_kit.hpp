// Sheets and obstacles for tests of contact in a model.
#pragma once

#include <doctest/doctest.h>

#include "geometry/intersections.hpp"
#include "solve/time_integration.hpp"
#include "system/contact.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"

namespace voile::testing::contacts {

using contact::ContactSet;
using contact::Obstacle;
using SupportKind = system::Support::Kind;
using LoadKind = system::Load::Kind;

/// Sheets of side 1 at heights k times `distance`, alternately shifted so that their vertices do not match.
inline mesh::MeshData sheets(int count, int cells, double distance) {
  mesh::MeshData all;
  all.source = "sheets";
  for (int k = 0; k < count; ++k) {
    const mesh::MeshData one = grid(cells, cells, k % 2 == 1, 0.1, 3u + static_cast<unsigned>(k));
    const auto first = static_cast<Index>(all.positions.size());
    for (const Vec3& x : one.positions) all.positions.emplace_back(x[0] + 0.03 * k, x[1] - 0.02 * k, distance * k);
    mesh::Group group{"sheet" + std::to_string(k), 2, {}, {}, {}};
    for (const mesh::Triangle& t : one.triangles) {
      group.triangles.push_back(static_cast<Index>(all.triangles.size()));
      all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    for (Index v = first; v < static_cast<Index>(all.positions.size()); ++v) group.vertices.push_back(v);
    all.groups.push_back(group);
  }
  return all;
}

inline Obstacle plane(double height, double friction = 0.0) {
  Obstacle o;
  o.name = "floor";
  o.shape = Obstacle::Shape::plane;
  o.points = {Vec3(0.0, 0.0, height)};
  o.friction = friction;
  return o;
}

inline Obstacle ball(const Vec3& centre, double radius) {
  Obstacle o;
  o.name = "ball";
  o.shape = Obstacle::Shape::sphere;
  o.points = {centre};
  o.radius = radius;
  return o;
}

inline system::ModelInput input(std::vector<Obstacle> obstacles, double distance) {
  system::ModelInput in;
  in.materials = {isotropic(1e5, 0.3, 1e-3, 0.3)};
  in.contact.active = true;
  in.contact.options = {distance, 1e4, 1e-3};
  in.contact.obstacles = std::move(obstacles);
  return in;
}

struct Problem {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle u, v;
  Problem(const mesh::MeshData& data, const system::ModelInput& in)
      : mesh(data),
        model(PETSC_COMM_WORLD, mesh, in),
        u(model.dofs().create_vector()),
        v(model.dofs().create_vector()) {}
};

/// Intersecting pairs of the sheet's triangles at a state. Collective.
inline std::size_t intersections(const system::Model& model, Vec u) {
  std::vector<Vec3> x = per_vertex(model, u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += model.dofs().mesh().positions()[i];
  return geometry::intersecting_triangles(x, model.dofs().mesh().triangles()).size();
}

/// Integrates and counts intersections after every step.
inline Ended integrate(Problem& p, const system::DynamicsOptions& d, const solve::TimeOptions& o,
                       const std::function<void(const system::State&, system::Dynamics&)>& look = {}) {
  system::Dynamics dynamics(p.model, d);
  solve::TimeIntegration time(dynamics, o);
  std::size_t found = 0;
  Ended r = follow_from(state_of(p.u, p.v), time, [&](const system::State& s, const solve::StepResult&) {
    found += intersections(p.model, s.u);
    CHECK(system::report(p.model.contact()->scene(), s.u).gap > 0.0);
    if (look) look(s, dynamics);
    return false;
  });
  CHECK(found == 0);
  return r;
}

/// Static residual of the start, free components only.
inline petsc::VecHandle residual(Problem& p) {
  petsc::VecHandle r = p.model.dofs().create_vector();
  p.model.conditions().set_load_factor(1.0);
  p.model.residual(p.u, r);
  p.model.dofs().clear_fixed(r);
  return r;
}

}  // namespace voile::testing::contacts
