// Yarns that stiffen and rub in the plane: curves against their figures, derivatives, the loop of shear, ranks and restarts.
#include "energy/yarn_law.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "../test_model_kit.hpp"
#include "energy/curvature.hpp"
#include "energy/membrane.hpp"
#include "voile/errors.hpp"

namespace test_yarn_law {

using namespace voile;
using namespace voile::testing;

namespace {

using Kind = system::Support::Kind;

/// Area below a curve, exact where pieces between knots are polynomials.
double area_below(const energy::YarnCurve& c, double end) {
  double sum = 0.5 * c.tangent * end * end;
  for (const energy::YarnLaw::Knot& k : c.knots) sum += k.bend / 6.0 * std::pow(std::max(end - k.strain, 0.0), 3);
  return sum;
}

double tangent_of(const energy::YarnCurve& c, double strain) {
  double sum = c.tangent;
  for (const energy::YarnLaw::Knot& k : c.knots) sum += k.bend * std::max(strain - k.strain, 0.0);
  return sum;
}

/// Yarns at an angle to the first axis, which soften in tension along the weft; friction in shear.
energy::Material woven() {
  energy::Material m = isotropic(100.0, 0.2, 0.1, 1.0);
  m.direction = Vec3(1.0, 0.2, 0.0);
  m.yarns.warp_angle = 0.4;
  m.yarns.knots = {{{{0.001, 300.0}, {0.02, -300.0}}, {{0.0, -50.0}, {0.02, 50.0}}, {{0.005, 200.0}}}};
  m.yarns.stiffness = 8.0;
  m.yarns.limit = 0.02;
  m.yarns.rise = 0.5;
  return m;
}

system::ModelInput input_of(const energy::Material& m, energy::MembraneOperator kind) {
  system::ModelInput in;
  in.materials = {m};
  in.element.membrane = kind;
  in.supports = {support("left", Kind::clamped)};
  return in;
}

/// A square whose yarns, along its sides, are sheared and stretched as a whole.
struct Sheared {
  mesh::SurfaceMesh mesh{square(Pattern::union_jack, 2)};
  mesh::PatchMesh patches{mesh, {}};
  std::vector<energy::Material> materials;
  energy::Sheet sheet;
  energy::MembraneTerm term;
  std::vector<Vec3> x, u;

  explicit Sheared(const energy::YarnLaw& law)
      : materials{of(law)},
        sheet(patches, materials, energy::assign_materials(mesh, materials), plain()),
        term(sheet),
        x(mesh.positions()),
        u(x.size(), Vec3::Zero()) {
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      term.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), true);
  }
  static energy::ElementOptions plain() {
    energy::ElementOptions o;
    o.membrane = energy::MembraneOperator::six_node;
    return o;
  }
  static energy::Material of(const energy::YarnLaw& law) {
    energy::Material m = isotropic(100.0, 0.0, 0.1);
    m.direction = Vec3::UnitX();
    m.yarns = law;
    return m;
  }
  /// Of this shear 2 E12 with yarns of length 1.
  energy::Configuration at(double shear) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      const Vec3& p = mesh.positions()[v];
      x[v] = Vec3(p[0] + shear * p[1], std::sqrt(1.0 - shear * shear) * p[1], 0.0);
      u[v] = x[v] - p;
    }
    return {x.data(), u.data()};
  }
  /// Derivative of the energy per area by the shear, less that of A [N/m].
  double force(double shear) {
    const energy::Configuration c = at(shear);
    std::vector<Vec3> f(x.size(), Vec3::Zero());
    (void)term.add_gradients(c, f.data());
    double sum = 0.0;
    for (std::size_t v = 0; v < x.size(); ++v)
      sum += f[v].dot(mesh.positions()[v][1] * Vec3(1.0, -shear / std::sqrt(1.0 - shear * shear), 0.0));
    return sum - materials[0].membrane(2, 2) * shear;
  }
};

}  // namespace

TEST_CASE("a curve of LT, WT and EMT has its end, its area, its tangents") {
  const energy::YarnPoint end{0.045, 470.0};
  const double triangle = 0.5 * end.strain * end.force, secant = end.force / end.strain;
  for (const double lt : {0.25, 0.5, 0.62, 0.8, 0.95, 0.995}) {
    CAPTURE(lt);
    const energy::YarnCurve c = energy::yarn_curve(end, lt * triangle, 0.0);
    CHECK(energy::force_of(c, end.strain) == relative(end.force).epsilon(1e-12));
    CHECK(area_below(c, end.strain) == relative(lt * triangle).epsilon(1e-12));
    CHECK(c.tangent > 0.0);
    // That of b (exp(a x) - 1) with the same end and area.
    double a = 1e-3;
    for (double step = 20.0; step > 1e-13; step *= 0.5)
      while (2.0 * (1.0 / (a + step) - 1.0 / std::expm1(a + step)) > lt) a += step;
    CHECK(c.tangent == relative(secant * a / std::expm1(a)).epsilon(1e-6));
    for (int k = 0; k < 100; ++k) CHECK(tangent_of(c, (k + 1) * 1e-3) >= tangent_of(c, k * 1e-3) - 1e-9 * secant);
    CHECK(tangent_of(c, 2.0 * end.strain) == relative(tangent_of(c, end.strain)).epsilon(1e-12));
  }
  const energy::Interval fits = energy::tangents_of(end, 0.7 * triangle);
  CHECK(fits.least == relative(0.1 * secant));
  CHECK(fits.most == relative(0.7 * secant));
  const energy::YarnCurve c = energy::yarn_curve(end, 0.7 * triangle, 0.4 * secant);
  CHECK(c.tangent == 0.4 * secant);
  CHECK(energy::force_of(c, end.strain) == relative(end.force).epsilon(1e-12));
  CHECK(area_below(c, end.strain) == relative(0.7 * triangle).epsilon(1e-12));
}

TEST_CASE("a curve of points goes through them and rises") {
  const std::vector<energy::YarnPoint> points{{0.01, 5.0}, {0.012, 5.1}, {0.03, 60.0}, {0.05, 490.0}, {0.08, 491.0}};
  const energy::YarnCurve c = energy::yarn_curve(points);
  for (const energy::YarnPoint& p : points) CHECK(energy::force_of(c, p.strain) == relative(p.force).epsilon(1e-10));
  for (int k = 0; k < 1000; ++k) CHECK(tangent_of(c, k * 1e-4) > 0.0);
  const energy::YarnCurve line = energy::yarn_curve(std::vector<energy::YarnPoint>{{0.02, 10.0}, {0.05, 25.0}});
  for (const double e : {0.01, 0.03, 0.2}) CHECK(energy::force_of(line, e) == relative(500.0 * e).epsilon(1e-12));
}

TEST_CASE("stiffening and friction in the plane are the gradient of their energy, with its tangent") {
  using energy::MembraneOperator;
  for (const MembraneOperator kind :
       {MembraneOperator::cst, MembraneOperator::six_node, MembraneOperator::six_node_corrected})
    for (const double viscosity : {0.0, 0.5}) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(viscosity);
      const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 6), [&](const Vec3& x) {
        return Vec3(x[0], x[1], 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1]);
      }));
      system::Model model(PETSC_COMM_WORLD, mesh, input_of(woven(), kind));
      const petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
      set_displacement(model, d, noise(1.0, 5));
      model.dofs().clear_fixed(d);
      for (const double size : {0.0005, 0.005}) {  // some stick, most slip
        model.potential().start_step(a, viscosity);
        for (const unsigned seed : {11U, 13U}) {
          set_displacement(model, a, noise(size, seed));
          model.dofs().clear_fixed(a);
          check_potential(model, a, d, 1e-8);
          model.potential().end_step(a);
        }
      }
      CHECK(model.potential().yarn_losses() > 0.0);
    }
}

TEST_CASE("tension along the yarns is the curve") {
  energy::YarnLaw law;
  const energy::YarnCurve c = energy::yarn_curve({0.04, 400.0}, 5.0, 0.0);
  law.knots[0] = c.knots;
  Sheared s(law);
  for (const double e : {-0.03, 0.005, 0.02, 0.04, 0.06}) {
    const double stretch = std::sqrt(1.0 + 2.0 * e);
    for (std::size_t v = 0; v < s.x.size(); ++v) s.x[v][0] = stretch * s.mesh.positions()[v][0];
    std::vector<Vec3> f(s.x.size(), Vec3::Zero());
    (void)s.term.add_gradients({s.x.data(), s.u.data()}, f.data());
    double work = 0.0;
    for (std::size_t v = 0; v < s.x.size(); ++v) work += f[v][0] * s.mesh.positions()[v][0] / stretch;
    CHECK(work == relative(s.materials[0].membrane(0, 0) * e + energy::force_of(c, e) - c.tangent * e).epsilon(1e-11));
    CHECK(s.term.force(0, Vec3(e, 0.0, 0.0))[0] == relative(work).epsilon(1e-11));
  }
}

TEST_CASE("the loop of shear has its widths, and the area that friction takes") {
  energy::YarnLaw law;
  law.stiffness = 90.0;
  law.limit = 0.35;
  law.rise = 6.0;
  constexpr double most = 0.12;
  const double g = law.stiffness, h = law.rise;
  const double slip = (g * most - law.limit) / (g + h), limit = law.limit + h * slip;
  Sheared s(law);
  double lost = 0.0, area = 0.0, shear_before = 0.0, force_before = 0.0;
  const auto go = [&](double shear) {
    const double force = s.force(shear);
    lost += s.term.lost(s.at(shear));
    area += 0.5 * (force + force_before) * (shear - shear_before);
    s.term.end_step(s.at(shear));
    shear_before = shear;
    return force_before = force;
  };
  CHECK(go(0.5 * law.limit / g) == relative(0.5 * law.limit).epsilon(1e-10));
  CHECK(go(most) == relative(limit).epsilon(1e-10));
  CHECK(s.term.slip(0) == relative(slip).epsilon(1e-12));
  // Width at shears between: H at the slips of both branches.
  const auto branch = [&](double shear, double side) {
    const double top = g * shear - side * law.limit;
    return side * (law.limit + h * std::abs(top / (g + side * std::copysign(h, top))));
  };
  lost = area = 0.0;
  for (int turn = 0; turn < 3; ++turn)
    for (const double side : {1.0, -1.0}) {
      CHECK(go(side * (slip - limit / g)) == relative(-side * limit).epsilon(1e-9));
      CHECK(go(side * 0.03) == relative(branch(side * 0.03, -side)).epsilon(1e-10));
      (void)go(-side * law.limit / g);  // no slip: the limit grows again
      CHECK(go(-side * 0.05) == relative(branch(-side * 0.05, -side)).epsilon(1e-10));
      CHECK(go(-side * most) == relative(-side * limit).epsilon(1e-10));
    }
  CHECK(area == relative(lost).epsilon(1e-10));
  CHECK(lost == relative(3.0 * 4.0 * slip * (law.limit + 0.5 * h * slip)).epsilon(1e-10));
}

TEST_CASE("what yarns lose, and where some strain would cost nothing") {
  energy::Material m = woven();
  const Mat3 a = energy::rotated_stiffness(m.membrane, -m.yarns.warp_angle);
  CHECK(energy::is_stable(a, m.yarns));
  m.yarns.rise = m.yarns.stiffness;
  CHECK(!energy::is_stable(a, m.yarns));
  m = woven();
  m.yarns.knots[1][0].bend = -1000.0;  // 20 of 10.4 is lost
  CHECK(!energy::is_stable(a, m.yarns));
  m = woven();
  m.yarns.knots[1].pop_back();  // softens for ever
  CHECK(!energy::is_stable(a, m.yarns));
}

TEST_CASE("slips of shear are the same on any number of ranks, and go back into another model") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 7));
  system::ModelInput in = input_of(woven(), energy::MembraneOperator::six_node_corrected);
  in.materials[0].friction = {0.4, energy::sliders_of(Vec3(0.6, 0.4, 0.2), 1.0, 2)};
  system::Model model(PETSC_COMM_WORLD, mesh, in), alone(PETSC_COMM_SELF, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                         b = alone.dofs().create_vector(), g = alone.dofs().create_vector();
  for (const unsigned seed : {9U, 10U}) {
    set_displacement(model, a, noise(0.01, seed));
    set_displacement(alone, b, noise(0.01, seed));
    CHECK(model.potential().yarn_loss(a) == relative(alone.potential().yarn_loss(b)).epsilon(1e-11));
    model.potential().end_step(a);
    alone.potential().end_step(b);
  }
  set_displacement(model, a, noise(0.008, 12));
  set_displacement(alone, b, noise(0.008, 12));
  CHECK(system::energies(model, a).membrane == relative(system::energies(alone, b).membrane).epsilon(1e-11));
  model.residual(a, f);
  alone.residual(b, g);
  CHECK(relative_difference(per_vertex(model, f), per_vertex(alone, g)) < 1e-11);
  const std::vector<double> slips = model.potential().slips();
  system::Model again(PETSC_COMM_WORLD, mesh, in);
  again.potential().restore_slips(slips);
  CHECK(again.potential().slips() == slips);
  CHECK(again.potential().yarn_loss(a) == relative(model.potential().yarn_loss(a)).epsilon(1e-14));
  if (mpi::rank(PETSC_COMM_WORLD) == 0) CHECK(slips.size() == 1 + 7 * static_cast<std::size_t>(mesh.triangle_count()));
}

TEST_CASE("force and tangent that yarns add are those of their curves, in turned axes") {
  energy::YarnLaw law;
  law.warp_angle = 0.6;
  law.knots = {
      std::vector<energy::YarnLaw::Knot>{{0.0, 4e4}, {0.01, -3e4}}, {{0.002, 1e4}}, {{0.0, 500.0}, {0.03, 2e3}}};
  const Mat3 turn = energy::turned_strain(law.warp_angle);
  for (const Vec3& yarns : {Vec3(0.02, 0.006, 0.05), Vec3(0.004, -0.01, -0.02), Vec3(-0.01, 0.03, 0.01)}) {
    const Vec3 strain = turn.inverse() * yarns;
    // Work in both axes is the same: N.E = N'.E' of the curves along the yarns.
    double work = 0.0;
    for (int r = 0; r < 3; ++r)
      work += yarns[r] * std::copysign(1.0, r < 2 ? 1.0 : yarns[r]) *
              energy::force_of({0.0, law.knots[static_cast<std::size_t>(r)]}, r < 2 ? yarns[r] : std::abs(yarns[r]));
    CHECK(energy::added_force(law, strain).dot(strain) == relative(work));
    const Mat3 tangent = energy::added_tangent(law, strain);
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = 1e-7 * Vec3::Unit(k);
      const Vec3 slope = (energy::added_force(law, strain + step) - energy::added_force(law, strain - step)) / 2e-7;
      CHECK((slope - tangent.col(k)).norm() < 1e-6 * tangent.norm());
    }
  }
}

}  // namespace test_yarn_law
