// The load path: stops, step sizes, failure, direction, and what the observer sees.
#include <doctest/doctest.h>

#include "solve/load_path.hpp"
#include "solve/newton.hpp"
#include "test_following.hpp"
#include "test_newton_kit.hpp"
#include "test_problems.hpp"

namespace test_load_path {

using namespace voile;
using namespace voile::testing;

namespace {

struct Record {
  std::vector<Report> reports;
  std::vector<std::vector<double>> states;
  std::vector<std::string> remarks;
  Ended result;
};

template <class Problem>
Record run(Problem& problem, const solve::StaticOptions& options) {
  Record record;
  solve::LoadPath path(problem.model, options);
  path.on_remark([&](const std::string& text) { record.remarks.push_back(text); });
  record.result = follow_from(state_of(problem.a), path, [&](const system::State& s, const solve::StepResult& r) {
    record.reports.emplace_back(s, r, path.finished(s));
    record.states.push_back(values_of(problem.model, s.u));
    return false;
  });
  return record;
}

std::vector<double> factors(const Record& r) {
  std::vector<double> f;
  for (const Report& s : r.reports) f.push_back(s.load_factor);
  return f;
}

}  // namespace

TEST_CASE("the path begins at the unloaded state, visits its stops exactly and ends at the full load") {
  Strip strip(1.0);
  solve::StaticOptions options;
  options.initial_step = 0.2;
  options.stops = {0.1, 1.0 / 3.0, 0.61, 1.0};
  const Record r = run(strip, options);
  REQUIRE(r.result.completed);
  CHECK(r.result.reason.empty());
  REQUIRE(r.reports.size() == static_cast<std::size_t>(r.result.steps) + 1);
  CHECK(r.reports.front().step == 0);
  CHECK(r.reports.front().load_factor == 0.0);
  CHECK_FALSE(r.reports.front().last);
  for (double u : r.states.front()) CHECK(u == 0.0);
  int iterations = 0, factorisations = 0;
  for (std::size_t i = 1; i < r.reports.size(); ++i) {
    CHECK(r.reports[i].step == static_cast<int>(i));
    CHECK(r.reports[i].load_factor > r.reports[i - 1].load_factor);
    CHECK(r.reports[i].newton.converged);
    CHECK(r.reports[i].last == (i + 1 == r.reports.size()));
    iterations += r.reports[i].newton.iterations;
    factorisations += r.reports[i].newton.factorisations;
  }
  const std::vector<double> f = factors(r);
  for (const double stop : options.stops) CHECK(std::count(f.begin(), f.end(), stop) == 1);
  CHECK(f.back() == 1.0);
  CHECK(r.result.state.load_factor == 1.0);
  CHECK(strip.model.conditions().load_factor() == 1.0);
  CHECK(r.result.newton_iterations == iterations);  // no step failed
  CHECK(r.result.factorisations == factorisations);
  CHECK(r.states.back() == values_of(strip.model, strip.a));
}

TEST_CASE("an easy path doubles its steps up to the largest, a tight effort keeps them") {
  // Loads so small that Newton needs two or three iterations.
  solve::StaticOptions options;
  options.initial_step = 0.05;
  options.max_step = 0.25;
  Strip easy(0.01);
  CHECK(factors(run(easy, options)) == std::vector<double>{0.0, 0.05, 0.05 + 0.1, 0.05 + 0.1 + 0.2,
                                                           0.05 + 0.1 + 0.2 + 0.25, 0.05 + 0.1 + 0.2 + 0.25 + 0.25,
                                                           1.0});
  options.target_iterations = 0;
  options.initial_step = 0.25;
  options.max_step = 1.0;
  Strip tight(0.01);
  CHECK(factors(run(tight, options)) == std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0});
}

TEST_CASE("a remainder of less than a tenth of a step is taken along") {
  solve::StaticOptions options;
  options.initial_step = options.max_step = 0.48;
  Strip strip(0.01);
  CHECK(factors(run(strip, options)) == std::vector<double>{0.0, 0.48, 1.0});
}

TEST_CASE("a stop that cuts a step short does not shrink the steps after it") {
  solve::StaticOptions options;
  options.initial_step = options.max_step = 0.25;
  options.stops = {0.3};
  Strip strip(0.01);
  CHECK(factors(run(strip, options)) == std::vector<double>{0.0, 0.25, 0.3, 0.3 + 0.25, 0.3 + 0.25 + 0.25, 1.0});
}

TEST_CASE("a failing step is halved until it converges, and the path completes") {
  // Four hundred times the usual end load cannot be reached in one step.
  solve::StaticOptions options;
  options.initial_step = 1.0;
  options.fallback = false;
  Strip strip(1600.0);
  const Record r = run(strip, options);
  REQUIRE(r.result.completed);
  REQUIRE_FALSE(r.remarks.empty());
  const double first = r.reports[1].load_factor;
  const double halvings = -std::log2(first);
  CHECK(halvings >= 1.0);
  CHECK(halvings == std::round(halvings));
  CHECK(r.result.state.load_factor == 1.0);
  int accepted = 0;
  for (const Report& s : r.reports) accepted += s.newton.iterations;
  CHECK(r.result.newton_iterations > accepted);  // failed attempts are counted
  // The same state as by many small steps.
  options.initial_step = options.max_step = 0.02;
  Strip slow(1600.0);
  const Record s = run(slow, options);
  REQUIRE(s.result.completed);
  double difference = 0.0;
  for (std::size_t i = 0; i < s.states.back().size(); ++i)
    difference = std::max(difference, std::abs(s.states.back()[i] - r.states.back()[i]));
  CHECK(difference < 1e-5);  // of a deflection of about 9: both within Newton's -snes_stol of 1e-6
}

TEST_CASE("a path that cannot go on ends with the last accepted state and says why") {
  Arch arch;
  solve::StaticOptions options;
  options.final_load_factor = 4.0;
  options.initial_step = options.max_step = 0.5;
  options.min_step = 0.3;
  options.fallback = false;
  const Record r = run(arch, options);
  CHECK_FALSE(r.result.completed);
  CHECK_FALSE(r.result.reason.empty());
  CHECK(r.result.reason.find("no equilibrium") != std::string::npos);
  CHECK(r.result.state.load_factor == 0.5);  // the snap is near 0.7
  REQUIRE(r.reports.size() > 1);
  CHECK(r.result.state.load_factor == r.reports.back().load_factor);
  CHECK(arch.model.conditions().load_factor() == r.result.state.load_factor);
  CHECK_FALSE(r.reports.back().last);
  CHECK(r.states.back() == values_of(arch.model, arch.a));
  // It is an equilibrium at the load factor that the model is left with.
  petsc::VecHandle residual = arch.model.dofs().create_vector();
  arch.model.residual(arch.a, residual);
  CHECK(norm(residual) < 1e-7 * arch.model.force_scale());
}

TEST_CASE("continuation takes the path across a snap") {
  Arch arch;
  solve::StaticOptions options;
  options.final_load_factor = 20.0;
  options.initial_step = 0.5;
  const Record r = run(arch, options);
  REQUIRE(r.result.completed);
  int continued = 0;
  for (const Report& s : r.reports) continued += s.by_continuation ? 1 : 0;
  CHECK(continued > 0);
  CHECK(r.result.state.load_factor == 20.0);
  CHECK(r.states.back()[3 * 19 + 2] < -0.09);  // the crown was 0.06 above its hinges and is as far below
}

TEST_CASE("stops close to each other are all visited, in both directions and whatever their order") {
  solve::StaticOptions options;
  options.initial_step = options.max_step = 0.5;
  Strip strip(0.01);
  options.stops = {0.40, 0.41, 0.99};
  CHECK(factors(run(strip, options)) == std::vector<double>{0.0, 0.40, 0.41, 0.41 + 0.5, 0.99, 1.0});
  Strip back(0.01);
  options.final_load_factor = -1.0;
  options.stops = {-0.99, -0.41, -0.40};
  CHECK(factors(run(back, options)) == std::vector<double>{0.0, -0.40, -0.41, -0.41 - 0.5, -0.99, -1.0});
}

TEST_CASE("a negative final load factor is approached downwards, stops included") {
  solve::StaticOptions options;
  options.final_load_factor = -1.0;
  options.initial_step = 0.25;
  options.max_step = 0.25;
  options.stops = {-0.4};
  Strip up(1.0), down(1.0);
  const Record d = run(down, options);
  REQUIRE(d.result.completed);
  CHECK(factors(d) == std::vector<double>{0.0, -0.25, -0.4, -0.4 - 0.25, -0.4 - 0.25 - 0.25, -1.0});
  options.final_load_factor = 1.0;
  options.stops = {0.4};
  const Record u = run(up, options);
  // The strip is flat: the deflections are mirrored.
  for (std::size_t i = 0; i < u.states.back().size(); ++i)
    CHECK(std::abs(d.states.back()[i] - (i % 3 == 2 ? -1.0 : 1.0) * u.states.back()[i]) < 1e-9);
}

TEST_CASE("an equilibrium nearby is regained by a few full steps, which an unstable state is not") {
  const auto regain = [](system::Model& model, Vec a, double factor, double size) {
    const petsc::VecHandle noisy = model.dofs().create_vector();
    set_displacement(model, noisy, noise(size, 3));
    VOILE_PETSC(VecAXPY(a, 1.0, noisy));
    model.conditions().set_load_factor(factor);
    model.conditions().enforce(a);
    const std::vector<double> start = values_of(model, a);
    system::State state = state_of(a);
    state.load_factor = factor;
    const solve::StepResult r = solve::regain_equilibrium(model, state);
    VOILE_PETSC(VecCopy(state.u, a));
    return std::tuple(r, state.in_equilibrium, start);
  };
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    return largest;
  };
  Strip strip(1.0);
  strip.model.conditions().set_load_factor(0.5);
  solve::Newton first(strip.model);
  REQUIRE(first.step(strip.a).converged);
  const std::vector<double> bent = values_of(strip.model, strip.a);
  const auto [found, settled, moved] = regain(strip.model, strip.a, 0.5, 1e-3);
  CHECK(found.outcome == solve::Outcome::accepted);
  CHECK(settled);
  CHECK(apart(moved, bent) > 1e-4);
  CHECK(found.newton_iterations <= 8);
  CHECK(apart(values_of(strip.model, strip.a), bent) < 1e-6);

  // A flat column under five times its buckling load.
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 10));
  system::ModelInput input;
  input.materials = {isotropic(1e4, 0.3, 0.01)};
  input.supports = {support("left", system::Support::Kind::hinged),
                    newton::displacement("right", {true, true, true}, Vec3(-5e-4, 0.0, 0.0))};
  system::Model column(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = column.dofs().create_vector();
  column.conditions().set_load_factor(1.0);
  solve::Newton flat(column);
  REQUIRE(flat.step(a).negative_pivots > 0);
  const auto [unstable, at_rest, start] = regain(column, a, 1.0, 1e-6);
  CHECK(unstable.outcome == solve::Outcome::failed);
  CHECK_FALSE(at_rest);
  CHECK(values_of(column, a) == start);
}

}  // namespace test_load_path
