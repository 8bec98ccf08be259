#include "hdf5_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "voile/base/error.hpp"

namespace voile::io {

namespace fs = std::filesystem;

void fail_restart(const fs::path& file, const std::string& what) {
  throw UserError(fmt::format("--restart {}: {}", file.string(), what));
}

std::vector<double> read_values(hid_t file, const std::string& name, std::size_t count, const fs::path& path) {
  const Hdf5Handle set(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.valid()) fail_restart(path, fmt::format("there is no '{}' in it", name));
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  if (static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)) != count)
    fail_restart(path, "it belongs to another mesh; use the mesh and the parameters of the run that wrote it");
  std::vector<double> values(count);
  if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    fail_restart(path, fmt::format("'{}' cannot be read: the file is damaged (its checksum does not fit); use another "
                                   "step or checkpoint",
                                   name));
  if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
    fail_restart(path, fmt::format("'{}' holds numbers that are not finite; use another step or checkpoint", name));
  return values;
}

double read_number(hid_t file, const std::string& object, const char* name, const fs::path& path) {
  const Hdf5Handle a(H5Aopen_by_name(file, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  double value = 0.0;
  if (!a.valid() || H5Aread(a, H5T_NATIVE_DOUBLE, &value) < 0)
    fail_restart(path, fmt::format("it has no number '{}'", name));
  if (!std::isfinite(value))
    fail_restart(path, fmt::format("its number '{}' is not finite: the file is damaged", name));
  return value;
}

void check_mesh(hid_t file, const mesh::SurfaceMesh& mesh, const fs::path& path) {
  const std::vector<double> x =
      read_values(file, "mesh/positions", 3 * static_cast<std::size_t>(mesh.vertex_count()), path);
  const double tolerance = 1e-9 * mesh.extent();
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k)
      if (std::abs(x[3 * static_cast<std::size_t>(v) + k] - mesh.positions()[v][k]) > tolerance)
        fail_restart(path, fmt::format("vertex {} lies elsewhere than in the mesh of this case", v));
}

}  // namespace voile::io
