// Laminates of plies with the corrected membrane against closed forms, linear.
//
// Simply supported square plate, side 1, specially orthotropic, under a uniform load q (Navier's series; R.M. Jones, Mechanics of
// Composite Materials, 2nd ed. 1999, section 5.3):
//   w = sum_mn odd 16 q / (pi^6 m n) sin(m pi/2) sin(n pi/2) / (D11 m^4 + 2 (D12 + 2 D66) m^2 n^2 + D22 n^4)
// Thin ring pulled by two opposite forces F per width, poisson_12 = 0, which bends without stretching:
//   each of them moves by  (pi/8 - 1/pi) F R^3 / D,  D the bending stiffness around the ring
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "test_model_kit.hpp"

namespace test_laminates {

using namespace voile;
using namespace voile::testing;
using energy::MembraneOperator;
using std::numbers::pi;

namespace {

constexpr double quarter = pi / 2.0;

/// Plies 25 times stiffer along their fibres, in a stack of three; material axis 1 along `direction`.
energy::Material stack(const std::array<double, 3>& angles, double thickness, double poisson, const Vec3& direction) {
  const Mat3 ply = energy::orthotropic_membrane(25e6, 1e6, poisson, 0.5e6, 1.0);
  const energy::LaminateStiffness l =
      energy::laminate(ply, {{angles[0], thickness / 4}, {angles[1], thickness / 2}, {angles[2], thickness / 4}});
  energy::Material m;
  m.membrane = l.membrane;
  m.bending = l.bending;
  m.direction = direction;
  return m;
}

/// Displacement of the vertex at a place under the loads, by the linear problem.
Vec3 displacement_at(const mesh::MeshData& data, const system::ModelInput& input, const Vec3& place) {
  const mesh::SurfaceMesh mesh(data);
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle zero = model.dofs().create_vector(), r = model.dofs().create_vector(),
                   a = model.dofs().create_vector();
  model.residual(zero, r);
  VOILE_PETSC(VecScale(r, -1.0));
  model.assemble_tangent(zero, {.kind = energy::Tangent::exact});
  solve_linear(model, r, a);
  Index at = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if ((mesh.positions()[v] - place).norm() < (mesh.positions()[at] - place).norm()) at = v;
  return per_vertex(model, a)[static_cast<std::size_t>(at)];
}

double plate_error(Pattern pattern, int n, const energy::Material& material, MembraneOperator membrane) {
  system::ModelInput input;
  input.materials = {material};
  input.element.membrane = membrane;
  for (const char* edge : {"left", "right", "bottom", "top"})
    input.supports.push_back(support(edge, system::Support::Kind::hinged));
  input.loads = {load(system::Load::Kind::area, "", Vec3(0.0, 0.0, 1.0))};
  const Mat3& d = material.bending;
  double exact = 0.0;
  for (int m = 1; m < 60; m += 2)
    for (int k = 1; k < 60; k += 2) {
      const double sign = (m + k) % 4 == 2 ? 1.0 : -1.0, mm = m * m, kk = k * k;
      exact += 16.0 * sign / (std::pow(pi, 6) * m * k) /
               (d(0, 0) * mm * mm + 2.0 * (d(0, 1) + 2.0 * d(2, 2)) * mm * kk + d(1, 1) * kk * kk);
    }
  return displacement_at(square(pattern, n), input, Vec3(0.5, 0.5, 0.0)).z() / exact - 1.0;
}

/// A quarter of the ring, R = 1, width 0.2, fibres as the stack has them to its axis.
double ring_error(int n, double jitter, const energy::Material& material, MembraneOperator membrane) {
  mesh::MeshData data = grid(n, 2, false, jitter);
  add_square_groups(data);
  data =
      mapped(data, [](const Vec3& x) { return Vec3(std::sin(quarter * x[0]), 0.2 * x[1], std::cos(quarter * x[0])); });
  system::ModelInput input;
  input.materials = {material};
  input.element.membrane = membrane;
  input.supports = {support("left", system::Support::Kind::symmetry),
                    support("right", system::Support::Kind::symmetry)};
  input.supports[0].normal = Vec3::UnitX();
  input.supports[1].normal = Vec3::UnitZ();
  input.supports.push_back(support("bottom", system::Support::Kind::displacement));
  input.supports[2].components = {false, true, false};
  input.loads = {load(system::Load::Kind::line, "left", Vec3(0.0, 0.0, 0.5))};
  const double exact = (pi / 8.0 - 1.0 / pi) / material.bending(1, 1);
  return displacement_at(data, input, Vec3(0.0, 0.1, 1.0)).z() / exact - 1.0;
}

}  // namespace

TEST_CASE("orthotropic plates of plies: second order with the corrected membrane, fibres either way") {
  for (const bool along : {true, false}) {
    const double outer = along ? 0.0 : quarter;
    const energy::Material m = stack({outer, quarter - outer, outer}, 0.01, 0.25, Vec3::UnitX());
    CHECK((along ? m.bending(0, 0) / m.bending(1, 1) : m.bending(1, 1) / m.bending(0, 0)) > 5.0);
    for (const Pattern p : {Pattern::diagonal, Pattern::union_jack, Pattern::jittered}) {
      const double coarse = plate_error(p, 8, m, MembraneOperator::six_node_corrected),
                   fine = plate_error(p, 16, m, MembraneOperator::six_node_corrected);
      if (mpi::rank(PETSC_COMM_WORLD) == 0)
        MESSAGE(fmt::format("{}, outer fibres along {}: {:+.2f}, {:+.2f} %", name_of(p), along ? "x" : "y",
                            100 * coarse, 100 * fine));
      CHECK(std::abs(coarse) < 0.05);
      CHECK(std::abs(fine) < std::max(0.35 * std::abs(coarse), 2.5e-3));  // small where errors of both signs meet
    }
  }
}

TEST_CASE(
    "a thin ring of plies bends without stretching with the corrected membrane, where the six-node membrane locks") {
  for (const bool around : {true, false}) {
    const double outer = around ? quarter : 0.0;
    const energy::Material m = stack({outer, quarter - outer, outer}, 1e-3, 0.0, Vec3::UnitY());
    for (const double jitter : {0.0, 0.25}) {
      const double corrected = ring_error(16, jitter, m, MembraneOperator::six_node_corrected),
                   plain = ring_error(16, jitter, m, MembraneOperator::six_node);
      if (mpi::rank(PETSC_COMM_WORLD) == 0)
        MESSAGE(fmt::format("outer fibres {} the ring, moved by {}: {:+.2f} %, six nodes {:+.1f} %",
                            around ? "around" : "across", jitter, 100 * corrected, 100 * plain));
      CHECK(std::abs(corrected) < 0.02);
      CHECK(plain < -0.1);
    }
  }
}

}  // namespace test_laminates
