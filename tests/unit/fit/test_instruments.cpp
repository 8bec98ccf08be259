// Closed forms of the instruments against what the solver has.
#include "fit/instruments.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "../test_following.hpp"
#include "../test_model_kit.hpp"
#include "energy/curvature.hpp"
#include "energy/membrane.hpp"
#include "energy/yarn_friction.hpp"
#include "fit/heart_loop.hpp"
#include "input/fabric.hpp"
#include "solve/load_path.hpp"

namespace test_instruments {

using namespace voile;
using namespace voile::testing;

namespace {

using fit::Direction;
using fit::Kind;
using fit::Parameter;

constexpr double degree = std::numbers::pi / 180.0;

fit::Values fabric() {
  fit::Values v = fit::ordinary_values();
  at(v, Parameter::areal_density) = 0.168;
  at(v, Parameter::bending_warp) = 5.56e-6;
  at(v, Parameter::bending_weft) = 5.02e-6;
  at(v, Parameter::bending_twist) = 2.64e-6;
  return v;
}

/// Angle by which the chord of a strip of length 1 falls under its weight, as the solver has it.
double chord_angle(double load, int cells) {
  mesh::MeshData d = grid(cells, 2, false, 0.0);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.05 * x[1], 0.0); }));
  constexpr double bending = 1e-5;
  system::ModelInput in;
  energy::Material m = isotropic(1e5, 0.0, 0.01, 1.0);
  m.bending = bending * Mat3(Vec3(1.0, 1.0, 0.5).asDiagonal());
  m.direction = Vec3::UnitX();
  m.areal_density = 1.0;
  in.supports = {support("left", system::Support::Kind::clamped)};
  in.materials = {m};
  in.loads = {testing::load(system::Load::Kind::gravity, "", Vec3(0.0, 0.0, -load * bending))};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector();
  solve::StaticOptions options;
  options.initial_step = options.max_step = 0.1;
  solve::LoadPath path(model, options);
  REQUIRE(follow_from(state_of(a), path).completed);
  const std::vector<Vec3> u = per_vertex(model, a);
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.positions()[v][0] > 1.0 - 1e-9) return std::atan2(-u[v][2], 1.0 + u[v][0]);
  return 0.0;
}

}  // namespace

TEST_CASE("a cantilever falls to the angle of the instrument under the load that the elastica has") {
  CHECK(fit::cantilever_load(41.5 * degree) == relative(8.0043).epsilon(2e-5));
  CHECK(std::cbrt(fit::cantilever_load(43.0 * degree)) == relative(2.0422).epsilon(1e-4));
  // H/W of heavy elasticas with w l^3/D = 1 and 100.
  CHECK(fit::cantilever_load(std::atan(0.124562)) == relative(1.0).epsilon(1e-4));
  CHECK(fit::cantilever_load(std::atan(5.888105)) == relative(100.0).epsilon(1e-4));
  const double angle = chord_angle(fit::cantilever_load(41.5 * degree), 40);
  if (mpi::rank(PETSC_COMM_WORLD) == 0) CHECK(angle == relative(41.5 * degree).epsilon(5e-3));
}

/// Half of a heart loop from its lowest point, with the curvature and the force there: angle and place of its upper end.
Eigen::Vector3d shot(double load, double curvature, double force) {
  constexpr int steps = 400;
  constexpr double h = 0.5 / steps;
  const auto rate = [&](double s, const Eigen::Vector4d& p) {
    const double c = std::cos(p[0]), sine = std::sin(p[0]);
    return Eigen::Vector4d(p[1], force * sine - load * s * c, c, sine);
  };
  Eigen::Vector4d p(0.0, curvature, 0.0, 0.0);
  for (int i = 0; i < steps; ++i) {
    const double s = i * h;
    const Eigen::Vector4d a = rate(s, p), b = rate(s + 0.5 * h, p + 0.5 * h * a),
                          c = rate(s + 0.5 * h, p + 0.5 * h * b), d = rate(s + h, p + h * c);
    p += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
  }
  return {p[0], p[2], p[3]};
}

TEST_CASE(
    "a heart loop is as high as an elastica that is shot from its lowest point, and Peirce's formula is near it") {
  struct Start {
    double load, curvature, force;
  };
  for (const Start& s : {Start{10.0, 5.1960, 33.7379}, Start{100.0, 6.0141, 22.4739}, Start{600.0, 10.0238, -7.4233}}) {
    const Eigen::Vector3d end = shot(s.load, s.curvature, s.force);
    CHECK(end[0] == relative(1.5 * std::numbers::pi).epsilon(1e-3));
    CHECK(std::abs(end[1]) < 1e-4);
    CHECK(fit::heart_height(s.load) == relative(end[2]).epsilon(2e-4));
  }
  // runs/drape/loops
  CHECK(fit::heart_height(1000.0) == relative(0.34849).epsilon(1e-4));
  CHECK(fit::heart_height(3000.0) == relative(0.40918).epsilon(1e-4));
  CHECK(fit::heart_height(1e-6) == relative(0.13386).epsilon(1e-4));
  CHECK(fit::heart_height(1e5) > 0.46);
  for (const double load : {1.0, 20.0, 250.0, 2500.0})
    CHECK(fit::heart_load(fit::heart_height(load)) == relative(load).epsilon(1e-6));
  CHECK(std::cbrt(30.0) * fit::peirce_length(fit::heart_height(30.0)) == relative(1.0).epsilon(0.005));
  CHECK(std::cbrt(300.0) * fit::peirce_length(fit::heart_height(300.0)) == relative(1.0404).epsilon(0.001));
  fit::Values v = fabric();
  at(v, Parameter::loop_length) = 0.1;
  const double load = fit::gravity * 0.168 * 1e-3 / 5.56e-6;
  CHECK(fit::Instrument{Kind::heart_loop, Parameter::areal_density, Direction::warp}.read(v) ==
        relative(0.1 * fit::heart_height(load)).epsilon(1e-9));
}

TEST_CASE("bending lengths of warp, weft and bias") {
  const fit::Values v = fabric();
  const auto read = [&](Kind kind, Direction d) {
    return fit::Instrument{kind, Parameter::areal_density, d, 41.5 * degree}.read(v);
  };
  CHECK(read(Kind::bending_length, Direction::warp) == relative(15.0e-3).epsilon(1e-3));
  CHECK(read(Kind::bending_length, Direction::weft) == relative(14.5e-3).epsilon(1e-3));
  CHECK(read(Kind::rigidity, Direction::bias) == relative(0.25 * (5.56e-6 + 5.02e-6) + 2.64e-6));
  // Twice, but for 0.05 % of Peirce's formula and that of g.
  CHECK(read(Kind::overhang, Direction::warp) ==
        relative(2.0 * read(Kind::bending_length, Direction::warp)).epsilon(1e-3));
}

TEST_CASE("tension of a linear law, its work and linearity") {
  fit::Values v = fabric();
  at(v, Parameter::membrane_warp) = 2000.0;
  const auto read = [&](Kind kind) {
    return fit::Instrument{kind, Parameter::areal_density, Direction::warp, 0.0, 490.0, true}.read(v);
  };
  const double x = read(Kind::extension), e = x + 0.5 * x * x;
  CHECK(2000.0 * e * (1.0 + x) == relative(490.0).epsilon(1e-12));
  CHECK(read(Kind::work) == relative(1000.0 * e * e).epsilon(1e-12));
  CHECK(read(Kind::linearity) == relative(2.0 * read(Kind::work) / (490.0 * x)).epsilon(1e-12));
}

TEST_CASE("a bending loop is that of a triangle of the solver") {
  const mesh::SurfaceMesh mesh(square(Pattern::union_jack, 2));
  const mesh::PatchMesh patches(mesh, {});
  constexpr double width = 0.25, spread = 0.5, unit = 1e-6;  // so little that normals stay
  energy::Material m = isotropic(100.0, 0.3, 0.1);
  m.direction = Vec3::UnitX();
  m.friction.sliders = energy::sliders_of(Vec3(width, 0.0, 0.0), spread * unit, 1);
  const std::vector<energy::Material> materials{m};
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), {});
  energy::CurvatureBuilder builder(sheet);
  energy::YarnFrictionTerm term(sheet);
  const energy::BendingElement bending = energy::make_bending_element(sheet, 0, builder.build(0));
  term.add(sheet, 0, bending, bending.points, true);
  const fit::Loop loop = fit::bending_loop(0.7, width, spread);
  const std::vector<double> course{0.1, 0.4, 1.0, 0.8, 0.2, -0.5, -1.0, -0.9, 0.3, 1.0};
  const std::vector<double> found = loop.forces(course, false);
  for (std::size_t i = 0; i < course.size(); ++i) {
    std::vector<Vec3> x = mesh.positions(), u(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) {
      u[v] = Vec3(0.0, 0.0, 0.5 * unit * course[i] * x[v][0] * x[v][0]);
      x[v] += u[v];
    }
    const energy::Configuration c{x.data(), u.data()};
    CHECK(found[i] - 0.7 * course[i] == relative(term.moment(0, c)[0]).epsilon(1e-9));
    term.end_step(c);
  }
  // From the turn on, what went before does not count.
  const std::vector<double> rest(course.begin() + 2, course.end());
  const std::vector<double> again = loop.forces(rest, true);
  for (std::size_t i = 0; i < rest.size(); ++i) CHECK(again[i] == relative(found[i + 2]).epsilon(1e-12));
}

TEST_CASE("a shear loop is that of a membrane of the solver, with the slope and the widths of KES") {
  constexpr double g = 40.0, hg = 0.8, hg5 = 2.0, spread = 0.4 * degree;
  const fit::Loop loop = fit::shear_loop(g, hg, hg5, spread);
  const auto branches = [&](double angle) {
    const double e = std::sin(angle);
    const std::vector<double> f = loop.forces({0.14, -0.14, e, 0.14, e}, true);
    return std::pair{f[2] * std::cos(angle), f[4] * std::cos(angle)};
  };
  for (const auto& [angle, width] : {std::pair{0.5, hg}, std::pair{5.0, hg5}}) {
    const auto [up, down] = branches(angle * degree);
    CHECK(up - down == relative(width).epsilon(1e-9));
  }
  CHECK((branches(0.12).first / std::cos(0.12) - branches(0.06).first / std::cos(0.06)) /
            (std::sin(0.12) - std::sin(0.06)) ==
        relative(g).epsilon(1e-9));

  input::Fabric f;
  f.membrane_warp = f.membrane_weft = 1e4;
  f.membrane_shear = g;
  f.shear_hysteresis = hg;
  f.shear_hysteresis_5 = hg5;
  f.shear_hysteresis_spread = spread;
  energy::Material m = isotropic(100.0, 0.0, 0.1);
  m.membrane = input::membrane_stiffness(f, true);
  m.direction = Vec3::UnitX();
  m.yarns = input::yarn_law(f, true);
  const std::vector<energy::Material> materials{m};
  const mesh::SurfaceMesh mesh(square(Pattern::union_jack, 2));
  const mesh::PatchMesh patches(mesh, {});
  energy::ElementOptions plain;
  plain.membrane = energy::MembraneOperator::six_node;
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), plain);
  energy::MembraneTerm term(sheet);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    term.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), true);
  const std::vector<double> course{0.002, 0.05, 0.12, 0.1, -0.01, -0.12, 0.0, 0.08};
  const std::vector<double> found = loop.forces(course, false);
  for (std::size_t i = 0; i < course.size(); ++i) {
    std::vector<Vec3> x = mesh.positions(), u(x.size()), force(x.size(), Vec3::Zero());
    const double e = course[i], stay = std::sqrt(1.0 - e * e);
    for (std::size_t v = 0; v < x.size(); ++v) {
      const Vec3 p = x[v];
      x[v] = Vec3(p[0] + e * p[1], stay * p[1], 0.0);  // yarns keep their length
      u[v] = x[v] - p;
    }
    const energy::Configuration c{x.data(), u.data()};
    (void)term.add_gradients(c, force.data());
    double work = 0.0;
    for (std::size_t v = 0; v < x.size(); ++v) work += force[v].dot(mesh.positions()[v][1] * Vec3(1.0, -e / stay, 0.0));
    CHECK(found[i] == relative(work).epsilon(1e-9));
    term.end_step(c);
  }
}

}  // namespace test_instruments
