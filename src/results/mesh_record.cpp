#include "mesh_record.hpp"

#include <fmt/format.h>

#include "hdf5_read.hpp"

namespace voile::results {

namespace fs = std::filesystem;

std::vector<Index> read_members(hid_t file, const std::string& name, std::size_t end, const fs::path& path) {
  std::vector<Index> members;
  for (const std::int64_t i : read_integers(file, name, path)) {
    if (i < 0 || static_cast<std::size_t>(i) >= end)
      fail_reading(path, fmt::format("'{}' names number {} of {}: the file is damaged", name, i, end));
    members.push_back(static_cast<Index>(i));
  }
  return members;
}

namespace {

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

std::vector<mesh::Seam> read_seams(hid_t file, const std::string& where, const mesh::MeshData& mesh,
                                   const fs::path& path) {
  std::vector<mesh::Seam> seams;
  if (!has(file, where + "/seams")) return seams;
  for (;;) {
    const std::string at = fmt::format("{}/seams/{:06d}", where, seams.size());
    if (!has(file, at)) return seams;
    mesh::Seam& seam = seams.emplace_back();
    seam.name = read_text(file, at, "name", path);
    seam.pairs = grouped<2>(read_members(file, at + "/pairs", mesh.positions.size(), path));
    seam.lengths = read_values(file, at + "/lengths", seam.pairs.size(), path);
    if (has(file, at + "/stations")) seam.stations = read_values(file, at + "/stations", seam.pairs.size(), path);
  }
}

}  // namespace

void write_mesh_record(NewFile& file, const mesh::MeshData& mesh, const std::string& length) {
  const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
  std::vector<double> flat_points;
  for (const Vec3& x : mesh.positions) flat_points.insert(flat_points.end(), x.begin(), x.end());
  file.group("mesh");
  file.text("mesh", "source", mesh.source);
  file.dataset("mesh/positions", H5T_NATIVE_DOUBLE, vertices, 3, flat_points.data());
  file.text("mesh/positions", "unit", length);
  file.dataset("mesh/triangles", H5T_NATIVE_INT32, triangles, 3, mesh.triangles.data());
  const auto numbers = [&](const char* name, const std::vector<std::size_t>& values) {
    const std::vector<std::int64_t> copy(values.begin(), values.end());
    file.dataset(name, H5T_NATIVE_INT64, copy.size(), 1, copy.data());
  };
  numbers("mesh/vertex_tags", mesh.vertex_tags);
  numbers("mesh/triangle_tags", mesh.triangle_tags);
  std::vector<double> texture;
  for (const auto& corners : mesh.texture)
    for (const Vec2& x : corners) texture.insert(texture.end(), {x[0], x[1]});
  file.dataset("mesh/texture", H5T_NATIVE_DOUBLE, mesh.texture.size(), 6, texture.data());
  std::vector<double> rest;
  for (const auto& corners : mesh.rest)
    for (const Vec3& x : corners) rest.insert(rest.end(), x.begin(), x.end());
  if (!rest.empty()) file.dataset("mesh/rest", H5T_NATIVE_DOUBLE, mesh.rest.size(), 9, rest.data());
  file.group("mesh/groups");
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    const mesh::Group& group = mesh.groups[g];
    const std::string path = fmt::format("mesh/groups/{:06d}", g);
    file.dataset(path + "/vertices", H5T_NATIVE_INT32, group.vertices.size(), 1, group.vertices.data());
    file.dataset(path + "/segments", H5T_NATIVE_INT32, group.segments.size(), 2, group.segments.data());
    file.dataset(path + "/triangles", H5T_NATIVE_INT32, group.triangles.size(), 1, group.triangles.data());
    file.text(path, "name", group.name);
    file.number(path, "dimension", group.dimension);
  }
  for (std::size_t k = 0; k < mesh.seams.size(); ++k) {
    const mesh::Seam& seam = mesh.seams[k];
    const std::string path = fmt::format("mesh/seams/{:06d}", k);
    if (k == 0) file.group("mesh/seams");
    file.dataset(path + "/pairs", H5T_NATIVE_INT32, seam.pairs.size(), 2, seam.pairs.data());
    file.dataset(path + "/lengths", H5T_NATIVE_DOUBLE, seam.lengths.size(), 1, seam.lengths.data());
    if (!seam.stations.empty())
      file.dataset(path + "/stations", H5T_NATIVE_DOUBLE, seam.stations.size(), 1, seam.stations.data());
    file.text(path, "name", seam.name);
  }
  std::vector<Index> folded;
  for (const mesh::TriangleSide& s : mesh.folded) folded.push_back(3 * s.triangle + s.side);
  if (!folded.empty()) file.dataset("mesh/folded", H5T_NATIVE_INT32, folded.size(), 1, folded.data());
}

mesh::MeshData read_mesh_record(hid_t file, const std::string& where, const fs::path& path) {
  mesh::MeshData mesh;
  mesh.source = read_text(file, where, "source", path);
  mesh.positions = points_of(read_all(file, where + "/positions", path));
  mesh.triangles = grouped<3>(read_members(file, where + "/triangles", mesh.positions.size(), path));
  mesh.vertex_tags = read_tags(file, where + "/vertex_tags", path);
  mesh.triangle_tags = read_tags(file, where + "/triangle_tags", path);
  const std::vector<double> texture = read_all(file, where + "/texture", path);
  for (std::size_t i = 0; i + 5 < texture.size(); i += 6)
    mesh.texture.push_back(
        {Vec2(texture[i], texture[i + 1]), Vec2(texture[i + 2], texture[i + 3]), Vec2(texture[i + 4], texture[i + 5])});
  if (has(file, where + "/rest")) {
    const std::vector<Vec3> corners = points_of(read_all(file, where + "/rest", path));
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      mesh.rest.push_back({corners[i], corners[i + 1], corners[i + 2]});
  }
  mesh.groups = read_groups(file, where, mesh, path);
  mesh.seams = read_seams(file, where, mesh, path);
  if (has(file, where + "/folded"))
    for (const Index side : read_members(file, where + "/folded", 3 * mesh.triangles.size(), path))
      mesh.folded.push_back({side / 3, static_cast<int>(side % 3)});
  return mesh;
}

}  // namespace voile::results
