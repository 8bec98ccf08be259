// Reading arrays back from HDF5 for --restart; private to src/io.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hdf5_handle.hpp"
#include "voile/mesh/surface_mesh.hpp"

namespace voile::io {

[[noreturn]] void fail_restart(const std::filesystem::path& file, const std::string& what);
[[nodiscard]] std::vector<double> read_values(hid_t file, const std::string& name, std::size_t count,
                                              const std::filesystem::path& path);
[[nodiscard]] double read_number(hid_t file, const std::string& object, const char* name,
                                 const std::filesystem::path& path);
/// Throws UserError unless the file's mesh/positions are those of `mesh`.
void check_mesh(hid_t file, const mesh::SurfaceMesh& mesh, const std::filesystem::path& path);

}  // namespace voile::io
