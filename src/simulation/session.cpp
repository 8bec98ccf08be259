#include "voile/session.hpp"

#include <mpi.h>
#include <petscsys.h>

#include <csignal>

#include "base/mpi.hpp"
#include "base/threads.hpp"
#include "solve/eigen_options.hpp"
#include "voile/errors.hpp"
#include "voile/version.hpp"

namespace voile {

Session::Session() {
  begin(0, nullptr);
}

Session::Session(int argc, char** argv) {
  begin(argc, argv);
}

void Session::begin(int argc, char** argv) {
  use_one_thread();
  int is_begun = 0;
  MPI_Initialized(&is_begun);
  mpi_ = is_begun == 0;
  if (mpi_) MPI_Init(argv ? &argc : nullptr, argv ? &argv : nullptr);
  const auto require = [](PetscErrorCode code, const char* what) {
    if (code != 0) throw InternalError(std::string(what) + " cannot be started");
  };
  PetscBool begun = PETSC_FALSE;
  require(PetscInitialized(&begun), "PETSc");
  petsc_ = begun == PETSC_FALSE;
  if (petsc_) {
    // The host's signal handlers and files stay what they are.
    require(PetscOptionsSetValue(nullptr, "-no_signal_handler", nullptr), "PETSc");
    require(PetscOptionsSetValue(nullptr, "-skip_petscrc", nullptr), "PETSc");
    require(PetscInitialize(argv ? &argc : nullptr, argv ? &argv : nullptr, nullptr, nullptr), "PETSc");
  }
  slepc_ = std::make_shared<solve::SlepcSession>();
}

Session::~Session() {
  int ended = 0;
  MPI_Finalized(&ended);
  if (ended) return;
  slepc_.reset();
  if (petsc_) (void)PetscFinalize();
  if (mpi_) MPI_Finalize();
}

int Session::rank() const {
  return mpi::rank(MPI_COMM_WORLD);
}

std::string version() {
  return VOILE_VERSION;
}

}  // namespace voile
