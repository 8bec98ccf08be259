// PETSc's options of the path and of the motion win over the keys of a case, by the same rules.
#pragma once

#include <mpi.h>

#include "input/case.hpp"

namespace voile::simulation {

/// Takes -path_ and -ts_ options into the case of a stage. Collective. Throws UserError for what its keys could not say.
void take_options(MPI_Comm comm, input::Case& c);

}  // namespace voile::simulation
