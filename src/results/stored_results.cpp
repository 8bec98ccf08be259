#include "stored_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.hpp"
#include "mesh_record.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace fs = std::filesystem;

namespace {

/// Names of what lies in a group.
std::vector<std::string> names_in(hid_t file, const std::string& group) {
  std::vector<std::string> names;
  if (!has(file, group)) return names;
  const auto take = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  (void)H5Literate_by_name(file, group.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names, H5P_DEFAULT);
  return names;
}

/// How many numbers a row of a table has.
int columns_of(hid_t file, const std::string& name, const fs::path& path) {
  const Hdf5Handle set = open_dataset(file, name, path);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  const int dimensions = space.valid() ? H5Sget_simple_extent_ndims(space) : 0;
  std::array<hsize_t, 2> size{0, 1};
  if (dimensions < 1 || dimensions > 2 || H5Sget_simple_extent_dims(space, size.data(), nullptr) < 0 || size[1] > 9)
    fail_reading(path, fmt::format("'{}' is no table: the file is damaged", name));
  return static_cast<int>(size[1]);
}

/// A list of texts of one length.
std::vector<std::string> read_texts(hid_t file, const std::string& name, const fs::path& path) {
  const Hdf5Handle set = open_dataset(file, name, path);
  const Hdf5Handle type(H5Dget_type(set), H5Tclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  if (!type.valid() || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0)
    fail_reading(path, fmt::format("it has no texts '{}'", name));
  const std::size_t width = H5Tget_size(type), count = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
  std::string all(width * count, '\0');
  if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0)
    fail_reading(path, fmt::format("its texts '{}' cannot be read", name));
  std::vector<std::string> list;
  for (std::size_t at = 0; at < all.size(); at += width) list.emplace_back(all.substr(at, width).c_str());
  return list;
}

}  // namespace

StoredResults::StoredResults(const fs::path& path) : path_(path), file_(open_to_read(path)) {
  if (!file_.valid() || !has(file_, "voile") || !has(file_, "voile/steps"))
    fail_reading(
        path,
        "this is not a results.vtkhdf that can be read: it is of another program, damaged or not whole; copy it again, "
        "or run again");
  if (const double layout = read_number(file_, "voile", "layout", path); layout != layout_version)
    fail_reading(path, fmt::format("it has layout {}, this program reads {}", layout, layout_version));
  complete_ = read_number(file_, "voile", "complete", path) != 0.0;
  read_named();
  if (!complete_) find_unnamed();
}

std::size_t StoredResults::find(int number) const {
  if (steps_.empty()) fail_reading(path_, "it has no steps");
  if (number < 0) return steps_.size() - 1;
  for (std::size_t i = steps_.size(); i-- > 0;)
    if (steps_[i].number == number) return i;
  std::vector<int> numbers;
  for (const StoredStepInfo& s : steps_) numbers.push_back(s.number);
  fail_reading(path_, fmt::format("it has no step {}; it has {}", number, join(numbers, ", ")));
}

/// Calls work(file or group, path of the mesh in it, name for messages).
template <class Work>
void StoredResults::with_epoch(std::size_t epoch, const Work& work) const {
  if (complete_) return work(file_, epoch_path(epoch), path_);
  const fs::path file = path_.parent_path() / epoch_file(epoch);
  const Hdf5Handle opened = open_to_read(file);
  if (!opened.valid()) fail_missing(epoch_file(epoch));
  work(opened, "mesh", file);
}

void StoredResults::check_mesh(std::size_t step, const mesh::SurfaceMesh& mesh) const {
  with_epoch(steps_[step].epoch, [&](hid_t at, const std::string& where, const fs::path& place) {
    results::check_mesh(at, where + "/positions", mesh, place);
  });
}

void StoredResults::read_named() {
  const std::vector<std::int64_t> number = read_integers(file_, "voile/steps/number", path_),
                                  epoch = read_integers(file_, "voile/steps/epoch", path_);
  const std::vector<double> time = read_all(file_, "voile/steps/time", path_),
                            load_factor = read_all(file_, "voile/steps/load_factor", path_);
  if (epoch.size() != number.size() || time.size() != number.size() || load_factor.size() != number.size())
    fail_reading(path_, "its lists of steps differ in length: the file is damaged");
  // What every step has as many numbers of, if any.
  const auto per_step = [&](const char* name) {
    std::vector<std::vector<double>> all(number.size());
    if (number.empty() || H5Lexists(file_, name, H5P_DEFAULT) <= 0) return all;
    const std::vector<double> values = read_all(file_, name, path_);
    const std::size_t each = values.size() % number.size() == 0 ? values.size() / number.size() : 0;
    for (std::size_t i = 0; i < number.size() && each > 0; ++i)
      all[i].assign(&values[i * each], &values[i * each] + each);
    return all;
  };
  std::vector<std::vector<double>> path = per_step("voile/steps/path"), bodies = per_step("voile/steps/bodies");
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (epoch[i] < 0 || !std::isfinite(time[i]) || !std::isfinite(load_factor[i]))
      fail_reading(path_, fmt::format("its record of step {} makes no sense: the file is damaged", number[i]));
    steps_.push_back({static_cast<int>(number[i]), time[i], load_factor[i], static_cast<std::size_t>(epoch[i]),
                      std::move(path[i]), std::move(bodies[i])});
  }
}

/// Steps that were written after the last renewal of the index.
void StoredResults::find_unnamed() {
  const auto all_of = [](const Hdf5Handle& file, const char* name, const fs::path& place) {
    return H5Lexists(file, name, H5P_DEFAULT) > 0 ? read_all(file, name, place) : std::vector<double>();
  };
  for (;;) {
    const fs::path place = path_.parent_path() / step_file(steps_.size());
    if (!fs::exists(place)) return;
    const Hdf5Handle file = open_to_read(place);
    if (!file.valid()) fail_missing(step_file(steps_.size()));
    steps_.push_back({static_cast<int>(read_number(file, "/", "step", place)), read_number(file, "/", "time", place),
                      read_number(file, "/", "load_factor", place),
                      static_cast<std::size_t>(std::max(0.0, read_number(file, "/", "epoch", place))),
                      all_of(file, "path", place), all_of(file, "bodies", place)});
  }
}

std::pair<Hdf5Handle, fs::path> StoredResults::open_step(std::size_t step) const {
  const fs::path place = path_.parent_path() / step_file(step);
  Hdf5Handle file = open_to_read(place);
  if (!file.valid()) fail_missing(step_file(step));
  return {std::move(file), place};
}

std::int64_t StoredResults::read_entry(const std::string& list, std::size_t step) const {
  const auto known = entries_.find(list);
  const std::vector<std::int64_t>& values =
      known != entries_.end() ? known->second : (entries_[list] = read_integers(file_, list, path_));
  if (step >= values.size() || values[step] < 0)
    fail_reading(path_, fmt::format("'{}' lacks step {}: the file is damaged", list, steps_[step].number));
  return values[step];
}

void StoredResults::fail_missing(const std::string& file) const {
  fail_reading(path_,
               fmt::format("its run did not end, so that its data are in {} beside it, which is missing or cannot be "
                           "read; copy the folder steps/ together with results.vtkhdf, or use another step",
                           file));
}

std::vector<FieldInfo> StoredResults::fields(std::size_t step) const {
  std::vector<FieldInfo> found;
  if (!complete_) {
    const auto [file, place] = open_step(step);
    for (const std::string& name : names_in(file, "fields")) {
      const std::string path = "fields/" + name;
      const Centre centre = read_text(file, path, "centre", place) == "vertex" ? Centre::vertex : Centre::triangle;
      found.push_back({name, read_text(file, path, "unit", place), centre, columns_of(file, path, place)});
    }
    return found;
  }
  for (const FieldInfo& f : known_fields())
    if (has_field(f.name, step)) found.push_back(f);
  return found;
}

bool StoredResults::has_field(const std::string& name, std::size_t step) const {
  const std::string present = "voile/steps/has/" + name;
  return (entries_.count(present) > 0 || (has(file_, "voile/steps/has") && has(file_, present))) &&
         read_entry(present, step) != 0;
}

const std::vector<FieldInfo>& StoredResults::known_fields() const {
  if (!known_.empty()) return known_;
  for (const Centre centre : {Centre::vertex, Centre::triangle}) {
    const std::string part = centre == Centre::vertex ? "VTKHDF/PointData" : "VTKHDF/CellData";
    for (const std::string& shown : names_in(file_, part)) {
      const std::string path = part + "/" + shown;
      if (!has(file_, path) || H5Aexists_by_name(file_, path.c_str(), "unit", H5P_DEFAULT) <= 0) continue;
      known_.push_back({read_text(file_, path, "name", path_), read_text(file_, path, "unit", path_), centre,
                        columns_of(file_, path, path_)});
    }
  }
  return known_;
}

std::vector<double> StoredResults::values(std::size_t step, const FieldInfo& field, std::size_t count) const {
  const auto columns = static_cast<std::size_t>(field.components);
  if (!complete_) {
    const auto [file, place] = open_step(step);
    return read_values(file, "fields/" + field.name, columns * count, place);
  }
  const std::string kind = field.centre == Centre::vertex ? "Point" : "Cell",
                    name = shown_name(field.name, field.centre, columns);
  const auto begin =
      static_cast<std::size_t>(read_entry(fmt::format("VTKHDF/Steps/{}DataOffsets/{}", kind, name), step));
  return read_rows(file_, fmt::format("VTKHDF/{}Data/{}", kind, name), {begin, count}, columns, path_);
}

std::optional<std::vector<double>> StoredResults::vectors(std::size_t step, const std::string& name,
                                                          std::size_t vertices) const {
  if (!complete_) {
    const auto [file, place] = open_step(step);
    if (!has(file, "fields/" + name)) return std::nullopt;
  } else if (!has_field(name, step)) {
    return std::nullopt;
  }
  return values(step, {name, "", Centre::vertex, 3}, vertices);
}

StoredMesh StoredResults::mesh(std::size_t epoch) const {
  StoredMesh stored;
  with_epoch(epoch, [&](hid_t at, const std::string& where, const fs::path& place) {
    stored.data = read_mesh_record(at, where, place);
    stored.unit = read_text(at, where + "/positions", "unit", place);
    if (!has(at, where + "/partition")) return;
    const std::vector<std::int64_t> ranks = read_integers(at, where + "/partition/triangles", place);
    stored.triangle_rank.assign(ranks.begin(), ranks.end());
  });
  return stored;
}

ObstacleTriangles StoredResults::obstacles() const {
  if (complete_) return obstacles_in(file_, "voile/obstacles", path_);
  const fs::path file = path_.parent_path() / obstacle_file;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {};
  const Hdf5Handle opened = open_to_read(file);
  if (!opened.valid()) fail_missing(obstacle_file);
  return obstacles_in(opened, "obstacles", file);
}

/// `at`: the group of that name in an open file.
ObstacleTriangles StoredResults::obstacles_in(hid_t file, const std::string& at, const fs::path& place) const {
  ObstacleTriangles o;
  if (!has(file, at)) return o;
  o.positions = points_of(read_all(file, at + "/positions", place));
  o.triangles = grouped<3>(read_members(file, at + "/triangles", o.positions.size(), place));
  for (const std::int64_t i : read_integers(file, at + "/obstacle", place)) o.obstacle.push_back(static_cast<int>(i));
  o.names = read_texts(file, at + "/names", place);
  if (o.obstacle.size() != o.triangles.size()) fail_reading(place, "its obstacles make no sense: the file is damaged");
  o.moves = has(file_, "voile/steps/obstacle_positions");
  return o;
}

std::vector<Vec3> StoredResults::obstacle_positions(std::size_t step, std::size_t count) const {
  if (!complete_) {
    const auto [file, place] = open_step(step);
    return has(file, "obstacles") ? points_of(read_values(file, "obstacles", 3 * count, place)) : std::vector<Vec3>();
  }
  const std::string name = "voile/steps/obstacle_positions";
  if (!has(file_, name)) return {};
  return points_of(read_rows(file_, name, {step * count, count}, 3, path_));
}

bool holds_everything(const fs::path& path) {
  const Hdf5Handle file = open_to_read(path);
  return file.valid() && has(file, "voile") && read_number(file, "voile", "complete", path) != 0.0;
}

}  // namespace voile::results
