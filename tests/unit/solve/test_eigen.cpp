// Vibration and buckling against closed forms: plates of thin-plate theory, S. Timoshenko & J. Gere, Theory of Elastic
// Stability (1961), section 9.2, and S. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and Shells (1959).
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <numbers>

#include "solve/eigen.hpp"
#include "solve/load_path.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_eigen {

using namespace voile;
using namespace voile::testing;
using system::Mass;
using SupportKind = system::Support::Kind;
using LoadKind = system::Load::Kind;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double thickness = 0.01, density = 20.0;

double stiffness() {
  return 2e9 * std::pow(thickness, 3) / 12.0 / (1.0 - 0.09);
}

/// A unit square plate; edges free, or supported normal to the plane so that it can be pressed along x.
struct Plate {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  Plate(mesh::MeshData d, bool supported, double press = 0.0)
      : mesh((add_square_groups(d), d)),
        model(PETSC_COMM_WORLD, mesh, input(supported, press)),
        a(model.dofs().create_vector()) {}
  static system::ModelInput input(bool supported, double press) {
    system::ModelInput in;
    in.materials = {isotropic(2e9, 0.3, thickness, density)};
    if (!supported) return in;
    for (const char* edge : {"left", "right", "bottom", "top"}) {
      system::Support s = support(edge, SupportKind::displacement);
      s.components = {edge == std::string("left"), edge == std::string("bottom"), true};
      in.supports.push_back(s);
    }
    if (press != 0.0) in.loads = {load(LoadKind::line, "right", Vec3(-press, 0.0, 0.0))};
    return in;
  }
};

/// Frequency of mode (m, n) of the supported plate under the tension n_x per width.
double frequency(int m, int n, double tension = 0.0) {
  const double kx = m * pi, ky = n * pi, k2 = kx * kx + ky * ky;
  const double square = (stiffness() * k2 * k2 + tension * kx * kx) / density;
  return std::copysign(std::sqrt(std::abs(square)), square) / (2.0 * pi);
}

}  // namespace

TEST_CASE("a supported plate vibrates at its exact frequencies, with second order in the lumped mass") {
  for (const bool alternate : {false, true})
    for (const Mass mass : {Mass::consistent, Mass::lumped}) {
      CAPTURE(alternate);
      CAPTURE(static_cast<int>(mass));
      std::vector<double> error;
      for (const int n : {8, 16}) {
        Plate plate(grid(n, n, alternate, 0.0), true);
        const solve::EigenResult r = solve::vibration_modes(plate.model, plate.a, 4, mass);
        REQUIRE(r.modes.size() == 4);
        error.push_back(r.modes[0].value / frequency(1, 1) - 1.0);
        if (n == 16) {
          CHECK(r.modes[0].value == relative(frequency(1, 1)).epsilon(0.01));
          CHECK(r.modes[1].value == relative(frequency(1, 2)).epsilon(0.02));
          CHECK(r.modes[2].value == relative(frequency(2, 1)).epsilon(0.02));
          CHECK(r.modes[3].value == relative(frequency(2, 2)).epsilon(0.03));
          for (const solve::Mode& mode : r.modes) CHECK(mode.residual < 1e-12);
        }
      }
      MESSAGE(fmt::format("relative error of the first frequency at n = 8, 16: {:.2e}, {:.2e}", error[0], error[1]));
      // With the consistent mass the errors of mass and stiffness nearly cancel.
      if (mass == Mass::lumped) CHECK(std::log2(std::abs(error[0] / error[1])) > 1.7);
      if (mass == Mass::consistent) CHECK(std::abs(error[1]) < 1e-3);
    }
}

TEST_CASE("a free plate has exactly six rigid modes") {
  Plate plate(gmsh_square(8), false);
  const solve::EigenResult r = solve::vibration_modes(plate.model, plate.a, 8, Mass::consistent);
  REQUIRE(r.modes.size() == 8);
  const double first = r.modes[6].value;
  for (int k = 0; k < 6; ++k) CHECK(std::abs(r.modes[k].value) < 1e-3 * first);
  // lambda^2 = 13.468 of a free square plate with nu = 0.3: A.W. Leissa, J. Sound Vib. 31 (1973) 257-293 gives 13.489.
  CHECK(first == relative(13.468 * std::sqrt(stiffness() / density) / (2.0 * pi)).epsilon(0.02));
}

TEST_CASE("the largest displacement of a mode is 1, wherever it points") {
  Plate plate(mapped(grid(6, 6, true, 0.0), [](const Vec3& x) { return Vec3(0.8 * x[0], x[1], 0.6 * x[0]); }), false);
  const solve::EigenResult r = solve::vibration_modes(plate.model, plate.a, 7, Mass::consistent);
  REQUIRE(r.modes.size() == 7);
  const std::vector<double> u = plate.model.dofs().gather_change(r.modes[6].shape);
  double largest = 0.0;
  for (std::size_t i = 0; i + 2 < u.size(); i += 3) largest = std::max(largest, std::hypot(u[i], u[i + 1], u[i + 2]));
  // Of two that are alike to 1e-9 it is the first, whatever round-off makes of them.
  if (!u.empty()) CHECK(largest == relative(1.0).epsilon(1e-8));
}

TEST_CASE("the mass matrix knows the mass, its first moment, supports and oblique axes") {
  mesh::MeshData d = grid(5, 4, true, 0.2);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.8 * x[1], 0.6 * x[1]); }));
  system::ModelInput in;
  in.materials = {isotropic(1e3, 0.3, 0.05, 7.0)};
  system::Model free(PETSC_COMM_WORLD, mesh, in);
  const system::BlockMatrix mass = free.potential().constant().consistent_mass();
  petsc::VecHandle x = free.dofs().create_vector(), y = free.dofs().create_vector(),
                   product = free.dofs().create_vector();
  set_displacement(free, x, [](Index) { return Vec3(1.0, 2.0, -2.0); });
  VOILE_PETSC(MatMult(mass.mat(), x, product));
  CHECK(dot(x, product) == relative(9.0 * 7.0).epsilon(1e-12));  // |v|^2 times density times area 1
  set_displacement(free, y, [&](Index v) { return Vec3(mesh.positions()[v][0], 0.0, 0.0); });
  CHECK(dot(y, product) == relative(7.0 * 0.5).epsilon(1e-12));  // integral of x over the square
  VOILE_PETSC(MatMult(mass.mat(), y, product));
  CHECK(dot(y, product) == relative(7.0 / 3.0).epsilon(1e-12));  // integral of x^2, exact for linear fields
  // A symmetry plane oblique to the axes turns the unknowns; kinetic energy must not notice.
  system::Support plane = support("top", SupportKind::symmetry);
  plane.normal = Vec3(0.0, 0.8, 0.6);
  in.supports = {plane};
  system::Model held(PETSC_COMM_WORLD, mesh, in);
  const system::BlockMatrix held_mass = held.potential().constant().consistent_mass();
  petsc::VecHandle z = held.dofs().create_vector(), held_product = held.dofs().create_vector();
  const Vec3 along(0.3, 0.6, -0.8);  // in the plane of symmetry
  set_displacement(held, z, [&](Index) { return along; });
  VOILE_PETSC(MatMult(held_mass.mat(), z, held_product));
  CHECK(dot(z, held_product) == relative(7.0 * along.squaredNorm()).epsilon(1e-12));
  VOILE_PETSC(VecSet(z, 1.0));
  held.dofs().clear_free(z);
  CHECK(norm(z) > 0.0);
  VOILE_PETSC(MatMult(held_mass.mat(), z, held_product));
  CHECK(norm(held_product) == 0.0);
}

TEST_CASE("tension raises frequencies, pressure lowers them to zero at the buckling load") {
  const double critical = 4.0 * pi * pi * stiffness();
  for (const double fraction : {-1.0, 0.5, 1.2}) {
    CAPTURE(fraction);
    Plate plate(grid(16, 16, false, 0.0), true, fraction * critical);
    solve::LoadPath path(plate.model, {});
    REQUIRE(follow_from(state_of(plate.a), path).completed);
    const solve::EigenResult r = solve::vibration_modes(plate.model, plate.a, 1, Mass::consistent);
    REQUIRE(!r.modes.empty());
    // Its square is a difference; the error is that of bending, over its part.
    const auto squared = [](double f) { return std::copysign(f * f, f); };
    CHECK(std::abs(squared(r.modes[0].value) - squared(frequency(1, 1, -fraction * critical))) <
          0.02 * squared(frequency(1, 1)));
  }
}

TEST_CASE("a plate buckles at 4 pi^2 D / b^2 from any load below, with second order") {
  const double critical = 4.0 * pi * pi * stiffness();
  std::vector<double> error;
  for (const int n : {8, 16}) {
    Plate plate(grid(n, n, false, 0.0), true, 0.1 * critical);
    solve::Newton newton(plate.model);
    const solve::EigenResult r = solve::buckling_modes(newton, plate.model, plate.a, 2);
    REQUIRE(r.modes.size() == 2);
    error.push_back(r.modes[0].value / 10.0 - 1.0);
    // Two half waves: (2 + 1/2)^2 = 6.25 instead of 4.
    CHECK(r.modes[1].value == relative(10.0 * 6.25 / 4.0).epsilon(n == 8 ? 0.12 : 0.035));
    CHECK(r.modes[0].value < r.modes[1].value);
  }
  // Bending is too soft by as much; what chords take from the slopes, with six_node, hides it.
  CHECK(std::abs(error[1]) < 0.013);
  CHECK(std::log2(std::abs(error[0] / error[1])) > 1.7);

  Plate loaded(grid(16, 16, false, 0.0), true, 0.1 * critical);
  solve::StaticOptions steps;
  steps.final_load_factor = 8.0;
  steps.initial_step = steps.max_step = 8.0;
  solve::LoadPath path(loaded.model, steps);
  REQUIRE(follow_from(state_of(loaded.a), path).completed);
  solve::Newton newton(loaded.model);
  const solve::EigenResult r = solve::buckling_modes(newton, loaded.model, loaded.a, 1);
  REQUIRE(!r.modes.empty());
  CHECK(r.modes[0].value == relative(10.0 * (1.0 + error[1])).epsilon(2e-3));
}

TEST_CASE("equal parts have equal modes, and none of them is missed") {
  constexpr int parts = 4;
  const mesh::MeshData one = grid(6, 6, false, 0.0);
  mesh::MeshData all;
  for (int k = 0; k < parts; ++k) {
    const auto first = static_cast<Index>(all.positions.size());
    for (const Vec3& x : one.positions) all.positions.emplace_back(x + static_cast<double>(k) * Vec3::UnitZ());
    for (const mesh::Triangle& t : one.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  Plate single(one, true), several(all, true);
  const solve::EigenResult of_one = solve::vibration_modes(single.model, single.a, 6, Mass::lumped);
  for (const int count : {parts + 1, 2 * parts + 1, 3 * parts + 2}) {
    CAPTURE(count);
    const solve::EigenResult found = solve::vibration_modes(several.model, several.a, count, Mass::lumped);
    CHECK(found.missed == 0);
    REQUIRE(found.modes.size() == static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < found.modes.size(); ++i)
      CHECK(found.modes[i].value == relative(of_one.modes[i / parts].value).epsilon(1e-8));
  }
  Plate pressed(one, true, 1.0), all_pressed(all, true, 1.0);
  const auto buckling = [](Plate& p, int count) {
    solve::Newton newton(p.model);
    return solve::buckling_modes(newton, p.model, p.a, count);
  };
  const solve::EigenResult load_of_one = buckling(pressed, 3), loads = buckling(all_pressed, 2 * parts + 1);
  CHECK(loads.missed == 0);
  REQUIRE(loads.modes.size() == 2 * parts + 1);
  for (std::size_t i = 0; i < loads.modes.size(); ++i)
    CHECK(loads.modes[i].value == relative(load_of_one.modes[i / parts].value).epsilon(1e-7));
}

TEST_CASE("what has no modes is refused with the reason") {
  Plate unloaded(grid(4, 4, false, 0.0), true);
  solve::Newton newton(unloaded.model);
  CHECK_THROWS_AS((void)solve::buckling_modes(newton, unloaded.model, unloaded.a, 1), UserError);
  system::ModelInput in = Plate::input(true, 0.0);
  in.materials = {isotropic(2e9, 0.3, thickness, 0.0)};
  system::Model weightless(PETSC_COMM_WORLD, unloaded.mesh, in);
  petsc::VecHandle a = weightless.dofs().create_vector();
  CHECK_THROWS_AS((void)solve::vibration_modes(weightless, a, 1, Mass::lumped), UserError);
}

}  // namespace test_eigen
