// Meshes, steps and readers for the tests of results; they read with HDF5 itself.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "results/results.hpp"
#include "test_case_kit.hpp"
#include "voile/errors.hpp"

namespace voile::testing {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() : path(fs::temp_directory_path() / fmt::format("voile_results_{}", ::getpid())) { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const fs::path path;
};

/// n x n squares, each cut in two, with groups of all dimensions.
inline mesh::SurfaceMesh plate(Index n) {
  mesh::MeshData data;
  data.source = "plate";
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i) data.positions.emplace_back(i, j, 0.25 * i);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      data.triangles.push_back({a, b, d});
      data.triangles.push_back({a, d, c});
    }
  data.groups = {{"corner", 0, {0}, {}, {}},
                 {"x < 1 & \"y\"/2", 1, {0, 1}, {{0, 1}}, {}},
                 {"first", 2, {0, 1, n + 2}, {}, {0}},
                 {"first", 1, {0, 1}, {{0, 1}}, {}}};
  return mesh::SurfaceMesh(data);
}

inline std::vector<int> ramp(Index n) {
  std::vector<int> values;
  for (Index i = 0; i < n; ++i) values.push_back(i % 3);
  return values;
}

/// A writer with one mesh.
inline results::ResultsWriter begin(const fs::path& folder, const mesh::SurfaceMesh& mesh,
                                    const results::ObstacleTriangles& obstacles = {}) {
  results::ResultsWriter writer(folder, obstacles);
  writer.begin_epoch(mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
  return writer;
}

inline results::StepFields step(const mesh::SurfaceMesh& mesh, int number) {
  const auto values = [&](Index count, int components, double from) {
    std::vector<double> v;
    for (Index i = 0; i < count * components; ++i) v.push_back(from + number + 0.001 * i);
    return v;
  };
  return {number,
          0.1 * number,
          0.2 * number,
          {{"displacement", "m", results::Centre::vertex, 3, values(mesh.vertex_count(), 3, 0.0)},
           {"membrane_force", "N/m", results::Centre::triangle, 3, values(mesh.triangle_count(), 3, 1000.0)},
           {"thickness", "m", results::Centre::triangle, 1, values(mesh.triangle_count(), 1, 2000.0)},
           {"tensor", "1", results::Centre::vertex, 9, values(mesh.vertex_count(), 9, 3000.0)}}};
}

/// Values and shape of a data set, read with HDF5 alone. `shape` stays empty if there is none.
struct DataSet {
  std::vector<hsize_t> shape;
  std::vector<double> values;
};

inline DataSet read(const fs::path& file, const std::string& name) {
  DataSet result;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (f < 0) return result;
  const hid_t set = H5Dopen2(f, name.c_str(), H5P_DEFAULT);
  if (set >= 0) {
    const hid_t space = H5Dget_space(set);
    result.shape.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, result.shape.data(), nullptr);
    result.values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.values.data()) < 0) result.shape.clear();
    H5Sclose(space);
    H5Dclose(set);
  }
  H5Fclose(f);
  return result;
}

/// Rows `begin` to `begin + rows` of a table.
inline std::vector<double> rows(const DataSet& table, double begin, double count) {
  REQUIRE(!table.shape.empty());
  const auto first = static_cast<std::size_t>(begin), number = static_cast<std::size_t>(count);
  const std::size_t columns = table.shape.size() == 1 ? 1 : table.shape[1];
  REQUIRE(first + number <= table.shape[0]);
  return {table.values.begin() + static_cast<std::ptrdiff_t>(first * columns),
          table.values.begin() + static_cast<std::ptrdiff_t>((first + number) * columns)};
}

/// A step put together by the rules of VTKHDF 2.0 and nothing else.
struct VtkStep {
  double time = 0.0;
  std::vector<double> points, connectivity, offsets, types;
};

inline VtkStep vtk_step(const fs::path& file, std::size_t i) {
  const auto entry = [&](const std::string& name) { return read(file, "/VTKHDF/Steps/" + name).values.at(i); };
  const auto part = static_cast<std::size_t>(entry("PartOffsets"));
  REQUIRE(entry("NumberOfParts") == 1.0);
  const auto count = [&](const char* name) { return read(file, fmt::format("/VTKHDF/{}", name)).values.at(part); };
  const double cells = count("NumberOfCells"), first = entry("CellOffsets");
  VtkStep s;
  s.time = entry("Values");
  s.points = rows(read(file, "/VTKHDF/Points"), entry("PointOffsets"), count("NumberOfPoints"));
  s.connectivity =
      rows(read(file, "/VTKHDF/Connectivity"), entry("ConnectivityIdOffsets"), count("NumberOfConnectivityIds"));
  // Offsets has one entry more than cells per part.
  s.offsets = rows(read(file, "/VTKHDF/Offsets"), first + static_cast<double>(part), cells + 1);
  s.types = rows(read(file, "/VTKHDF/Types"), first, cells);
  return s;
}

/// An array of a step, such as "PointData/displacement".
inline std::vector<double> vtk_array(const fs::path& file, std::size_t i, const std::string& name) {
  const std::size_t slash = name.find('/');
  const bool point = name.substr(0, slash) == "PointData";
  const auto part = static_cast<std::size_t>(read(file, "/VTKHDF/Steps/PartOffsets").values.at(i));
  const double count = read(file, point ? "/VTKHDF/NumberOfPoints" : "/VTKHDF/NumberOfCells").values.at(part);
  const std::string offsets = fmt::format("/VTKHDF/Steps/{}Offsets{}", name.substr(0, slash), name.substr(slash));
  return rows(read(file, "/VTKHDF/" + name), read(file, offsets).values.at(i), count);
}

inline std::string read_text(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

inline std::string text_attribute(const fs::path& file, const std::string& object, const char* name) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t a = H5Aopen_by_name(f, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Aget_type(a);
  std::string text(H5Tget_size(type), ' ');
  H5Aread(a, type, text.data());
  H5Tclose(type);
  H5Aclose(a);
  H5Fclose(f);
  return text;
}

inline bool is_ascii(const fs::path& file, const std::string& object, const char* name) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t a = H5Aopen_by_name(f, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), type = H5Aget_type(a);
  const bool ascii = H5Tget_cset(type) == H5T_CSET_ASCII;
  H5Tclose(type);
  H5Aclose(a);
  H5Fclose(f);
  return ascii;
}

/// A list of texts of one length.
inline std::vector<std::string> texts(const fs::path& file, const std::string& name) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen2(f, name.c_str(), H5P_DEFAULT);
  const hid_t type = H5Dget_type(set), space = H5Dget_space(set);
  const std::size_t width = H5Tget_size(type);
  std::string all(width * static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)), ' ');
  H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data());
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
  H5Fclose(f);
  std::vector<std::string> list;
  for (std::size_t at = 0; at < all.size(); at += width) list.emplace_back(all.substr(at, width).c_str());
  return list;
}

/// Text between two others, from a place on.
inline std::string between(const std::string& text, const char* open, const char* close, std::size_t from) {
  const std::size_t begin = text.find(open, from) + std::string(open).size();
  return text.substr(begin, text.find(close, begin) - begin);
}

/// Every data item of the XDMF exists with the dimensions it claims; a hyperslab lies in its dataset, which may have
/// grown. Returns how many items there are.
inline int check_xdmf(const fs::path& folder, const char* name = "results.xdmf") {
  const std::string text = read_text(folder / name), slab = "ItemType=\"HyperSlab\" Dimensions=\"";
  int count = 0;
  std::map<std::string, DataSet> sets;
  for (std::size_t at = text.find("Format=\"HDF\">"); at != std::string::npos;
       at = text.find("Format=\"HDF\">", at + 1), ++count) {
    const std::string where = between(text, ">", "</DataItem>", at);
    const std::size_t begin = text.rfind("<DataItem", at), colon = where.find(':');
    CAPTURE(where);
    REQUIRE(colon != std::string::npos);
    const auto [known, is_new] = sets.try_emplace(where);
    if (is_new) known->second = read(folder / where.substr(0, colon), where.substr(colon + 1));
    const DataSet& set = known->second;
    REQUIRE(!set.shape.empty());
    const std::string size = between(text, "Dimensions=\"", "\"", begin);
    const std::size_t outer = text.rfind("<DataItem ", text.rfind("<DataItem ", begin - 1) - 1);
    const bool part = text.compare(begin - 11, 11, "</DataItem>") == 0;
    if (!part) {
      CHECK(join(set.shape, " ") == size);
      continue;
    }
    std::istringstream numbers(between(text, "Format=\"XML\">", "<", outer));
    const std::vector<hsize_t> three{std::istream_iterator<hsize_t>(numbers), std::istream_iterator<hsize_t>()};
    const std::size_t n = set.shape.size();
    REQUIRE(three.size() == 3 * n);
    CHECK(three[0] + three[2 * n] <= set.shape[0]);
    CHECK(std::stoul(size) == three[0] + three[2 * n]);
    if (n == 2) CHECK((three[1] == 0 && three[5] == set.shape[1]));
    CHECK(between(text, slab.c_str(), "\"", outer) ==
          (n == 1 ? fmt::format("{}", three[2]) : fmt::format("{} {}", three[4], three[5])));
  }
  const auto occurrences = [&](const char* what) {
    int n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
  };
  CHECK(occurrences("<Grid") == occurrences("</Grid>"));
  CHECK(occurrences("<DataItem") == occurrences("</DataItem>"));
  return count;
}

/// A triangle and a square.
inline results::ObstacleTriangles obstacles(bool move) {
  return {{"body", "floor & \xc3\xb6"},
          {{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0}, {-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}},
          {{0, 1, 2}, {3, 4, 5}, {3, 5, 6}},
          {0, 1, 1},
          move};
}

/// Those at a step: everything lies higher by its number.
inline std::vector<Vec3> raised(int number) {
  std::vector<Vec3> points = obstacles(true).positions;
  for (Vec3& x : points) x[2] += number;
  return points;
}

inline std::vector<double> single(const std::vector<Vec3>& points) {
  std::vector<double> values;
  for (const Vec3& x : points)
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(x[k]));
  return values;
}

/// Positions at rest plus displacements, as ParaView gets them.
inline std::vector<double> moved(const mesh::SurfaceMesh& mesh, const results::StepFields& step) {
  std::vector<double> values;
  for (std::size_t v = 0; v < mesh.positions().size(); ++v)
    for (int k = 0; k < 3; ++k)
      values.push_back(
          static_cast<float>(mesh.positions()[v][k] + step.fields[0].values[3 * v + static_cast<std::size_t>(k)]));
  return values;
}

inline std::vector<double> corners(const mesh::SurfaceMesh& mesh) {
  std::vector<double> values;
  for (const mesh::Triangle& t : mesh.triangles()) values.insert(values.end(), t.begin(), t.end());
  return values;
}

}  // namespace voile::testing
