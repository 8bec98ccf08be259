#include "checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/child_process.hpp"
#include "hdf5_file.hpp"
#include "hdf5_read.hpp"
#include "mesh_record.hpp"

namespace voile::results {

namespace {

constexpr std::size_t anchor_numbers = 8;     // of each anchor
constexpr std::size_t path_numbers = 5;       // of a path, and one more where that is not 0
constexpr std::size_t stability_numbers = 4;  // of central differences

/// The vectors of a checkpoint, const or not, under their names in the file.
template <class C>
auto vectors_of(C& c) {
  return std::array{std::pair{"displacement", &c.displacement},
                    std::pair{"velocity", &c.velocity},
                    std::pair{"acceleration", &c.acceleration},
                    std::pair{"previous", &c.previous},
                    std::pair{"previous_velocity", &c.previous_velocity},
                    std::pair{"stiffest_mode", &c.stiffest},
                    std::pair{"contact_push", &c.contact_push}};
}

/// Rest corners, empty where the positions are the rest shape.
std::vector<double> rest_of(const mesh::SurfaceMesh& mesh) {
  std::vector<double> rest;
  for (const auto& corners : mesh.data().rest)
    for (const Vec3& x : corners) rest.insert(rest.end(), x.begin(), x.end());
  return rest;
}

void check_rest(hid_t file, const mesh::SurfaceMesh& mesh, const std::filesystem::path& path) {
  const std::vector<double> own = rest_of(mesh);
  const bool stored_rest = has(file, "mesh/rest");
  bool same = stored_rest == !own.empty();
  if (same && stored_rest) {
    const std::vector<double> stored = read_values(file, "mesh/rest", own.size(), path);
    for (std::size_t i = 0; i < own.size(); ++i) same = same && std::abs(own[i] - stored[i]) <= 1e-9 * mesh.extent();
  }
  if (!same)
    fail_reading(path,
                 "its rest shape is another than that of this case; give the same mesh.rest and mesh.texture_unit");
}

/// Numbers of any count, which a reader is told; nothing if there are none.
void write_counted(NewFile& file, const std::string& name, const std::vector<double>& values) {
  if (values.empty()) return;
  file.number("/", (name + "_count").c_str(), static_cast<double>(values.size()));
  file.dataset(name, H5T_NATIVE_DOUBLE, 1, values.size(), values.data());
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Checkpoint& c, const mesh::SurfaceMesh& mesh) {
  const Silence silence;
  const auto vertices = static_cast<std::size_t>(mesh.vertex_count());
  NewFile file(path, Format::v1_8);
  if (c.remeshings > 0) {
    write_mesh_record(file, mesh.data());
  } else {  // enough to know it again
    std::vector<double> positions;
    for (const Vec3& x : mesh.positions()) positions.insert(positions.end(), x.begin(), x.end());
    file.dataset("mesh/positions", H5T_NATIVE_DOUBLE, vertices, 3, positions.data());
    const std::vector<double> rest = rest_of(mesh);
    if (!rest.empty()) file.dataset("mesh/rest", H5T_NATIVE_DOUBLE, rest.size() / 9, 9, rest.data());
  }
  file.number("/", "step", c.step);
  file.number("/", "time", c.time);
  file.number("/", "next_step", c.next_step);
  file.number("/", "load_factor", c.load_factor);
  file.number("/", "in_equilibrium", c.in_equilibrium ? 1 : 0);
  file.number("/", "remeshings", c.remeshings);
  file.number("/", "too_long", c.too_long);
  file.number("/", "too_short", c.too_short);
  file.number("/", "remeshing_wait", c.remeshing_wait);
  file.number("/", "remeshing_step", c.remeshing_step);
  file.number("/", "positive_tangents", c.positive_tangents);
  file.number("/", "factors_left", c.factors_left);
  file.number("/", "factors_wait", c.wait);
  for (const auto& [name, values] : vectors_of(c))
    if (!values->empty()) file.dataset(name, H5T_NATIVE_DOUBLE, vertices, 3, values->data());
  if (!c.contact_gaps.empty()) {
    file.number("/", "contact_start", c.contact_start);
    file.dataset("contact_gaps", H5T_NATIVE_DOUBLE, vertices, 1, c.contact_gaps.data());
  }
  if (!c.passing.empty()) file.dataset("passing", H5T_NATIVE_DOUBLE, vertices, 1, c.passing.data());
  if (!c.anchors.empty())
    file.dataset("anchors", H5T_NATIVE_DOUBLE, c.anchors.size() / anchor_numbers, anchor_numbers, c.anchors.data());
  if (!c.energy_balance.empty())
    file.dataset("energy_balance", H5T_NATIVE_DOUBLE, 1, c.energy_balance.size(), c.energy_balance.data());
  if (!c.couplings.empty()) {
    file.number("/", "couplings_count", static_cast<double>(c.couplings.size()));
    file.dataset("couplings", H5T_NATIVE_DOUBLE, c.couplings.size() / 2, 2, c.couplings.data());
  }
  write_counted(file, "bodies", c.bodies);
  write_counted(file, "body_places", c.places);
  write_counted(file, "leaks", c.leaks);
  write_counted(file, "slips", c.slips);
  if (!c.stability.empty()) file.dataset("stability", H5T_NATIVE_DOUBLE, 1, c.stability.size(), c.stability.data());
  if (!c.step_start.empty()) file.dataset("step_start", H5T_NATIVE_DOUBLE, 1, c.step_start.size(), c.step_start.data());
  if (!c.path.empty()) file.dataset("path", H5T_NATIVE_DOUBLE, 1, path_numbers, c.path.data());
  if (!c.path.empty() && c.path.back() != 0.0) file.dataset("path_doubted", H5T_NATIVE_DOUBLE, 1, 1, &c.path.back());
  file.number("/", "anchors_count", static_cast<double>(c.anchors.size()));
  file.finish();
}

namespace {

void read_anchors(hid_t file, const mesh::SurfaceMesh& mesh, const std::filesystem::path& path, Checkpoint& c) {
  if (!has(file, "anchors")) return;
  const double count = read_number(file, "/", "anchors_count", path);
  const auto good = [](double number, double end) {
    return number >= 0.0 && number < end && number == std::floor(number);
  };
  if (!good(count, 1e9)) fail_reading(path, "its number of anchors makes no sense");
  c.anchors = read_values(file, "anchors", static_cast<std::size_t>(count), path);
  constexpr std::size_t vertex = 1;
  for (std::size_t i = 0; i + anchor_numbers <= c.anchors.size(); i += anchor_numbers)
    if (!good(c.anchors[i], 1e6) || !good(c.anchors[i + vertex], mesh.vertex_count()) ||
        !good(c.anchors[i + vertex + 1], 2e9))
      fail_reading(path, "its anchors are not those of this mesh");
}

void read_couplings(hid_t file, const mesh::SurfaceMesh& mesh, const std::filesystem::path& path, Checkpoint& c) {
  if (H5Lexists(file, "couplings", H5P_DEFAULT) <= 0) return;
  const double count = read_number(file, "/", "couplings_count", path);
  if (!(count >= 0.0 && count < 1e9)) fail_reading(path, "its number of couplings makes no sense");
  c.couplings = read_values(file, "couplings", static_cast<std::size_t>(count), path);
  for (const double v : c.couplings)
    if (!(v >= 0.0 && v < mesh.vertex_count() && v == std::floor(v)))
      fail_reading(path, "its couplings are not those of this mesh");
}

void read_slips(hid_t file, const mesh::SurfaceMesh& mesh, const std::filesystem::path& path, Checkpoint& c) {
  if (!has(file, "slips")) return;
  const double count = read_number(file, "/", "slips_count", path), triangles = mesh.triangle_count();
  if (!(count > 1.0 && count < 1e9 && std::fmod(count - 1.0, triangles) == 0.0))
    fail_reading(path, "its slips inside the fabric are not those of this mesh");
  c.slips = read_values(file, "slips", static_cast<std::size_t>(count), path);
  for (const double v : c.slips)
    if (!std::isfinite(v)) fail_reading(path, "its slips inside the fabric make no sense");
}

/// Fraction that is left and loss of each gas.
void read_leaks(hid_t file, const std::filesystem::path& path, Checkpoint& c) {
  if (!has(file, "leaks")) return;
  const double count = read_number(file, "/", "leaks_count", path);
  if (!(count >= 2.0 && count < 1e6 && 0.5 * count == std::floor(0.5 * count)))
    fail_reading(path, "its number of gases makes no sense");
  c.leaks = read_values(file, "leaks", static_cast<std::size_t>(count), path);
  for (std::size_t i = 0; i < c.leaks.size(); ++i)
    if (!std::isfinite(c.leaks[i]) || (i % 2 == 0 && !(c.leaks[i] > 0.0)))
      fail_reading(path, "what it has left of gases makes no sense");
}

/// What write_counted() has written, none in older files. `what`: for messages.
std::vector<double> read_counted(hid_t file, const std::string& name, const std::filesystem::path& path,
                                 const char* what) {
  if (!has(file, name)) return {};
  const double count = read_number(file, "/", (name + "_count").c_str(), path);
  if (!(count >= 1.0 && count < 1e9 && count == std::floor(count)))
    fail_reading(path, fmt::format("its number of {} makes no sense", what));
  std::vector<double> values = read_values(file, name, static_cast<std::size_t>(count), path);
  for (const double v : values)
    if (!std::isfinite(v)) fail_reading(path, fmt::format("its {} make no sense", what));
  return values;
}

/// Older files have fewer numbers.
std::vector<double> read_balance(hid_t file, const std::filesystem::path& path) {
  constexpr std::size_t fewest = 13, most = 18;
  return read_values(file, "energy_balance", std::clamp(count_values(file, "energy_balance", path), fewest, most),
                     path);
}

Hdf5Handle open_checkpoint(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    fail_reading(
        path,
        "there is no such file; a run writes one at its end, when it is stopped by a signal that it can see, every "
        "[time] checkpoint_minutes and, in a motion, every checkpoint_steps; the results.vtkhdf of a run that was "
        "killed "
        "serves as well");
  Hdf5Handle file = open_to_read(path);
  if (!file.valid()) fail_reading(path, "this is not a checkpoint that can be read");
  return file;
}

/// Those of the sheet. Every state has places, and one with accelerations has velocities.
void read_vectors(hid_t file, std::size_t count, const std::filesystem::path& path, Checkpoint& c) {
  for (const auto& [name, values] : vectors_of(c))
    if (has(file, name)) *values = read_values(file, name, count, path);
  if (c.displacement.empty() || (c.velocity.empty() && !c.acceleration.empty()))
    fail_reading(
        path, fmt::format("it has no '{}': the file is damaged", c.displacement.empty() ? "displacement" : "velocity"));
}

Checkpoint read_unguarded(const std::filesystem::path& path, const mesh::SurfaceMesh& mesh) {
  const Silence silence;
  const Hdf5Handle file = open_checkpoint(path);
  check_mesh(file, "mesh/positions", mesh, path);
  check_rest(file, mesh, path);
  if (H5Aexists(file, "in_equilibrium") <= 0)
    fail_reading(path,
                 "it is not a checkpoint; a run continues from checkpoint.h5 of an earlier one, written every [time] "
                 "checkpoint_steps or checkpoint_minutes and when it ends");
  const std::size_t count = 3 * static_cast<std::size_t>(mesh.vertex_count());
  Checkpoint c;
  c.step = static_cast<int>(read_number(file, "/", "step", path));
  c.time = read_number(file, "/", "time", path);
  c.next_step = read_number(file, "/", "next_step", path);
  c.load_factor = read_number(file, "/", "load_factor", path);
  c.in_equilibrium = read_number(file, "/", "in_equilibrium", path) != 0.0;
  read_vectors(file, count, path, c);
  if (H5Aexists(file, "remeshings") > 0) {
    c.remeshings = static_cast<int>(read_number(file, "/", "remeshings", path));
    c.too_long = read_number(file, "/", "too_long", path);
    c.too_short = read_number(file, "/", "too_short", path);
  }
  if (H5Aexists(file, "remeshing_wait") > 0) {
    c.remeshing_wait = static_cast<int>(read_number(file, "/", "remeshing_wait", path));
    c.remeshing_step = static_cast<int>(read_number(file, "/", "remeshing_step", path));
  }
  if (H5Aexists(file, "positive_tangents") > 0) {
    c.positive_tangents = static_cast<int>(read_number(file, "/", "positive_tangents", path));
    c.factors_left = static_cast<int>(read_number(file, "/", "factors_left", path));
    c.wait = static_cast<int>(read_number(file, "/", "factors_wait", path));
  }
  if (has(file, "contact_gaps")) {
    c.contact_start = read_number(file, "/", "contact_start", path);
    c.contact_gaps = read_values(file, "contact_gaps", static_cast<std::size_t>(mesh.vertex_count()), path);
  }
  if (has(file, "passing"))
    c.passing = read_values(file, "passing", static_cast<std::size_t>(mesh.vertex_count()), path);
  if (has(file, "energy_balance")) c.energy_balance = read_balance(file, path);
  if (has(file, "stability")) c.stability = read_values(file, "stability", stability_numbers, path);
  for (const double number : c.stability)
    if (!(number > 0.0 && std::isfinite(number) && c.stability[1] < 1e6 && c.stability[2] < 1e6))
      fail_reading(path, "its memory of central differences makes no sense");
  if (has(file, "step_start")) c.step_start = read_values(file, "step_start", 2, path);
  for (const double number : c.step_start)
    if (!std::isfinite(number) || !(c.step_start[1] > 0.0)) fail_reading(path, "its last step makes no sense");
  if (has(file, "path")) {
    c.path = read_values(file, "path", path_numbers, path);
    c.path.push_back(has(file, "path_doubted") ? read_values(file, "path_doubted", 1, path).front() : 0.0);
  }
  for (const double number : c.path)
    if (!std::isfinite(number) || std::abs(c.path[0]) > 1e9 || std::abs(c.path[3]) > 1e9)
      fail_reading(path, "its memory of the path makes no sense");
  read_anchors(file, mesh, path, c);
  read_couplings(file, mesh, path, c);
  read_slips(file, mesh, path, c);
  c.bodies = read_counted(file, "bodies", path, "unknowns of rigid groups");
  c.places = read_counted(file, "body_places", path, "places of rigid groups");
  read_leaks(file, path, c);
  return c;
}

mesh::MeshData read_mesh_unguarded(const std::filesystem::path& path) {
  const Silence silence;
  const Hdf5Handle file = open_checkpoint(path);
  if (H5Aexists(file, "remeshings") <= 0 || read_number(file, "/", "remeshings", path) == 0.0) return {};
  return read_mesh_record(file, "mesh", path);
}

}  // namespace

mesh::MeshData read_checkpoint_mesh(const std::filesystem::path& path) {
  try_in_child(path.string(), [&] { (void)read_mesh_unguarded(path); });
  return read_mesh_unguarded(path);
}

Checkpoint read_checkpoint(const std::filesystem::path& path, const mesh::SurfaceMesh& mesh) {
  try {
    try_in_child(path.string(), [&] { (void)read_unguarded(path, mesh); });
    return read_unguarded(path, mesh);
  } catch (const UserError& e) {
    rethrow_for_restart(e);
  }
}

}  // namespace voile::results
