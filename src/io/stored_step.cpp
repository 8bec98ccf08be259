#include "voile/io/stored_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "hdf5_read.hpp"
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

StoredStep read_step(const fs::path& path, int step, const mesh::SurfaceMesh& mesh) {
  const Silence silence;
  const Hdf5Handle file(H5Fopen(path.string().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) fail_restart(path, "this is not a results.h5 that can be read");
  check_mesh(file, mesh, path);
  const std::vector<std::string> names = step_names(file);
  if (names.empty()) fail_restart(path, "it has no steps");
  auto at = step < 0 ? names.end() - 1 : std::find(names.begin(), names.end(), fmt::format("{:06d}", step));
  if (at == names.end()) fail_restart(path, fmt::format("it has no step {}; it has {}", step, join(names, ", ")));
  const std::size_t count = 3 * static_cast<std::size_t>(mesh.vertex_count());
  StoredStep stored;
  const std::string place = "steps/" + *at, before = at == names.begin() ? "" : "steps/" + *(at - 1);
  check_link(file, place, path);
  if (!before.empty()) check_link(file, before, path);
  stored.step = static_cast<int>(read_number(file, place, "step", path));
  stored.load_factor = read_number(file, place, "load_factor", path);
  stored.displacement = read_values(file, place + "/displacement", count, path);
  if (!before.empty()) stored.previous = read_values(file, before + "/displacement", count, path);
  return stored;
}

}  // namespace voile::io
