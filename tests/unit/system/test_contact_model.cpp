// Contact as a term of a distributed model: its tangent, the same contacts on any number of ranks, impact, moving
// obstacles.
#include <doctest/doctest.h>

#include "system/contact.hpp"
#include "test_contact_model_kit.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"

namespace test_contact_model {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::contacts;

TEST_CASE("contact in a model: the tangent is the derivative of the residual, that of the energy") {
  system::ModelInput in = input({plane(-0.015), ball(Vec3(0.5, 0.5, 0.3), 0.25)}, 0.03);
  in.supports = {support("sheet0", SupportKind::displacement)};
  in.supports[0].components = {true, false, false};  // fixed rows and columns
  for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::six_node_corrected}) {
    CAPTURE(static_cast<int>(membrane));
    in.element.membrane = membrane;
    Problem p(sheets(2, 6, 0.025), in);
    const int before = p.model.tangent().pattern_version();
    set_displacement(p.model, p.u, noise(2e-3, 1));
    p.model.conditions().enforce(p.u);
    petsc::VecHandle r = p.model.dofs().create_vector(), up = p.model.dofs().create_vector(),
                     down = p.model.dofs().create_vector(), w = p.model.dofs().create_vector(),
                     kw = p.model.dofs().create_vector(), x = p.model.dofs().create_vector();
    system::TangentRequest request;
    request.exact_contact = true;
    p.model.assemble_tangent(p.u, request);
    CHECK(p.model.tangent().pattern_version() == before + 1);
    set_displacement(p.model, w, noise(1.0, 2));
    p.model.dofs().clear_fixed(w);
    VOILE_PETSC(MatMult(p.model.tangent().matrix(), w, kw));
    const double h = 1e-8;
    VOILE_PETSC(VecWAXPY(x, h, w, p.u));
    p.model.residual(x, up);
    const double energy_up = p.model.energy(x);
    VOILE_PETSC(VecWAXPY(x, -h, w, p.u));
    p.model.residual(x, down);
    const double energy_down = p.model.energy(x);
    VOILE_PETSC(VecAXPY(up, -1.0, down));
    VOILE_PETSC(VecScale(up, 0.5 / h));
    p.model.dofs().clear_fixed(up);
    p.model.dofs().clear_fixed(kw);
    VOILE_PETSC(VecAXPY(up, -1.0, kw));
    CHECK(norm(up) < 1e-5 * norm(kw));
    p.model.residual(p.u, r);
    p.model.dofs().clear_fixed(r);
    CHECK((energy_up - energy_down) / (2.0 * h) == relative(dot(r, w)).epsilon(1e-6));
    // The constant bending stiffness was copied, not assembled, into the larger pattern.
    p.model.assemble_tangent(p.u, request);
    CHECK(p.model.tangent().pattern_version() == before + 1);
  }
}

TEST_CASE("contact in a model: pairs, energy and forces are those of one rank") {
  Problem p(sheets(3, 7, 0.025), input({ball(Vec3(0.5, 0.5, -0.29), 0.27)}, 0.03));
  set_displacement(p.model, p.u, noise(4e-3, 5));
  const contact::Surface& s = p.model.contact()->scene().set().surface();
  ContactSet alone(s, {}, {0.03, 1e4, 1e-3}, std::vector<char>(static_cast<std::size_t>(s.sheet_points), 1));
  const std::vector<Vec3> x = p.model.contact()->scene().positions(p.u);
  (void)alone.cover(x, x);
  const system::ContactReport report = system::report(p.model.contact()->scene(), p.u);
  const contact::ContactState state = alone.state(x);
  CHECK(report.pairs == state.pairs);
  CHECK(report.pairs > 100);
  CHECK(report.gap == state.gap);
  CHECK(p.model.contact()->energy(p.u) == relative(alone.energy(x)).epsilon(1e-12));
  petsc::VecHandle f = p.model.dofs().create_vector();
  p.model.contact()->add_gradient(p.u, f);
  const std::vector<Vec3> forces = per_vertex(p.model, f);
  std::vector<Vec3> wanted(forces.size(), Vec3::Zero());
  alone.add_gradient(x, wanted);
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    difference = std::max(difference, (forces[i] - wanted[i]).norm());
    size = std::max(size, wanted[i].norm());
  }
  CHECK(difference < 1e-12 * size);
}

namespace {

/// Something wide apart and close together in turns, a mesh as obstacle among it, so that ranks see others' points for a
/// while.
system::ModelInput among_obstacles() {
  Obstacle table;
  table.name = "table";
  table.shape = Obstacle::Shape::mesh;
  table.points = {Vec3(-1.0, -1.0, -0.1), Vec3(3.0, -1.0, -0.1), Vec3(0.0, 3.0, -0.1)};
  table.triangles = {{0, 1, 2}};
  table.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, 0.2 * t); };
  system::ModelInput in = input({table, ball(Vec3(0.3, 0.3, -0.4), 0.25)}, 0.03);
  in.contact.friction = 0.3;
  return in;
}

void check_same(const std::vector<Vec3>& forces, const std::vector<Vec3>& wanted) {
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    difference = std::max(difference, (forces[i] - wanted[i]).norm());
    size = std::max(size, wanted[i].norm());
  }
  CHECK(difference <= 1e-9 * size);
}

/// `alone`: the same contacts on one rank, at positions x.
void check_report(const system::ContactReport& report, const ContactSet& alone, const std::vector<Vec3>& x) {
  const contact::ContactState state = alone.state(x);
  CHECK(report.pairs == state.pairs);
  CHECK(report.gap == state.gap);
  const long ranks = mpi::size(PETSC_COMM_WORLD);
  CHECK(report.most_pairs <= report.pairs);
  CHECK(report.most_pairs * ranks >= report.pairs);
  CHECK(report.candidates >= report.pairs);
  CHECK(report.candidates <= 2 * ranks * static_cast<long>(alone.candidates().pairs().size()));
  CHECK(report.most_candidates * ranks >= report.candidates);
  CHECK((report.most_candidates == report.candidates) == (ranks == 1));
}

}  // namespace

TEST_CASE("pairs that come and go while sheets pass each other are those of one rank") {
  Problem p(sheets(4, 7, 0.025), among_obstacles());
  system::Contact& contact = *p.model.contact();
  const contact::Surface& s = contact.scene().set().surface();
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  petsc::VecHandle f = p.model.dofs().create_vector(), way = p.model.dofs().create_vector();
  const auto place = [&](unsigned k) {
    contact.set_time(0.1 * (k % 5));
    // In turns all move, and the last sheet alone is taken away: too few points to look at everything anew.
    const double slide = 0.3 * (k / 2 % 3), taken = k % 2 == 1 ? 0.3 : 0.0;
    set_displacement(p.model, p.u, [&](Index v) {
      const int layer = v / (p.mesh.vertex_count() / 4);
      return Vec3(noise(4e-3, k / 2)(v) + layer * Vec3(slide, -0.5 * slide, 0.0) +
                  Vec3(0.0, 0.0, layer == 3 ? taken : 0.0));
    });
    return contact.scene().positions(p.u);
  };
  long pairs = 0;
  double shortest = 1.0;
  for (unsigned k = 0; k < 24; ++k) {
    CAPTURE(k);
    // Slips count from the start of the step, also for points that a rank sees only later.
    const std::vector<Vec3> start = place(k + 3);
    contact.start_step(p.u, 1e-3);
    const std::vector<Vec3> x = place(k);
    ContactSet alone(s, {}, {0.03, 1e4, 1e-3}, all);
    (void)alone.cover(x, x);
    const system::ContactReport report = system::report(contact.scene(), p.u);
    check_report(report, alone, x);
    pairs += report.pairs;
    contact.lag_friction(p.u);
    alone.lag_friction(x, start, 1e-3);
    CHECK(contact.energy(p.u) == relative(alone.energy(x)).epsilon(1e-12).scale(1.0));
    const std::vector<Vec3> later = place(k ^ 1u);  // the last sheet taken away, or put back
    (void)alone.cover(later, later);
    CHECK(system::report(contact.scene(), p.u).pairs == alone.state(later).pairs);
    place(k);
    set_displacement(p.model, way, noise(0.02, 100 + k));
    const std::vector<Vec3> ways = per_vertex(p.model, way);
    std::vector<Vec3> to = x;
    for (std::size_t i = 0; i < ways.size(); ++i) to[i] += ways[i];
    (void)alone.cover(x, to);
    const double fraction = contact.step_fraction(p.u, way);
    CHECK(fraction == relative(alone.step_fraction(x, to)).epsilon(1e-9));
    shortest = std::min(shortest, fraction);
    VOILE_PETSC(VecAXPY(p.u, 0.5 * fraction, way));
    const std::vector<Vec3> now = contact.scene().positions(p.u);
    alone.lag_friction(now, start, 1e-3);
    contact.lag_friction(p.u);
    VOILE_PETSC(VecZeroEntries(f));
    contact.add_gradient(p.u, f);
    std::vector<Vec3> wanted(ways.size(), Vec3::Zero());
    alone.add_gradient(now, wanted);
    check_same(per_vertex(p.model, f), wanted);
  }
  CHECK(pairs > 1000);
  CHECK(shortest < 0.5);
}

}  // namespace test_contact_model
