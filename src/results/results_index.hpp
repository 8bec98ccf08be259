// results.vtkhdf: as a small file of virtual datasets over steps/, and as one file that holds everything; private to
// src/io.
#pragma once

#include <filesystem>

#include "results_catalogue.hpp"

namespace voile::results {

/// Replaces results.vtkhdf by one that names all steps, whose data stay in steps/. Throws UserError.
void write_index(const std::filesystem::path& folder, const Catalogue& catalogue);

/// Replaces it by one that holds all data, copied from steps/, in a process of its own: HDF5 ends in a crash after a
/// full disk. Throws UserError; results.vtkhdf then stays as it was.
void consolidate(const std::filesystem::path& folder, const Catalogue& catalogue);

}  // namespace voile::results
