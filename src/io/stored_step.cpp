#include "voile/io/stored_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "hdf5_read.hpp"
#include "voile/base/child_process.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"

namespace voile::io {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> step_names(hid_t file) {
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
    static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    return 0;
  };
  const Hdf5Handle group(H5Gopen2(file, "steps", H5P_DEFAULT), H5Gclose);
  if (group.valid()) H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names);
  return names;
}

/// Steps are links to files of their own, which a copy of results.h5 alone leaves behind.
void check_link(hid_t file, const std::string& place, const fs::path& path) {
  if (H5Oexists_by_name(file, place.c_str(), H5P_DEFAULT) > 0) return;
  H5L_info_t info{};
  std::string value, target = "another file";
  if (H5Lget_info(file, place.c_str(), &info, H5P_DEFAULT) >= 0 && info.type == H5L_TYPE_EXTERNAL) {
    value.resize(info.u.val_size);
    const char* name = nullptr;
    if (H5Lget_val(file, place.c_str(), value.data(), value.size(), H5P_DEFAULT) >= 0 &&
        H5Lunpack_elink_val(value.data(), value.size(), nullptr, &name, nullptr) >= 0)
      target = name;
  }
  fail_restart(path,
               fmt::format("its '{}' is a link to {} beside it, which is missing or cannot be read; copy the folder "
                           "steps/ together with results.h5",
                           place, target));
}

}  // namespace

namespace {

/// The root of a step: behind a link of results.h5, or in a file that results.h5 does not name yet because its run was
/// killed.
Hdf5Handle open_step(hid_t results, const std::string& number, const fs::path& path) {
  const std::string link = "steps/" + number, file = (path.parent_path() / (link + ".h5")).string();
  const bool named = H5Lexists(results, link.c_str(), H5P_DEFAULT) > 0;
  if (named) check_link(results, link, path);
  return named ? Hdf5Handle(H5Gopen2(results, link.c_str(), H5P_DEFAULT), H5Gclose)
               : Hdf5Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
}

/// Numbers of steps beside results.h5.
void add_unnamed_steps(const fs::path& folder, std::vector<std::string>& names) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder / "steps", ignored)) {
    const std::string stem = entry.path().stem().string();
    const bool digits =
        !stem.empty() && std::all_of(stem.begin(), stem.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
    if (digits && entry.path().extension() == ".h5") names.push_back(stem);
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
}

bool has(hid_t place, const char* name) {
  return H5Lexists(place, name, H5P_DEFAULT) > 0;
}

}  // namespace

namespace {

StoredStep read_unguarded(const fs::path& path, int step, const mesh::SurfaceMesh& mesh) {
  const Silence silence;
  const Hdf5Handle file(H5Fopen(path.string().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) fail_restart(path, "this is not a results.h5 that can be read");
  check_mesh(file, mesh, path);
  std::vector<std::string> names = step_names(file);
  add_unnamed_steps(path.parent_path(), names);
  if (names.empty()) fail_restart(path, "it has no steps");
  auto at = step < 0 ? names.end() - 1 : std::find(names.begin(), names.end(), fmt::format("{:06d}", step));
  if (at == names.end()) fail_restart(path, fmt::format("it has no step {}; it has {}", step, join(names, ", ")));
  const std::size_t count = 3 * static_cast<std::size_t>(mesh.vertex_count());
  StoredStep stored;
  const Hdf5Handle place = open_step(file, *at, path);
  stored.step = static_cast<int>(read_number(place, ".", "step", path));
  stored.load_factor = read_number(place, ".", "load_factor", path);
  stored.displacement = read_values(place, "displacement", count, path);
  if (has(place, "velocity")) stored.velocity = read_values(place, "velocity", count, path);
  if (!stored.velocity.empty()) stored.time = read_number(place, ".", "time", path);
  if (at != names.begin()) stored.previous = read_values(open_step(file, *(at - 1), path), "displacement", count, path);
  return stored;
}

}  // namespace

StoredStep read_step(const fs::path& path, int step, const mesh::SurfaceMesh& mesh) {
  try_in_child(path.string(), [&] { (void)read_unguarded(path, step, mesh); });
  return read_unguarded(path, step, mesh);
}

bool is_results(const fs::path& path) {
  const Silence silence;
  const Hdf5Handle file(H5Fopen(path.string().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  return file.valid() && has(file, "steps");
}

}  // namespace voile::io
