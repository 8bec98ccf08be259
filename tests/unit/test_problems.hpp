// Small problems that several tests follow.
#pragma once

#include "test_model_kit.hpp"

namespace voile::testing {

/// A strip clamped at the left, 10 x 1, h = 0.1, bent by `shear` spread over its right edge. Full scale: 4.
struct Strip {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  explicit Strip(double shear)
      : mesh(mapped(square_strip(), [](const Vec3& x) { return Vec3(10.0 * x[0], x[1], 0.0); })),
        model(PETSC_COMM_WORLD, mesh, input(shear)),
        a(model.dofs().create_vector()) {}

  static mesh::MeshData square_strip() {
    mesh::MeshData d = grid(16, 2, false, 0.0);
    add_square_groups(d);
    return d;
  }
  static system::ModelInput input(double shear) {
    system::ModelInput in;
    in.materials = {isotropic(1.2e6, 0.0, 0.1)};
    in.supports = {support("left", system::Support::Kind::clamped)};
    in.loads = {load(system::Load::Kind::line, "right", Vec3(0.0, 0.0, shear))};
    return in;
  }
};

/// A shallow arch between hinges, pressed in its middle: it snaps through near load factor 0.7.
struct Arch {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  Arch() : mesh(data()), model(PETSC_COMM_WORLD, mesh, input()), a(model.dofs().create_vector()) {}

  static mesh::MeshData data() {
    mesh::MeshData d = grid(12, 2, true, 0.0);
    add_square_groups(d);
    mesh::Group crown{"crown", 0, {6, 19, 32}, {}, {}};
    d.groups.push_back(crown);
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.2 * x[1], 0.24 * x[0] * (1.0 - x[0])); });
  }
  static system::ModelInput input() {
    system::ModelInput in;
    in.materials = {isotropic(1e6, 0.3, 0.01)};
    in.supports = {support("left", system::Support::Kind::hinged), support("right", system::Support::Kind::hinged)};
    in.loads = {load(system::Load::Kind::point, "crown", Vec3(0.0, 0.0, -0.1))};
    return in;
  }
};

inline std::vector<double> values_of(const system::Model& model, Vec a) {
  std::vector<double> u = model.dofs().gather(a);
  mpi::broadcast(model.dofs().comm(), u);
  return u;
}

}  // namespace voile::testing
