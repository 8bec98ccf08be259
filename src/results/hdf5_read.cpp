#include "hdf5_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/plain_file.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace fs = std::filesystem;

void fail_reading(const fs::path& file, const std::string& what) {
  throw UserError(fmt::format("{}: {}", file.string(), what));
}

void rethrow_for_restart(const UserError& e) {
  throw UserError(fmt::format("--restart {}", e.what()));
}

namespace {

std::string name_of(hid_t place) {
  std::string name(4096, '\0');
  const ssize_t length = H5Fget_name(place, name.data(), name.size());
  name.resize(length > 0 ? std::min<std::size_t>(static_cast<std::size_t>(length), name.size() - 1) : 0);
  return name;
}

constexpr const char* foreign = "its data are to be read from this file alone; do not use it, or have it made anew";

[[noreturn]] void fail_damaged(const fs::path& path, const std::string& name) {
  fail_reading(path, fmt::format("'{}' cannot be read: the file is damaged (its checksum does not fit); use another "
                                 "step or checkpoint",
                                 name));
}

void check_finite(const std::vector<double>& values, const fs::path& path, const std::string& name) {
  if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
    fail_reading(path, fmt::format("'{}' holds numbers that are not finite; use another step or checkpoint", name));
}

template <class Real>
std::vector<Real> read_list(hid_t file, const std::string& name, hid_t type, const fs::path& path) {
  const Hdf5Handle set = open_dataset(file, name, path);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count < 0) fail_damaged(path, name);
  std::vector<Real> values(static_cast<std::size_t>(count));
  if (count > 0 && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) fail_damaged(path, name);
  return values;
}

}  // namespace

Hdf5Handle open_to_read(const fs::path& file) {
  require_plain_file(file);
  return {H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
}

bool has(hid_t place, const std::string& name) {
  for (std::size_t end = 0; end != name.npos;) {
    end = name.find('/', end + 1);
    const std::string part = name.substr(0, end);
    if (part.empty() || part == "/") continue;
    H5L_info_t link{};
    if (H5Lexists(place, part.c_str(), H5P_DEFAULT) <= 0) return false;
    if (H5Lget_info(place, part.c_str(), &link, H5P_DEFAULT) < 0) return false;
    if (link.type != H5L_TYPE_HARD)
      fail_reading(name_of(place), fmt::format("'{}' is a link to something else; {}", part, foreign));
  }
  return true;
}

Hdf5Handle open_dataset(hid_t file, const std::string& name, const fs::path& path) {
  Hdf5Handle set(has(file, name) ? H5Dopen2(file, name.c_str(), H5P_DEFAULT) : -1, H5Dclose);
  if (!set.valid()) fail_reading(path, fmt::format("there is no '{}' in it", name));
  const Hdf5Handle how(H5Dget_create_plist(set), H5Pclose);
  if (!how.valid() || H5Pget_layout(how) == H5D_VIRTUAL || H5Pget_external_count(how) != 0)
    fail_reading(path, fmt::format("'{}' has its values in other files; {}", name, foreign));
  return set;
}

std::size_t count_values(hid_t file, const std::string& name, const fs::path& path) {
  const Hdf5Handle set = open_dataset(file, name, path);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  return static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
}

std::vector<Vec3> points_of(const std::vector<double>& x) {
  std::vector<Vec3> points;
  points.reserve(x.size() / 3);
  for (std::size_t i = 0; i + 2 < x.size(); i += 3) points.emplace_back(x[i], x[i + 1], x[i + 2]);
  return points;
}

std::vector<double> read_values(hid_t file, const std::string& name, std::size_t count, const fs::path& path) {
  const Hdf5Handle set = open_dataset(file, name, path);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  if (static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)) != count)
    fail_reading(
        path, "it belongs to another mesh; use the mesh and the parameters of the run that wrote it, and its [remesh]");
  std::vector<double> values(count);
  if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) fail_damaged(path, name);
  check_finite(values, path, name);
  return values;
}

std::vector<double> read_rows(hid_t file, const std::string& name, const Rows& rows, std::size_t columns,
                              const fs::path& path) {
  const Hdf5Handle set = open_dataset(file, name, path);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  // A table of one column may have one dimension only.
  std::array<hsize_t, 2> size{0, 1};
  const std::array<hsize_t, 2> begin{rows.begin, 0}, count{rows.count, columns};
  const int dimensions = H5Sget_simple_extent_ndims(space);
  if (dimensions < 1 || dimensions > 2 || H5Sget_simple_extent_dims(space, size.data(), nullptr) < 0 ||
      size[1] != columns || rows.count > size[0] || rows.begin > size[0] - rows.count)
    fail_reading(path, fmt::format("'{}' has no rows {} to {} of {} numbers: the file is damaged", name, rows.begin,
                                   rows.begin + rows.count, columns));
  const Hdf5Handle memory(H5Screate_simple(dimensions, count.data(), nullptr), H5Sclose);
  std::vector<double> values(rows.count * columns);
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr) < 0 ||
      H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()) < 0)
    fail_damaged(path, name);
  check_finite(values, path, name);
  return values;
}

std::vector<std::int64_t> read_integers(hid_t file, const std::string& name, const fs::path& path) {
  return read_list<std::int64_t>(file, name, H5T_NATIVE_INT64, path);
}

std::vector<double> read_all(hid_t file, const std::string& name, const fs::path& path) {
  return read_list<double>(file, name, H5T_NATIVE_DOUBLE, path);
}

std::string read_text(hid_t file, const std::string& object, const char* name, const fs::path& path) {
  const Hdf5Handle a(has(file, object) ? H5Aopen_by_name(file, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT) : -1,
                     H5Aclose);
  const Hdf5Handle type(a.valid() ? H5Aget_type(a) : -1, H5Tclose);
  if (!type.valid() || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0)
    fail_reading(path, fmt::format("it has no text '{}'", name));
  std::string text(H5Tget_size(type), '\0');
  if (H5Aread(a, type, text.data()) < 0) fail_reading(path, fmt::format("its text '{}' cannot be read", name));
  text.erase(text.find_last_not_of('\0') + 1);
  return text;
}

double read_number(hid_t file, const std::string& object, const char* name, const fs::path& path) {
  const Hdf5Handle a(has(file, object) ? H5Aopen_by_name(file, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT) : -1,
                     H5Aclose);
  double value = 0.0;
  if (!a.valid() || H5Aread(a, H5T_NATIVE_DOUBLE, &value) < 0)
    fail_reading(path, fmt::format("it has no number '{}'", name));
  if (!std::isfinite(value))
    fail_reading(path, fmt::format("its number '{}' is not finite: the file is damaged", name));
  return value;
}

void check_mesh(hid_t file, const std::string& name, const mesh::SurfaceMesh& mesh, const fs::path& path) {
  const std::vector<double> x = read_values(file, name, 3 * static_cast<std::size_t>(mesh.vertex_count()), path);
  const double tolerance = 1e-9 * mesh.extent();
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k)
      if (std::abs(x[3 * static_cast<std::size_t>(v) + k] - mesh.positions()[v][k]) > tolerance)
        fail_reading(path, fmt::format("vertex {} lies elsewhere than in the mesh of this case", v));
}

}  // namespace voile::results
