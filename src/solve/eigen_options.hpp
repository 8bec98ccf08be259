// What options of SLEPc may choose: how modes are found, not which problem is solved nor how well.
#pragma once

struct _p_EPS;  // SLEPc's

namespace voile::solve {

/// The loosest -eps_tol. A mode left there has an eigenvalue right to about this.
constexpr double loosest_eigen_tolerance = 1e-6;
/// The loosest -st_ksp_rtol of an iterative solver.
constexpr double loosest_transformed_tolerance = 1e-8;

/// EPSSetFromOptions. Collective. Throws UserError where options change the problem or its spectral transformation, or where their
/// tolerances are too loose.
void read_eigen_options(_p_EPS* eps);

/// SLEPc between construction and destruction; PETSc must be running.
class SlepcSession {
 public:
  SlepcSession();
  ~SlepcSession();
  SlepcSession(const SlepcSession&) = delete;
  SlepcSession& operator=(const SlepcSession&) = delete;

 private:
  bool begun_ = false;  ///< here
};

}  // namespace voile::solve
