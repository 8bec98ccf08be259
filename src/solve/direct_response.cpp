#include "direct_response.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "voile/errors.hpp"

namespace voile::solve {

namespace {

/// x = m^-1 rhs by a new factor of MUMPS. False if it is singular.
bool solve_once(Mat m, Vec rhs, Vec x) {
  petsc::KspHandle ksp;
  PC pc = nullptr;
  Mat factor = nullptr;
  VOILE_PETSC(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(m)), ksp.out()));
  VOILE_PETSC(MatSetOption(m, MAT_SYMMETRIC, PETSC_TRUE));
  VOILE_PETSC(KSPSetOperators(ksp, m, m));
  VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCSetType(pc, PCCHOLESKY));
  VOILE_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  VOILE_PETSC(PCFactorGetMatrix(pc, &factor));
  VOILE_PETSC(MatMumpsSetIcntl(factor, linear::mumps_workspace_percent, 100));
  VOILE_PETSC(KSPSolve(ksp, rhs, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  VOILE_PETSC(KSPGetConvergedReason(ksp, &reason));
  PetscInt error = 0, size = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor, linear::mumps_error, &error));
  VOILE_PETSC(MatMumpsGetInfog(factor, linear::mumps_error + 1, &size));
  linear::check_mumps_room(error, size);
  return reason >= 0 && error >= 0;
}

/// Copies local values between a vector of both parts, the second behind the first on each rank, and its parts.
void join(Vec first, Vec second, Vec both) {
  const petsc::ReadArray a(first), b(second);
  const petsc::WriteArray out(both);
  PetscInt n = 0;
  VOILE_PETSC(VecGetLocalSize(first, &n));
  std::copy_n(a.data(), n, out.data());
  std::copy_n(b.data(), n, out.data() + n);
}

void split(Vec both, Vec first, Vec second) {
  const petsc::ReadArray in(both);
  const petsc::WriteArray a(first), b(second);
  PetscInt n = 0;
  VOILE_PETSC(VecGetLocalSize(first, &n));
  std::copy_n(in.data(), n, a.data());
  std::copy_n(in.data() + n, n, b.data());
}

}  // namespace

DirectResponse::DirectResponse(system::Model& model, Vec a, const MassMatrix& mass, Mat damping)
    : mass_(mass), damping_(damping) {
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatDuplicate(model.tangent().matrix(), MAT_COPY_VALUES, stiffness_.out()));
}

petsc::MatHandle DirectResponse::coupled(Mat a, double omega) const {
  petsc::MatHandle minus_a, minus_b, nest, all;
  VOILE_PETSC(MatDuplicate(a, MAT_COPY_VALUES, minus_a.out()));
  VOILE_PETSC(MatScale(minus_a, -1.0));
  VOILE_PETSC(MatDuplicate(damping_, MAT_COPY_VALUES, minus_b.out()));
  VOILE_PETSC(MatScale(minus_b, -omega));
  std::array<Mat, 4> parts{a, minus_b, minus_b, minus_a};
  VOILE_PETSC(MatCreateNest(PetscObjectComm(reinterpret_cast<PetscObject>(a)), 2, nullptr, 2, nullptr, parts.data(),
                            nest.out()));
  VOILE_PETSC(MatConvert(nest, MATAIJ, MAT_INITIAL_MATRIX, all.out()));
  return all;
}

void DirectResponse::solve(double omega, Vec force, double shift, Vec x, Vec y) const {
  petsc::MatHandle a;
  VOILE_PETSC(MatDuplicate(stiffness_, MAT_COPY_VALUES, a.out()));
  VOILE_PETSC(MatAXPY(a, -omega * omega, mass_.mat(), SUBSET_NONZERO_PATTERN));
  bool good = false;
  if (!damping_) {
    good = solve_once(a, force, x);
    VOILE_PETSC(VecZeroEntries(y));
  } else {
    const petsc::MatHandle both = coupled(a, omega);
    petsc::VecHandle rhs, solution;
    VOILE_PETSC(MatCreateVecs(both, solution.out(), rhs.out()));
    VOILE_PETSC(VecCopy(force, y));
    VOILE_PETSC(VecScale(y, -shift));
    join(force, y, rhs);
    good = solve_once(both, rhs, solution);
    if (good) split(solution, x, y);
  }
  if (!good)
    throw UserError(
        fmt::format("analysis = \"harmonic\": the system is singular at {:g} Hz, where nothing damps a "
                    "resonance; give [damping], or another frequency",
                    omega / (2.0 * std::numbers::pi)));
}

}  // namespace voile::solve
