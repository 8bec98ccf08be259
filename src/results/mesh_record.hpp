// A whole mesh in an HDF5 file, to be read back; private to src/io.
#pragma once

#include <filesystem>
#include <string>

#include "hdf5_file.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::results {

/// Under /mesh: positions, triangles, groups, texture, rest corners where there are, and the numbers that vertices and
/// triangles had in their file; no notes. `length`: unit of positions.
void write_mesh_record(NewFile& file, const mesh::MeshData& mesh, const std::string& length = "m");
/// `where`: path of the record in the file; `path`: name of the file for messages. Throws UserError if it is damaged.
[[nodiscard]] mesh::MeshData read_mesh_record(hid_t file, const std::string& where, const std::filesystem::path& path);

/// Numbers of vertices or triangles below `end`. Throws UserError if there are others.
[[nodiscard]] std::vector<Index> read_members(hid_t file, const std::string& name, std::size_t end,
                                              const std::filesystem::path& path);
/// Each n of them as one.
template <std::size_t n>
[[nodiscard]] std::vector<std::array<Index, n>> grouped(const std::vector<Index>& members) {
  std::vector<std::array<Index, n>> tuples(members.size() / n);
  for (std::size_t i = 0; i < n * tuples.size(); ++i) tuples[i / n][i % n] = members[i];
  return tuples;
}

}  // namespace voile::results
