// The folder of temporary files, which MPI needs before anything can be said in parallel.
#pragma once

namespace voile::cli {

/// Throws UserError that says what to do if the folder that MPI takes for its temporary files (TMPDIR, TEMP, TMP, else /tmp)
/// cannot be written or has no room: MPI's own words do not name it. Call it before MPI starts.
void check_temporary_folder();

}  // namespace voile::cli
