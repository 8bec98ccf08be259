// Friction of yarns that bend: derivatives, loops, what they take, and closed forms of strips.
#include "energy/yarn_friction.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "../test_following.hpp"
#include "../test_model_kit.hpp"
#include "solve/load_path.hpp"
#include "solve/newton.hpp"
#include "voile/errors.hpp"

namespace test_yarn_friction {

using namespace voile;
using namespace voile::testing;

namespace {

using Kind = system::Support::Kind;

/// An orthotropic sheet whose yarns lie at an angle to its first axis.
system::ModelInput rubbing(const Vec3& loop, double spread, int sliders) {
  system::ModelInput in;
  energy::Material m = isotropic(100.0, 0.3, 0.1, 1.0);
  m.direction = Vec3(1.0, 0.2, 0.0);
  m.friction.warp_angle = 0.4;
  m.friction.sliders = energy::sliders_of(loop, spread, sliders);
  in.materials = {m};
  return in;
}

void add_scaled(const system::Model& model, Vec a, double size, const std::function<Vec3(Index)>& u) {
  set_displacement(model, a, [&](Index v) { return Vec3(size * u(v)); });
}

/// A strip of length 1 along x, one material axis along it, without Poisson effect.
struct Strip {
  static constexpr double width = 0.05, bending = 1e-5;
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  Strip(int cells, double loop, double spread, double weight)
      : mesh(data(cells)),
        model(PETSC_COMM_WORLD, mesh, input(loop, spread, weight)),
        a(model.dofs().create_vector()) {}
  static mesh::MeshData data(int cells) {
    mesh::MeshData d = grid(cells, 2, false, 0.0);
    add_square_groups(d);
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], width * x[1], 0.0); });
  }
  static system::ModelInput input(double loop, double spread, double weight) {
    system::ModelInput in;
    energy::Material m = isotropic(1e5, 0.0, 0.01);
    m.bending = bending * Mat3(Vec3(1.0, 1.0, 0.5).asDiagonal());
    m.direction = Vec3::UnitX();
    m.friction.sliders = energy::sliders_of(Vec3(loop, loop, 0.0), spread, 1);
    in.supports = {support("left", Kind::clamped)};
    m.areal_density = 1.0;
    in.materials = {m};
    in.loads = {load(system::Load::Kind::gravity, "", Vec3(0.0, 0.0, -weight))};
    return in;
  }
  /// Mean sag of the free end.
  [[nodiscard]] double sag() const {
    const std::vector<Vec3> u = per_vertex(model, a);
    double sum = 0.0;
    int count = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.positions()[v][0] > 1.0 - 1e-9) sum -= u[v][2], ++count;
    return sum / count;
  }
  /// From the load factor in force to another one, in steps.
  void load_to(double from, double to, double step) {
    solve::StaticOptions options;
    options.initial_step = options.max_step = step;
    options.final_load_factor = to;
    solve::LoadPath path(model, options);
    system::State start = state_of(a);
    start.load_factor = from;
    REQUIRE(follow_from(std::move(start), path).completed);
  }
};

}  // namespace

TEST_CASE("friction of yarns is the gradient of its increment, with its tangent, sticking and slipping") {
  for (const bool curved : {false, true})
    for (const int sliders : {1, 3}) {
      CAPTURE(curved);
      CAPTURE(sliders);
      const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 6), [&](const Vec3& x) {
        return curved ? Vec3(x[0], x[1], 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1]) : x;
      }));
      system::ModelInput in = rubbing(Vec3(0.6, 0.4, 0.2), 1.0, sliders);
      in.materials[0].membrane *= 1e-3;
      in.materials[0].bending *= 1e-3;  // so that friction is what counts
      in.supports = {support("left", Kind::clamped), support("bottom", Kind::symmetry)};
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      const petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
      set_displacement(model, d, noise(1.0, 5));
      model.dofs().clear_fixed(d);
      for (const double size : {0.002, 0.02}) {  // few slip, then most
        add_scaled(model, a, size, noise(1.0, 11));
        model.dofs().clear_fixed(a);
        check_potential(model, a, d, 1e-8);
        model.potential().end_step(a);
        add_scaled(model, a, 0.7 * size, noise(1.0, 13));
        model.dofs().clear_fixed(a);
        check_potential(model, a, d, 1e-8);
      }
      CHECK(model.potential().yarn_losses() > 0.0);
    }
}

TEST_CASE("the positive tangent of friction has no negative part") {
  if (mpi::size(PETSC_COMM_WORLD) > 1) return;
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 4));
  system::ModelInput in = rubbing(Vec3(6.0, 4.0, 2.0), 1.0, 2);
  in.materials[0].membrane *= 1e-6;
  in.materials[0].bending *= 1e-6;
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector(), x = model.dofs().create_vector(),
                         kx = model.dofs().create_vector();
  set_displacement(model, a, noise(0.05, 7));
  model.assemble_tangent(a, {.kind = energy::Tangent::positive});
  for (unsigned seed = 0; seed < 50; ++seed) {
    set_displacement(model, x, noise(1.0, seed));
    VOILE_PETSC(MatMult(model.tangent().matrix(), x, kx));
    CHECK(dot(x, kx) > -1e-9 * norm(kx) * norm(x));
  }
}

TEST_CASE("a closed loop encloses what friction takes, and monotone steps may be as long as they like") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 3));
  constexpr double small = 1e-6;  // of curvatures: turns do not count
  const auto bent = [&](Index v) {
    const Vec3 x = mesh.positions()[v];
    return Vec3(0.0, 0.0, 0.5 * small * (x[0] * x[0] + 0.4 * x[1] * x[1] + 0.6 * x[0] * x[1]));
  };
  for (const int sliders : {1, 4}) {
    CAPTURE(sliders);
    system::Model model(PETSC_COMM_WORLD, mesh, rubbing(Vec3(0.2, 0.1, 0.05), 0.25 * small, sliders));
    const petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector(),
                           before = model.dofs().create_vector(), forces = model.dofs().create_vector();
    double now = 0.0, work = 0.0, lost = 0.0;
    const auto go = [&](double to, int steps) {
      const double from = now;
      for (int i = 1; i <= steps; ++i) {
        VOILE_PETSC(VecCopy(a, before));
        model.residual(a, forces);
        now = from + (to - from) * i / steps;
        add_scaled(model, a, now, bent);
        model.residual(a, r);
        VOILE_PETSC(VecAXPY(forces, 1.0, r));
        VOILE_PETSC(VecAYPX(before, -1.0, a));
        work += 0.5 * dot(forces, before);
        lost += model.potential().yarn_loss(a);
        model.potential().end_step(a);
      }
    };
    // Long steps lose the same and end with the same slips.
    go(1.0, 1);
    const double once = lost;
    const std::vector<double> slips = model.potential().slips();
    system::Model other(PETSC_COMM_WORLD, mesh, rubbing(Vec3(0.2, 0.1, 0.05), 0.25 * small, sliders));
    for (int i = 1; i <= 7; ++i) {
      add_scaled(other, a, i / 7.0, bent);
      other.potential().end_step(a);
    }
    const std::vector<double> same = other.potential().slips();
    for (std::size_t i = 1; i < slips.size(); ++i) CHECK(std::abs(slips[i] - same[i]) < 1e-10 * small);
    CHECK(other.potential().yarn_losses() == relative(once).epsilon(1e-10));
    // The trapezoid rule errs only in the steps in which sliders begin to slip.
    work = lost = 0.0;
    const int steps = 1000;
    go(-1.0, steps);
    go(1.0, steps);
    CHECK(lost > 0.0);
    CHECK(work == relative(lost).epsilon(1e-5));
    const double stored = system::energies(model, a).bending;
    go(-1.0, 3);
    go(1.0, 3);
    CHECK(system::energies(model, a).bending == relative(stored).epsilon(1e-9));
  }
}

TEST_CASE("the loop of one triangle has the area that its friction takes") {
  const mesh::SurfaceMesh mesh(square(Pattern::union_jack, 2));
  const mesh::PatchMesh patches(mesh, {});
  energy::Material m = isotropic(100.0, 0.3, 0.1);
  m.direction = Vec3::UnitX();
  constexpr double hb = 0.125, spread = 0.5, unit = 1e-6;  // so little that normals stay
  m.friction.sliders = energy::sliders_of(Vec3(2.0 * hb, 0.0, 0.0), spread * unit, 1);
  const std::vector<energy::Material> materials{m};
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), {});
  energy::CurvatureBuilder builder(sheet);
  energy::YarnFrictionTerm loop(sheet);
  const energy::BendingElement bending = energy::make_bending_element(sheet, 0, builder.build(0));
  loop.add(sheet, 0, bending, bending.points, true);
  const auto places = static_cast<std::size_t>(mesh.vertex_count());
  std::vector<Vec3> x(places), u(places), before(places), f(places), f_before(places, Vec3::Zero());
  double area = 0.0, lost = 0.0, kappa_before = 0.0, moment_before = 0.0, work = 0.0;
  const auto at = [&](double kappa) {
    for (std::size_t v = 0; v < places; ++v) {
      const Vec3& p = mesh.positions()[v];
      u[v] = Vec3(0.0, 0.0, 0.5 * kappa * p[0] * p[0]);
      x[v] = p + u[v];
    }
    return energy::Configuration{x.data(), u.data()};
  };
  const auto step = [&](double kappa, bool counts) {
    const energy::Configuration c = at(unit * kappa);
    std::fill(f.begin(), f.end(), Vec3::Zero());
    (void)loop.add_gradients(c, f.data());
    const double k = loop.curvature(0, c)[0], moment = loop.moment(0, c)[0];
    if (counts) {
      lost += loop.lost(c);
      area += 0.5 * mesh.area(0) * (moment + moment_before) * (k - kappa_before);
      for (std::size_t v = 0; v < places; ++v) work += 0.5 * (f[v] + f_before[v]).dot(u[v] - before[v]);
    }
    loop.end_step(c);
    kappa_before = k;
    moment_before = moment;
    before = u;
    f_before = f;
    return moment;
  };
  (void)step(0.25, false);
  CHECK(step(1.0, false) == relative(hb).epsilon(1e-10));
  for (int turn = 0; turn < 3; ++turn) {
    CHECK(step(0.5, true) == relative(-hb).epsilon(1e-6));
    CHECK(step(-1.0, true) == relative(-hb).epsilon(1e-10));
    CHECK(step(-0.5, true) == relative(hb).epsilon(1e-6));
    CHECK(step(1.0, true) == relative(hb).epsilon(1e-10));
  }
  CHECK(area == relative(lost).epsilon(1e-10));
  CHECK(work == relative(lost).epsilon(1e-10));
  // 2HB times the way between the kinks and the turning points.
  CHECK(lost == relative(3.0 * mesh.area(0) * 2.0 * hb * 1.5 * unit).epsilon(1e-6));
}

TEST_CASE("a strip that was bent far and let go keeps the curvature HB/B") {
  constexpr double hb = 2e-6;
  Strip strip(40, 2.0 * hb, 0.005, 0.0);
  constexpr double kappa = 8.0 * hb / Strip::bending / 2.0;
  set_displacement(strip.model, strip.a, [&](Index v) {
    const Vec3 x = strip.mesh.positions()[v];
    return Vec3(std::sin(kappa * x[0]) / kappa - x[0], 0.0, (1.0 - std::cos(kappa * x[0])) / kappa);
  });
  strip.model.potential().end_step(strip.a);
  solve::Newton newton(strip.model);
  // Without any load nothing is left that a residual could be small against: it has to be small against the start.
  const petsc::VecHandle r = strip.model.dofs().create_vector();
  strip.model.residual(strip.a, r);
  strip.model.dofs().clear_fixed(r);
  const double at_start = norm(r);
  (void)newton.step(strip.a);
  (void)newton.continuation(strip.a, 1000);
  strip.model.residual(strip.a, r);
  strip.model.dofs().clear_fixed(r);
  CHECK(norm(r) < 1e-8 * at_start);
  const system::TriangleFields fields = strip.model.triangle_fields(strip.a);
  double mean = 0.0, area = 0.0;
  for (std::size_t t = 0; 3 * t < fields.curvature.size(); ++t) {
    const double x = strip.mesh.positions()[strip.mesh.triangles()[t][0]][0];
    if (std::abs(x - 0.5) > 0.4) continue;  // the row at the clamp is half as long
    mean += strip.mesh.area(static_cast<Index>(t)) * fields.curvature[3 * t];
    area += strip.mesh.area(static_cast<Index>(t));
  }
  if (mpi::rank(PETSC_COMM_WORLD) == 0) CHECK(mean / area == relative(hb / Strip::bending).epsilon(5e-3));
}

TEST_CASE("a cantilever with friction sags as rigid-plastic theory has it, under growing and falling load") {
  constexpr double w = 2e-6, hb = 2e-7, b = Strip::bending;  // friction alone carries 0.45 of the length
  const double u2 = 2.0 * hb / w;
  Strip strip(80, 2.0 * hb, 0.001, w);
  strip.load_to(0.0, 1.0, 0.25);
  const double grown = w / (8.0 * b) * std::pow(1.0 - u2, 2);
  CHECK(strip.sag() == relative(grown).epsilon(2e-2));
  const double losses = strip.model.potential().yarn_losses();
  // Falling to a fifth: from u_r on the moment has turned round.
  constexpr double less = 0.2 * w;
  const double ur2 = 4.0 * hb / (w - less);
  strip.load_to(1.0, 0.2, 0.2);
  const double fallen = (w / 8.0 * (ur2 * ur2 - u2 * u2) - hb / 2.0 * (ur2 - u2) + less / 8.0 * (1.0 - ur2 * ur2) +
                         hb / 2.0 * (1.0 - ur2)) /
                        b;
  CHECK(strip.sag() == relative(fallen).epsilon(2e-2));
  CHECK(strip.model.potential().yarn_losses() > losses);
  CHECK(fallen > 0.6 * grown);  // elastic would be a fifth
}

TEST_CASE("friction of yarns, its slips and losses are the same on any number of ranks") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 7));
  system::ModelInput in = rubbing(Vec3(0.6, 0.4, 0.2), 1.0, 2);
  in.supports = {support("left", Kind::clamped)};
  system::Model model(PETSC_COMM_WORLD, mesh, in), alone(PETSC_COMM_SELF, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                         b = alone.dofs().create_vector(), g = alone.dofs().create_vector();
  set_displacement(model, a, noise(0.02, 9));
  set_displacement(alone, b, noise(0.02, 9));
  model.potential().end_step(a);
  alone.potential().end_step(b);
  set_displacement(model, a, noise(0.015, 10));
  set_displacement(alone, b, noise(0.015, 10));
  CHECK(model.potential().yarn_loss(a) == relative(alone.potential().yarn_loss(b)).epsilon(1e-11));
  CHECK(system::energies(model, a).bending == relative(system::energies(alone, b).bending).epsilon(1e-11));
  model.residual(a, f);
  alone.residual(b, g);
  CHECK(relative_difference(per_vertex(model, f), per_vertex(alone, g)) < 1e-11);
  // What was gathered goes back bit by bit, to another model too.
  const std::vector<double> slips = model.potential().slips();
  system::Model again(PETSC_COMM_WORLD, mesh, in);
  again.potential().restore_slips(slips);
  CHECK(again.potential().slips() == slips);
  CHECK(again.potential().yarn_loss(a) == relative(model.potential().yarn_loss(a)).epsilon(1e-14));
  CHECK_THROWS_AS(again.potential().restore_slips(std::vector<double>(7, 0.0)), UserError);
}

}  // namespace test_yarn_friction
