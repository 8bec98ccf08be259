// Problems for tests of Newton and of continuation.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "solve/newton.hpp"
#include "test_model_kit.hpp"

namespace voile::testing::newton {

using Kind = system::Support::Kind;
using LoadKind = system::Load::Kind;

/// Tolerances close to round-off, for comparisons tighter than the defaults of 1e-8 and 1e-6.
struct Tight {
  Option rtol{"-snes_rtol", "1e-12"}, stol{"-snes_stol", "1e-10"};
};

inline system::Support displacement(const std::string& group, std::array<bool, 3> components, const Vec3& value) {
  system::Support s = support(group, Kind::displacement);
  s.components = components;
  s.value = value;
  return s;
}

inline double largest(const std::vector<Vec3>& u) {
  double size = 0.0;
  for (const Vec3& x : u) size = std::max(size, x.norm());
  return size;
}

inline double difference(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
  REQUIRE(p.size() == q.size());
  double size = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) size = std::max(size, (p[i] - q[i]).norm());
  return size;
}

/// Strip clamped at the left, 10 x 1 x 0.1, end shear 4 at load factor 1.
inline mesh::MeshData strip(int nx, int ny) {
  mesh::MeshData d = grid(nx, ny, false, 0.0);
  add_square_groups(d);
  return mapped(d, [](const Vec3& x) { return Vec3(10.0 * x[0], x[1], 0.0); });
}

inline system::ModelInput cantilever() {
  system::ModelInput input;
  input.materials = {isotropic(1.2e6, 0.0, 0.1)};
  input.supports = {support("left", Kind::clamped)};
  input.loads = {load(LoadKind::line, "right", Vec3(0.0, 0.0, 4.0))};
  return input;
}

/// A curved panel in turned space: one edge moved, one in a symmetry plane, under its own weight.
struct TurnedPanel {
  Mat3 turn;
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  explicit TurnedPanel(const Mat3& t)
      : turn(t),
        mesh(mapped(square(Pattern::jittered, 8),
                    [&](const Vec3& x) {
                      return Vec3(t * Vec3(x[0], x[1], 0.2 * std::cos(1.2 * (1.0 - x[0])) + 0.15 * x[1] * x[1]));
                    })),
        model(PETSC_COMM_WORLD, mesh, input(t)),
        a(model.dofs().create_vector()) {
    model.conditions().set_load_factor(1.0);
  }

  static system::ModelInput input(const Mat3& t) {
    system::ModelInput in;
    // Which of two patch fits gives an edge its slope is decided by a condition number that depends on the axes; here
    // all fits are used, so that nothing but round-off does.
    in.element.max_patch_condition = 1e6;
    in.materials = {isotropic(3e5, 0.3, 0.02, 0.1)};
    in.supports = {support("left", Kind::hinged), support("right", Kind::symmetry)};
    in.supports[0].value = t * Vec3(-0.02, 0.01, 0.03);
    in.supports[1].normal = t * Vec3::UnitX();
    in.loads = {load(LoadKind::gravity, "", t * Vec3(0.0, 0.3, -9.81))};
    return in;
  }
  /// Displacements in the axes before the turn.
  std::vector<Vec3> turned_back() const {
    std::vector<Vec3> u = per_vertex(model, a);
    for (Vec3& x : u) x = turn.transpose() * x;
    return u;
  }
};

inline Mat3 oblique_turn() {
  return Eigen::AngleAxisd(0.9, Vec3(1.0, -0.5, 0.8).normalized()).toRotationMatrix();
}

}  // namespace voile::testing::newton
