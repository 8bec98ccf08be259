// The library as a caller uses it: cases, steps, arrays.
#include "test_strip.hpp"

namespace voile::test_simulation {

using namespace testing;

TEST_CASE("a case is a value that can be changed") {
  Case c = strip("static"), other = c;
  c.set("mesh.parameters.nx", 4)
      .set("material.0.young", 2.5e6)
      .set("title", "a \"b\" \\")
      .set("load.0.vector", {0, 0, 1});
  const std::string text = c.text();
  CHECK(text.find("young = 2500000.0") != std::string::npos);
  CHECK(text.find(R"(a \"b\" \\)") != std::string::npos);
  CHECK(other.text() != text);
  CHECK_THROWS_AS((void)c.set("material.0.jung", 1.0).text(), UserError);
  CHECK_THROWS_WITH_AS((void)Case::read("/nowhere/case.toml"), "/nowhere/case.toml: there is no such case file",
                       UserError);
}

TEST_CASE("a simulation is advanced step by step to the end of its case") {
  Simulation s(PETSC_COMM_WORLD, strip("dynamic"));
  CHECK(s.time() == 0.0);
  CHECK(!s.finished());
  int seen = 0;
  s.observe([&](const Step& step) { seen += step.number == seen + 1 ? 1 : 0; });
  const Step first = s.advance();
  CHECK(first.accepted);
  CHECK(first.time == doctest::Approx(0.02));
  CHECK(s.velocities().size() == 3 * static_cast<std::size_t>(s.vertex_count()));
  CHECK(s.run());
  CHECK(s.time() == 0.1);
  CHECK(s.converged());
  CHECK(seen == s.step());
  const History h = s.history();
  CHECK(h.rows.size() == static_cast<std::size_t>(s.step()) + 1);
  CHECK(h.columns.front() == "step");
  CHECK(h.rows.back()[1] == s.time());
  CHECK_THROWS_AS((void)s.advance(), UserError);
  CHECK(s.triangles().size() == 3 * static_cast<std::size_t>(s.triangle_count()));
}

TEST_CASE("positions do not depend on the ranks") {
  Simulation together(PETSC_COMM_WORLD, strip("static")), alone(PETSC_COMM_SELF, strip("static"));
  CHECK(together.run());
  CHECK(alone.run());
  CHECK(together.triangles() == alone.triangles());
  CHECK(difference(together.positions(), alone.positions()) < 1e-9);
  // F L^3 / 3 E I with F = 0.4 * 0.25 N
  CHECK(tip_height(together) == doctest::Approx(0.1 / (3.0 * 1e7 * 0.25 * 1e-6 / 12.0)).epsilon(0.03));
}

TEST_CASE("advance_to lands on its time, and goes on with steps of the size that was wanted") {
  Simulation s(PETSC_COMM_WORLD, strip("dynamic"));
  CHECK(s.advance_to(0.03));
  CHECK(s.time() == 0.03);
  CHECK(s.step() == 2);
  CHECK(s.advance_to(0.03));
  CHECK(s.step() == 2);
  CHECK(s.advance().time == doctest::Approx(0.05));
  CHECK(!s.advance_to(1.0));  // the case ends before
  CHECK(s.time() == 0.1);
  CHECK(s.finished());
  Simulation whole(PETSC_COMM_WORLD, strip("dynamic")), parts(PETSC_COMM_WORLD, strip("dynamic"));
  CHECK(whole.run());
  for (int k = 1; k <= 5; ++k) CHECK(parts.advance_to(0.02 * k));
  CHECK(parts.step() == whole.step());
  CHECK(difference(parts.positions(), whole.positions()) < 1e-8);
  CHECK_THROWS_AS((void)parts.advance_to(0.01), UserError);
  Simulation still(PETSC_COMM_WORLD, strip("static"));
  CHECK_THROWS_AS((void)still.advance_to(0.01), UserError);
}

TEST_CASE("two simulations on two halves of the ranks run side by side") {
  const int rank = mpi::rank(PETSC_COMM_WORLD), half = mpi::size(PETSC_COMM_WORLD) > 1 ? rank % 2 : 0;
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Comm_split(PETSC_COMM_WORLD, half, rank, &comm);
  {
    Case c = strip("dynamic");
    c.set("load.0.vector", {0, 0, half == 0 ? 0.4 : 0.8}).set("time.step", half == 0 ? 0.02 : 0.01);
    Simulation s(comm, c);
    while (!s.finished()) s.advance();  // not in step with the other half
    CHECK(s.step() == (half == 0 ? 5 : 10));
    Simulation alone(PETSC_COMM_SELF, c);
    CHECK(alone.run());
    CHECK(difference(s.positions(), alone.positions()) < 1e-8);
  }
  MPI_Comm_free(&comm);
}

TEST_CASE("fields and energies of a state") {
  Simulation s(PETSC_COMM_WORLD, strip("static"));
  CHECK(s.run());
  const Field moment = s.field("bending_moment"), u = s.field("displacement"), stress = s.field("von_mises_top");
  CHECK(moment.unit == "N");
  CHECK(!moment.on_vertices);
  CHECK(moment.values.size() == 3 * static_cast<std::size_t>(s.triangle_count()));
  CHECK(*std::max_element(moment.values.begin(), moment.values.end()) == doctest::Approx(0.4).epsilon(0.1));
  CHECK(same(u.values, s.displacements()));
  CHECK(*std::max_element(stress.values.begin(), stress.values.end()) > 0.0);
  const Energy e = s.energy();
  CHECK(e.bending == doctest::Approx(-0.5 * e.external).epsilon(0.01));
  CHECK_THROWS_AS((void)s.field("bending_momentum"), UserError);
}

TEST_CASE("frequencies after a run") {
  Case c = strip("modal");
  c.set("eigen.modes", 2);
  Simulation s(PETSC_COMM_WORLD, c);
  CHECK_THROWS_AS((void)s.eigenvalues(), UserError);
  CHECK(s.run());
  // 1.8751^2 sqrt(E I / m) / 2 pi
  REQUIRE(s.eigenvalues().size() == 2);
  CHECK(s.eigenvalues()[0] == doctest::Approx(3.516 * std::sqrt(1e7 * 1e-6 / 12.0 / 1.0) / 6.2832).epsilon(0.02));
}

TEST_CASE("stages follow each other, and a state is gone back to in its own stage only") {
  std::string text = strip("static").source();
  text.replace(text.find("analysis = \"static\""), 19, "");
  const Case c = Case::parse(text + R"(
[[stage]]
name = "bend"
analysis = "static"
[[stage]]
name = "swing"
analysis = "dynamic"
)");
  Simulation s(PETSC_COMM_WORLD, c);
  const State bending = s.save();
  double bent = 0.0;
  while (s.time() == 0.0) {
    bent = tip_height(s);
    s.advance();
  }
  CHECK(s.history().columns[1] == "time");
  const State swinging = s.save();
  CHECK_THROWS_AS(s.restore(bending), UserError);
  CHECK(s.run());
  CHECK(s.time() == 0.1);
  CHECK(tip_height(s) == doctest::Approx(bent).epsilon(0.01));  // it hangs in equilibrium
  s.restore(swinging);
  CHECK(!s.finished());
  CHECK(s.run());
}

}  // namespace voile::test_simulation
