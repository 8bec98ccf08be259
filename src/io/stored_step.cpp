#include "voile/io/stored_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "hdf5_read.hpp"
#include "results_catalogue.hpp"
#include "voile/base/child_process.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"

namespace voile::io {

namespace {

namespace fs = std::filesystem;

bool has(hid_t place, const std::string& name) {
  return H5Lexists(place, name.c_str(), H5P_DEFAULT) > 0;
}

Hdf5Handle open_file(const fs::path& file) {
  return {H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
}

struct StepRecord {
  int number = 0;
  double time = 0.0, load_factor = 0.0;
  std::size_t epoch = 0;
};

/// A results.vtkhdf: either it holds everything, or the data are read from steps/ beside it.
class StoredResults {
 public:
  explicit StoredResults(const fs::path& path) : path_(path), file_(open_file(path)) {
    if (!file_.valid() || !has(file_, "voile") || !has(file_, "voile/steps"))
      fail_restart(path, "this is not a results.vtkhdf that can be read");
    if (const double layout = read_number(file_, "voile", "layout", path); layout != layout_version)
      fail_restart(path, fmt::format("it has layout {}, this program reads {}", layout, layout_version));
    complete_ = read_number(file_, "voile", "complete", path) != 0.0;
    read_named();
    if (!complete_) find_unnamed();
    if (steps_.empty()) fail_restart(path, "it has no steps");
  }

  [[nodiscard]] const std::vector<StepRecord>& steps() const { return steps_; }

  /// The last step of that number; negative: the last step.
  [[nodiscard]] std::size_t find(int number) const {
    if (number < 0) return steps_.size() - 1;
    for (std::size_t i = steps_.size(); i-- > 0;)
      if (steps_[i].number == number) return i;
    std::vector<int> numbers;
    for (const StepRecord& s : steps_) numbers.push_back(s.number);
    fail_restart(path_, fmt::format("it has no step {}; it has {}", number, join(numbers, ", ")));
  }

  /// A vector field on vertices; nothing if the step does not have it.
  [[nodiscard]] std::optional<std::vector<double>> field(std::size_t step, const std::string& name,
                                                         std::size_t vertices) const {
    if (!complete_) {
      const auto [file, place] = open_step(step);
      if (!has(file, "fields/" + name)) return std::nullopt;
      return read_values(file, "fields/" + name, 3 * vertices, place);
    }
    const std::string present = "voile/steps/has/" + name;
    if (!has(file_, "voile/steps/has") || !has(file_, present) || read_entry(present, step) == 0) return std::nullopt;
    const auto begin = static_cast<std::size_t>(read_entry("VTKHDF/Steps/PointDataOffsets/" + name, step));
    return read_rows(file_, "VTKHDF/PointData/" + name, {begin, vertices}, 3, path_);
  }

  void check_mesh(std::size_t step, const mesh::SurfaceMesh& mesh) const {
    with_epoch(steps_[step].epoch, [&](hid_t at, const std::string& where, const fs::path& place) {
      io::check_mesh(at, where + "/positions", mesh, place);
    });
  }

  /// Calls work(file or group, path of the mesh in it, name for messages).
  template <class Work>
  void with_epoch(std::size_t epoch, const Work& work) const {
    if (complete_) return work(file_, epoch_path(epoch), path_);
    const fs::path file = path_.parent_path() / epoch_file(epoch);
    const Hdf5Handle opened = open_file(file);
    if (!opened.valid()) fail_missing(epoch_file(epoch));
    work(opened, "mesh", file);
  }

 private:
  void read_named() {
    const std::vector<std::int64_t> number = read_integers(file_, "voile/steps/number", path_),
                                    epoch = read_integers(file_, "voile/steps/epoch", path_);
    const std::vector<double> time = read_all(file_, "voile/steps/time", path_),
                              load_factor = read_all(file_, "voile/steps/load_factor", path_);
    if (epoch.size() != number.size() || time.size() != number.size() || load_factor.size() != number.size())
      fail_restart(path_, "its lists of steps differ in length: the file is damaged");
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (epoch[i] < 0 || !std::isfinite(time[i]) || !std::isfinite(load_factor[i]))
        fail_restart(path_, fmt::format("its record of step {} makes no sense: the file is damaged", number[i]));
      steps_.push_back({static_cast<int>(number[i]), time[i], load_factor[i], static_cast<std::size_t>(epoch[i])});
    }
  }

  /// Steps that were written after the last renewal of the index.
  void find_unnamed() {
    for (;;) {
      const fs::path place = path_.parent_path() / step_file(steps_.size());
      if (!fs::exists(place)) return;
      const Hdf5Handle file = open_file(place);
      if (!file.valid()) fail_missing(step_file(steps_.size()));
      steps_.push_back({static_cast<int>(read_number(file, "/", "step", place)), read_number(file, "/", "time", place),
                        read_number(file, "/", "load_factor", place),
                        static_cast<std::size_t>(std::max(0.0, read_number(file, "/", "epoch", place)))});
    }
  }

  [[nodiscard]] std::pair<Hdf5Handle, fs::path> open_step(std::size_t step) const {
    const fs::path place = path_.parent_path() / step_file(step);
    Hdf5Handle file = open_file(place);
    if (!file.valid()) fail_missing(step_file(step));
    return {std::move(file), place};
  }

  [[nodiscard]] std::int64_t read_entry(const std::string& list, std::size_t step) const {
    const std::vector<std::int64_t> values = read_integers(file_, list, path_);
    if (step >= values.size() || values[step] < 0)
      fail_restart(path_, fmt::format("'{}' says nothing of step {}: the file is damaged", list, steps_[step].number));
    return values[step];
  }

  [[noreturn]] void fail_missing(const std::string& file) const {
    fail_restart(path_,
                 fmt::format("its run did not end, so that its data are in {} beside it, which is missing or cannot be "
                             "read; copy the folder steps/ together with results.vtkhdf, or use another step",
                             file));
  }

  fs::path path_;
  Hdf5Handle file_;
  bool complete_ = false;
  std::vector<StepRecord> steps_;
};

bool holds_everything(const fs::path& path) {
  const Hdf5Handle file = open_file(path);
  return file.valid() && has(file, "voile") && read_number(file, "voile", "complete", path) != 0.0;
}

/// Calls work(results); once more if the run ended meanwhile and took steps/ away.
template <class Work>
auto with_results(const fs::path& path, const Work& work) {
  const Silence silence;
  const bool complete = holds_everything(path);
  try {
    return work(StoredResults(path));
  } catch (const UserError&) {
    if (complete || !holds_everything(path)) throw;
    return work(StoredResults(path));
  }
}

StoredStep step_of(const StoredResults& results, const fs::path& path, int number, const mesh::SurfaceMesh& mesh) {
  const std::size_t at = results.find(number);
  const StepRecord& record = results.steps()[at];
  results.check_mesh(at, mesh);
  const auto vertices = static_cast<std::size_t>(mesh.vertex_count());
  std::optional<std::vector<double>> u = results.field(at, "displacement", vertices);
  if (!u) fail_restart(path, fmt::format("its step {} has no 'displacement'", record.number));
  StoredStep stored;
  stored.step = record.number;
  stored.load_factor = record.load_factor;
  stored.displacement = std::move(*u);
  stored.velocity = results.field(at, "velocity", vertices).value_or(std::vector<double>());
  if (!stored.velocity.empty()) stored.time = record.time;
  if (at > 0 && results.steps()[at - 1].epoch == record.epoch)
    stored.previous = results.field(at - 1, "displacement", vertices).value_or(std::vector<double>());
  return stored;
}

/// Numbers of vertices or triangles below `end`.
std::vector<Index> read_members(hid_t file, const std::string& name, std::size_t end, const fs::path& path) {
  std::vector<Index> members;
  for (const std::int64_t i : read_integers(file, name, path)) {
    if (i < 0 || static_cast<std::size_t>(i) >= end)
      fail_restart(path, fmt::format("'{}' names number {} of {}: the file is damaged", name, i, end));
    members.push_back(static_cast<Index>(i));
  }
  return members;
}

template <std::size_t n>
std::vector<std::array<Index, n>> grouped(const std::vector<Index>& members) {
  std::vector<std::array<Index, n>> tuples(members.size() / n);
  for (std::size_t i = 0; i < n * tuples.size(); ++i) tuples[i / n][i % n] = members[i];
  return tuples;
}

std::vector<std::size_t> read_tags(hid_t file, const std::string& name, const fs::path& path) {
  const std::vector<std::int64_t> values = read_integers(file, name, path);
  return {values.begin(), values.end()};
}

std::vector<mesh::Group> read_groups(hid_t file, const std::string& where, const mesh::MeshData& mesh,
                                     const fs::path& path) {
  std::vector<mesh::Group> groups;
  for (;;) {
    const std::string at = fmt::format("{}/groups/{:06d}", where, groups.size());
    if (!has(file, at)) return groups;
    mesh::Group& group = groups.emplace_back();
    group.name = read_text(file, at, "name", path);
    group.dimension = static_cast<int>(read_number(file, at, "dimension", path));
    group.vertices = read_members(file, at + "/vertices", mesh.positions.size(), path);
    group.segments = grouped<2>(read_members(file, at + "/segments", mesh.positions.size(), path));
    group.triangles = read_members(file, at + "/triangles", mesh.triangles.size(), path);
  }
}

mesh::MeshData read_record(hid_t file, const std::string& where, const fs::path& path) {
  mesh::MeshData mesh;
  mesh.source = read_text(file, where, "source", path);
  const std::vector<double> x = read_all(file, where + "/positions", path);
  for (std::size_t i = 0; i + 2 < x.size(); i += 3) mesh.positions.emplace_back(x[i], x[i + 1], x[i + 2]);
  mesh.triangles = grouped<3>(read_members(file, where + "/triangles", mesh.positions.size(), path));
  mesh.vertex_tags = read_tags(file, where + "/vertex_tags", path);
  mesh.triangle_tags = read_tags(file, where + "/triangle_tags", path);
  const std::vector<double> texture = read_all(file, where + "/texture", path);
  for (std::size_t i = 0; i + 5 < texture.size(); i += 6)
    mesh.texture.push_back(
        {Vec2(texture[i], texture[i + 1]), Vec2(texture[i + 2], texture[i + 3]), Vec2(texture[i + 4], texture[i + 5])});
  mesh.groups = read_groups(file, where, mesh, path);
  return mesh;
}

mesh::MeshData mesh_of(const StoredResults& results, int number) {
  mesh::MeshData mesh;
  results.with_epoch(
      results.steps()[results.find(number)].epoch,
      [&](hid_t at, const std::string& where, const fs::path& place) { mesh = read_record(at, where, place); });
  return mesh;
}

/// Does it in a process of its own first: HDF5 can crash on a damaged file.
template <class Work>
auto guarded(const fs::path& path, const Work& work) {
  try_in_child(path.string(), [&] { (void)with_results(path, work); });
  return with_results(path, work);
}

}  // namespace

StoredStep read_step(const fs::path& path, int step, const mesh::SurfaceMesh& mesh) {
  return guarded(path, [&](const StoredResults& results) { return step_of(results, path, step, mesh); });
}

mesh::MeshData read_step_mesh(const fs::path& path, int step) {
  return guarded(path, [&](const StoredResults& results) { return mesh_of(results, step); });
}

bool is_results(const fs::path& path) {
  const Silence silence;
  const Hdf5Handle file = open_file(path);
  return file.valid() && has(file, "voile");
}

}  // namespace voile::io
