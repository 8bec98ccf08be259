#include "eigen_options.hpp"

#include <fmt/format.h>
#include <slepceps.h>

#include <string>

#include "base/petsc.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

void read_eigen_options(_p_EPS* eps) {
  ST st = nullptr;
  KSP ksp = nullptr;
  EPSProblemType problem = EPS_GHEP, asked = EPS_GHEP;
  STType type = nullptr;
  VOILE_PETSC(EPSGetST(eps, &st));
  VOILE_PETSC(STGetType(st, &type));
  const std::string transformation = type ? type : STSHIFT;
  VOILE_PETSC(EPSGetProblemType(eps, &problem));
  VOILE_PETSC(EPSSetFromOptions(eps));
  VOILE_PETSC(EPSGetProblemType(eps, &asked));
  if (asked != problem)
    throw UserError(
        "options -eps_hermitian, -eps_gen_hermitian and their like: whether a problem is symmetric follows from the "
        "case; leave the option out");
  VOILE_PETSC(STGetType(st, &type));
  if (type && transformation != type)
    throw UserError(fmt::format("option -st_type {}: modes of this analysis are found with {}; leave the option out",
                                type, transformation));
  double tolerance = 0.0;
  VOILE_PETSC(EPSGetTolerances(eps, &tolerance, nullptr));
  if (tolerance > loosest_eigen_tolerance)
    throw UserError(fmt::format("option -eps_tol {:g}: modes would be wrong; give {:g} or less", tolerance,
                                loosest_eigen_tolerance));
  VOILE_PETSC(STGetKSP(st, &ksp));
  PetscBool direct = PETSC_TRUE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  VOILE_PETSC(KSPGetTolerances(ksp, &tolerance, nullptr, nullptr, nullptr));
  if (!direct && tolerance > loosest_transformed_tolerance)
    throw UserError(fmt::format("option -st_ksp_rtol {:g}: modes would be wrong; give {:g} or less", tolerance,
                                loosest_transformed_tolerance));
}

SlepcSession::SlepcSession() {
  PetscBool begun = PETSC_FALSE;
  VOILE_PETSC(SlepcInitialized(&begun));
  begun_ = begun == PETSC_FALSE;
  if (begun_) VOILE_PETSC(SlepcInitialize(nullptr, nullptr, nullptr, nullptr));
}
SlepcSession::~SlepcSession() {
  if (begun_) (void)SlepcFinalize();
}

}  // namespace voile::solve
