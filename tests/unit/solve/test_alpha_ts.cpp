// The time stepper alone, on one equation: which first guesses it has looked at.
#include <doctest/doctest.h>
#include <petscts.h>

#include <vector>

#include "base/petsc.hpp"
#include "solve/alpha_ts.hpp"
#include "test_relative.hpp"

namespace test_alpha_ts {

using namespace voile;

namespace {

using TsHandle = petsc::Handle<TS, TSDestroy>;

constexpr double acceleration = 1000.0, velocity = 1.0, step = 0.1;

// F = A - acceleration
PetscErrorCode function(TS, PetscReal, Vec, Vec, Vec a, Vec f, void*) {
  PetscFunctionBeginUser;
  PetscCall(VecCopy(a, f));
  PetscCall(VecShift(f, -acceleration));
  PetscFunctionReturn(0);
}

PetscErrorCode jacobian(TS, PetscReal, Vec, Vec, Vec, PetscReal, PetscReal shift, Mat, Mat p, void*) {
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(p));
  PetscCall(MatShift(p, shift));
  PetscFunctionReturn(0);
}

PetscErrorCode enforce(void*, PetscReal, Vec) {
  return 0;
}

PetscErrorCode clear(void* guesses, PetscReal, Vec, PetscReal, Vec x1, PetscBool* possible) {
  PetscReal most = 0.0;
  PetscFunctionBeginUser;
  *possible = PETSC_TRUE;
  PetscCall(VecNorm(x1, NORM_INFINITY, &most));
  static_cast<std::vector<double>*>(guesses)->push_back(most);
  PetscFunctionReturn(0);
}

PetscErrorCode energy(void*, Vec, PetscReal* energy) {
  *energy = 0.0;
  return 0;
}

/// Guesses of one step from rest's place, in the order in which they are asked to be cleared.
std::vector<double> guesses_of_a_step(double longest_flight) {
  solve::register_alpha_ts();
  std::vector<double> guesses;
  petsc::MatHandle j;
  petsc::VecHandle x, v;
  VOILE_PETSC(MatCreateAIJ(PETSC_COMM_SELF, 1, 1, 1, 1, 1, nullptr, 0, nullptr, j.out()));
  for (PetscInt i = 0; i < 1; ++i) VOILE_PETSC(MatSetValue(j, i, i, 1.0, INSERT_VALUES));
  VOILE_PETSC(MatAssemblyBegin(j, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(j, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatCreateVecs(j, x.out(), v.out()));
  VOILE_PETSC(VecSet(v, velocity));
  TsHandle ts;
  VOILE_PETSC(TSCreate(PETSC_COMM_SELF, ts.out()));
  VOILE_PETSC(TSSetType(ts, solve::alpha_ts_type));
  VOILE_PETSC(TSSetI2Function(ts, nullptr, function, nullptr));
  VOILE_PETSC(TSSetI2Jacobian(ts, j, j, jacobian, nullptr));
  VOILE_PETSC(TS2SetSolution(ts, x, v));
  VOILE_PETSC(TSSetTimeStep(ts, step));
  VOILE_PETSC(TSSetMaxSteps(ts, 1));
  VOILE_PETSC(TSSetMaxTime(ts, 1.0));
  VOILE_PETSC(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  TSAdapt adapt = nullptr;
  VOILE_PETSC(TSGetAdapt(ts, &adapt));
  VOILE_PETSC(TSAdaptSetType(adapt, TSADAPTNONE));
  solve::set_alpha_callbacks(ts, {&guesses, nullptr, enforce, nullptr, clear, energy, longest_flight});
  VOILE_PETSC(TSSolve(ts, nullptr));
  return guesses;
}

}  // namespace

TEST_CASE("a first guess leaves out an acceleration that alone flies too far") {
  const double flight = 0.5 * step * step * acceleration;
  const std::vector<double> near = guesses_of_a_step(1.01 * flight), far = guesses_of_a_step(0.99 * flight);
  REQUIRE(near.size() == 2);
  CHECK(near[0] == relative(step * velocity + flight).epsilon(1e-9));
  CHECK(near[1] == relative(step * velocity).epsilon(1e-9));
  REQUIRE(far.size() == 1);
  CHECK(far[0] == relative(step * velocity).epsilon(1e-9));
}

}  // namespace test_alpha_ts
