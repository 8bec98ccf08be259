#include "results_catalogue.hpp"

#include <algorithm>
#include <cctype>

#include "voile/errors.hpp"

namespace voile::results {

namespace {

std::string safe_name(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-' && c != '.') c = '_';
  return name;
}

std::string data_path(Centre centre, const std::string& name) {
  return fmt::format("VTKHDF/{}/{}", centre == Centre::vertex ? "PointData" : "CellData", name);
}

}  // namespace

hid_t memory_type(Number n) {
  switch (n) {
    case Number::float64:
      return H5T_NATIVE_DOUBLE;
    case Number::float32:
      return H5T_NATIVE_FLOAT;
    case Number::int64:
      return H5T_NATIVE_INT64;
    case Number::int32:
      return H5T_NATIVE_INT32;
    case Number::uint8:
      break;
  }
  return H5T_NATIVE_UINT8;
}

std::size_t bytes_of(Number n) {
  if (n == Number::uint8) return 1;
  return n == Number::float64 || n == Number::int64 ? 8 : 4;
}

std::size_t Table::add(const std::string& file, const std::string& dataset, std::size_t count) {
  const std::size_t begin = rows;
  pieces.push_back({file, dataset, begin, count});
  rows += count;
  return begin;
}

std::size_t Catalogue::count(std::size_t epoch, Centre centre) const {
  return centre == Centre::vertex ? epochs_[epoch].vertices : epochs_[epoch].triangles;
}

/// Where steps of an epoch without values point to.
std::size_t Catalogue::no_values(Array& a, std::size_t epoch) const {
  const auto [at, is_new] = a.of_epoch.try_emplace(epoch, a.table.rows);
  if (is_new) a.table.rows += count(epoch, a.centre);
  return at->second;
}

/// The array of that name; a new one has no values in the steps that there are.
Array& Catalogue::array(Centre centre, const std::string& path_name, Number number, std::size_t columns) {
  const std::string path = data_path(centre, path_name);
  const auto at = std::find_if(arrays_.begin(), arrays_.end(), [&](const Array& a) { return a.table.path == path; });
  if (at != arrays_.end()) {
    if (at->table.columns != columns)
      throw InternalError(fmt::format("{} has {} and {} components", path, at->table.columns, columns));
    return *at;
  }
  Array& a = arrays_.emplace_back();
  a.table.path = path;
  a.table.number = number;
  a.table.columns = columns;
  a.centre = centre;
  for (const StepPlace& step : steps_) {
    a.begin.push_back(static_cast<std::int64_t>(no_values(a, step.epoch)));
    a.present.push_back(0);
  }
  return a;
}

void Catalogue::add_epoch_array(Centre centre, const std::string& path_name, const std::string& name, Number number,
                                const std::string& dataset) {
  const std::size_t epoch = epochs_.size() - 1;
  Array& a = array(centre, path_name, number, 1);
  a.name = name;
  a.of_epoch[epoch] = a.table.add(epoch_file(epoch), dataset, count(epoch, centre));
}

std::string Catalogue::group_name(const mesh::Group& group) {
  const auto known = group_names_.find({group.name, group.dimension});
  if (known != group_names_.end()) return known->second;
  std::string name = "group_" + safe_name(group.name);
  const bool unchanged = name == "group_" + group.name;
  const auto taken = [&] {
    return std::any_of(group_names_.begin(), group_names_.end(), [&](const auto& g) { return g.second == name; });
  };
  const std::string wanted = name;
  while (taken()) name += "_";
  if (!unchanged || name != wanted)
    renamed_.push_back(fmt::format("'{}' is /{}", group.name,
                                   data_path(group.dimension == 2 ? Centre::triangle : Centre::vertex, name)));
  group_names_[{group.name, group.dimension}] = name;
  return name;
}

void Catalogue::begin_epoch(const mesh::SurfaceMesh& mesh) {
  const std::size_t epoch = epochs_.size();
  const std::string file = epoch_file(epoch);
  EpochPlace& place = epochs_.emplace_back();
  place.vertices = static_cast<std::size_t>(mesh.vertex_count());
  place.triangles = static_cast<std::size_t>(mesh.triangle_count());
  place.point = tables_[points].add(file, "points", place.vertices);
  place.triangle = tables_[types].add(file, "types", place.triangles);
  tables_[connectivity].add(file, "connectivity", 3 * place.triangles);
  tables_[offsets].add(file, "offsets", place.triangles + 1);
  add_epoch_array(Centre::vertex, "partition", "partition", Number::int32, "mesh/partition/vertices");
  add_epoch_array(Centre::triangle, "partition", "partition", Number::int32, "mesh/partition/triangles");
  for (const mesh::Group& group : mesh.groups()) {
    const std::string name = group_name(group);
    add_epoch_array(group.dimension == 2 ? Centre::triangle : Centre::vertex, name, "group:" + group.name,
                    Number::uint8, "masks/" + name);
  }
}

void Catalogue::let_obstacles_move(std::size_t vertices) {
  obstacle_vertices_ = vertices;
  tables_.push_back({"voile/steps/obstacle_positions", Number::float32, 3, 0, {}});
}

void Catalogue::add_step(const StepFields& step, bool moved) {
  const std::size_t epoch = epochs_.size() - 1;
  const std::string file = step_file(steps_.size());
  for (const Field& field : step.fields) {
    const auto columns = static_cast<std::size_t>(field.components);
    Array& a = array(field.centre, shown_name(field.name, field.centre, columns), Number::float64, columns);
    a.name = field.name;
    a.unit = field.unit;
    a.is_field = true;
    if (a.begin.size() > steps_.size()) throw InternalError(fmt::format("field '{}' is there twice", field.name));
    a.begin.push_back(static_cast<std::int64_t>(a.table.add(file, "fields/" + field.name, count(epoch, field.centre))));
    a.present.push_back(1);
  }
  if (obstacle_vertices_ > 0) tables_[obstacles].add(file, "obstacles", obstacle_vertices_);
  steps_.push_back({step.step, step.time, step.load_factor, epoch,
                    moved ? tables_[points].add(file, "points", epochs_[epoch].vertices) : epochs_[epoch].point,
                    step.path, step.bodies});
  for (Array& a : arrays_) {
    if (a.begin.size() == steps_.size()) continue;
    a.begin.push_back(static_cast<std::int64_t>(no_values(a, epoch)));
    a.present.push_back(0);
  }
}

std::vector<const Table*> Catalogue::all_tables() const {
  std::vector<const Table*> all;
  for (const Table& t : tables_) all.push_back(&t);
  for (const Array& a : arrays_) all.push_back(&a.table);
  return all;
}

}  // namespace voile::results
