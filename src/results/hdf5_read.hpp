// Reading arrays back from HDF5; private to src/io.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hdf5_handle.hpp"
#include "mesh/surface_mesh.hpp"
#include "voile/errors.hpp"

namespace voile::results {

[[noreturn]] void fail_reading(const std::filesystem::path& file, const std::string& what);
/// Says that what failed was read for --restart.
[[noreturn]] void rethrow_for_restart(const UserError& e);

/// Opens a file, which must be a plain one: HDF5 would wait for ever at a pipe. Invalid if it cannot be read.
[[nodiscard]] Hdf5Handle open_to_read(const std::filesystem::path& file);
/// Whether an object is there. Throws UserError if a link on the way to it leads elsewhere, as into another file: what a
/// stranger's file names is not read for him.
[[nodiscard]] bool has(hid_t place, const std::string& name);
/// Opens a dataset that has its values in this file. Throws UserError if they are in others, and if it is not there.
[[nodiscard]] Hdf5Handle open_dataset(hid_t file, const std::string& name, const std::filesystem::path& path);

/// Rows of a dataset; `count` rows from `begin` on.
struct Rows {
  std::size_t begin, count;
};

/// Numbers in a dataset.
[[nodiscard]] std::size_t count_values(hid_t file, const std::string& name, const std::filesystem::path& path);
/// All of a dataset, which must have `count` numbers.
[[nodiscard]] std::vector<double> read_values(hid_t file, const std::string& name, std::size_t count,
                                              const std::filesystem::path& path);
/// Some rows of a table of `columns` columns.
[[nodiscard]] std::vector<double> read_rows(hid_t file, const std::string& name, const Rows& rows, std::size_t columns,
                                            const std::filesystem::path& path);
/// All of a dataset of whole numbers, whatever its shape. Throws UserError if it is not there or damaged.
[[nodiscard]] std::vector<std::int64_t> read_integers(hid_t file, const std::string& name,
                                                      const std::filesystem::path& path);
/// The same for any numbers; they may be not finite.
[[nodiscard]] std::vector<double> read_all(hid_t file, const std::string& name, const std::filesystem::path& path);
[[nodiscard]] double read_number(hid_t file, const std::string& object, const char* name,
                                 const std::filesystem::path& path);
/// A text attribute of fixed length.
[[nodiscard]] std::string read_text(hid_t file, const std::string& object, const char* name,
                                    const std::filesystem::path& path);
/// Three numbers for each.
[[nodiscard]] std::vector<Vec3> points_of(const std::vector<double>& x);
/// Throws UserError unless the positions at rest in a dataset are those of `mesh`.
void check_mesh(hid_t file, const std::string& name, const mesh::SurfaceMesh& mesh, const std::filesystem::path& path);

}  // namespace voile::results
