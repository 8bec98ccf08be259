#include "mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "base/child_process.hpp"
#include "base/plain_file.hpp"
#include "element_parts.hpp"
#include "mesh_bytes.hpp"
#include "mesh_text.hpp"
#include "polygon_split.hpp"
#include "triangle_file.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

namespace fs = std::filesystem;

/// Powers up to the third must be numbers.
constexpr double largest = 1e100, smallest_extent = 1e-100;

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

mesh::MeshData from_soup(const std::string& file) {
  geometry::TriangleSoup soup = read_triangles(file);
  mesh::MeshData data;
  data.positions = std::move(soup.positions);
  data.triangles = std::move(soup.triangles);
  if (soup.degenerate_count > 0)
    data.notes.push_back(fmt::format("{} triangle(s) of zero area were dropped", soup.degenerate_count));
  return data;
}

/// Removes vertices without a triangle, and from groups.
void drop_unused(mesh::MeshData& data) {
  std::vector<Index> number(data.positions.size(), no_index);
  for (const mesh::Triangle& t : data.triangles)
    for (const Index v : t) number[v] = 0;
  Index used = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == no_index) continue;
    data.positions[used] = data.positions[v];
    if (v < data.vertex_tags.size()) data.vertex_tags[used] = data.vertex_tags[v];
    number[v] = used++;
  }
  if (used == static_cast<Index>(number.size())) return;
  data.notes.push_back(
      fmt::format("{} vertices without a triangle were dropped", static_cast<Index>(number.size()) - used));
  data.positions.resize(used);
  if (!data.vertex_tags.empty()) data.vertex_tags.resize(used);
  for (mesh::Triangle& t : data.triangles)
    for (Index& v : t) v = number[v];
  for (mesh::Group& g : data.groups) {
    std::erase_if(g.vertices, [&](Index v) { return number[v] == no_index; });
    std::erase_if(g.segments, [&](const auto& s) { return number[s[0]] == no_index || number[s[1]] == no_index; });
    for (Index& v : g.vertices) v = number[v];
    for (mesh::Segment& s : g.segments) s = {number[s[0]], number[s[1]]};
  }
}

void tidy_groups(std::vector<mesh::Group>& groups) {
  for (mesh::Group& g : groups) {
    std::sort(g.vertices.begin(), g.vertices.end());
    g.vertices.erase(std::unique(g.vertices.begin(), g.vertices.end()), g.vertices.end());
    std::sort(g.triangles.begin(), g.triangles.end());
    g.triangles.erase(std::unique(g.triangles.begin(), g.triangles.end()), g.triangles.end());
  }
  std::erase_if(groups, [](const mesh::Group& g) { return g.vertices.empty(); });
}

mesh::Group curve(const std::string& name, const std::vector<mesh::Segment>& segments) {
  mesh::Group g{name, 1, {}, segments, {}};
  for (const mesh::Segment& s : segments) g.vertices.insert(g.vertices.end(), s.begin(), s.end());
  return g;
}

/// Edges that hang together through their ends, those of the greatest length first.
std::vector<std::vector<mesh::Segment>> loops(const std::vector<mesh::Segment>& edges, const std::vector<Vec3>& x) {
  std::map<Index, std::vector<std::size_t>> at;
  for (std::size_t e = 0; e < edges.size(); ++e)
    for (const Index v : edges[e]) at[v].push_back(e);
  std::vector<char> seen(edges.size(), 0);
  std::vector<std::pair<double, std::vector<mesh::Segment>>> found;
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (seen[first]) continue;
    std::vector<std::size_t> members{first};
    seen[first] = 1;
    for (std::size_t k = 0; k < members.size(); ++k)
      for (const Index v : edges[members[k]])
        for (const std::size_t e : at[v])
          if (!seen[e]) {
            seen[e] = 1;
            members.push_back(e);
          }
    std::sort(members.begin(), members.end());
    auto& [length, loop] = found.emplace_back();
    for (const std::size_t e : members) {
      loop.push_back(edges[e]);
      length += (x[edges[e][1]] - x[edges[e][0]]).norm();
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::vector<mesh::Segment>> result;
  for (auto& entry : found) result.push_back(std::move(entry.second));
  return result;
}

bool is_boundary(const mesh::Group& g) {
  return g.name.starts_with("boundary") && g.dimension == 1;
}

void add_boundary(mesh::MeshData& data) {
  const std::vector<mesh::Segment> edges = boundary_edges(data.triangles);
  if (edges.empty() || std::any_of(data.groups.begin(), data.groups.end(), is_boundary)) return;
  data.finds_boundary = true;
  data.groups.push_back(curve("boundary", edges));
  const auto all = loops(edges, data.positions);
  for (std::size_t k = 0; k < all.size() && all.size() > 1; ++k)
    data.groups.push_back(curve(fmt::format("boundary-{}", k + 1), all[k]));
}

mesh::MeshData read_other(const std::string& file, const std::string& extension) {
  mesh::MeshData data = extension == ".obj"   ? read_obj_mesh(file)
                        : extension == ".inp" ? read_abaqus(file)
                        : extension == ".vtk" ? read_vtk(file)
                        : is_nastran(file)    ? read_nastran(file)
                                              : from_soup(file);
  data.source = file;
  if (data.triangles.empty())
    throw UserError(fmt::format("{}: there are no triangles or quadrangles; export the surface as a mesh", file));
  drop_unused(data);
  add_boundary(data);
  tidy_groups(data.groups);
  return data;
}

}  // namespace

void renew_boundary(mesh::MeshData& data) {
  if (!data.finds_boundary) return;
  std::erase_if(data.groups, is_boundary);
  add_boundary(data);
  tidy_groups(data.groups);
}

bool is_nastran(const fs::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".bdf" || extension == ".nas" || extension == ".dat";
}

void check_coordinates(const std::string& what, const std::vector<Vec3>& positions) {
  double extent = 0.0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const double size = positions[v].cwiseAbs().maxCoeff();
    if (!positions[v].allFinite() || size > largest)
      throw UserError(
          fmt::format("{}: vertex {} (counted from 1) lies at ({:g}, {:g}, {:g}): no number to compute with; check "
                      "the file and its scale",
                      what, v + 1, positions[v][0], positions[v][1], positions[v][2]));
    extent = std::max(extent, (positions[v] - positions[0]).cwiseAbs().maxCoeff());
  }
  if (!positions.empty() && extent < smallest_extent)
    throw UserError(fmt::format("{}: all vertices lie within {:g} m; check the file and its scale", what, extent));
}

mesh::MeshData read_mesh(const std::string& file, const MeshOptions& options) {
  const std::string extension = lower_extension(file);
  constexpr std::array<const char*, 6> others{".obj", ".stl", ".ply", ".off", ".vtk", ".inp"};
  mesh::MeshData data;
  if (std::find(others.begin(), others.end(), extension) == others.end() && !is_nastran(file)) {
    data = read_gmsh(file, options);
  } else {
    std::error_code ignored;
    if (!fs::exists(file, ignored)) throw UserError(fmt::format("{}: there is no such mesh file", file));
    require_plain_file(file);
    if (!options.parameters.empty())
      throw UserError(fmt::format("{}: parameters can only be set for a .geo file, not for a finished mesh", file));
    data = mesh_from_bytes(run_in_child(file, [&] { return to_bytes(read_other(file, extension)); }));
    for (Vec3& x : data.positions) x *= options.scale;
  }
  check_coordinates(file, data.positions);
  if (options.placement.is_identity()) return data;
  options.placement.apply(data.positions);
  check_coordinates(file + ", put in place by rotate and translate", data.positions);
  return data;
}

// ---------------------------------------------------------------------------------------------------- shared by
// readers

std::vector<Index> GrowingMesh::add_polygon(const std::vector<Index>& corners, std::size_t tag,
                                            const std::vector<Vec2>& texture) {
  std::vector<Index> made;
  const std::size_t n = corners.size();
  std::vector<Vec3> places(n);
  std::transform(corners.begin(), corners.end(), places.begin(), [&](Index v) { return data.positions[v]; });
  for (const std::array<std::size_t, 3>& local : split_polygon(places)) {
    made.push_back(static_cast<Index>(data.triangles.size()));
    data.triangles.push_back({corners[local[0]], corners[local[1]], corners[local[2]]});
    data.triangle_tags.push_back(tag);
    const Vec2 none = Vec2::Constant(std::nan(""));
    if (texture.size() == n)
      data.texture.push_back({texture[local[0]], texture[local[1]], texture[local[2]]});
    else
      data.texture.push_back({none, none, none});
  }
  split += n > 3 ? 1 : 0;
  return made;
}

void GrowingMesh::note_split() {
  if (split == 0) return;
  data.notes.push_back(
      fmt::format("{} polygons were split into triangles, quadrangles along their shorter diagonals", split));
}

mesh::Group& GrowingMesh::group(const std::string& name, int dimension) {
  const auto found = std::find_if(data.groups.begin(), data.groups.end(),
                                  [&](const mesh::Group& g) { return g.name == name && g.dimension == dimension; });
  if (found != data.groups.end()) return *found;
  data.groups.push_back({name, dimension, {}, {}, {}});
  return data.groups.back();
}

std::vector<mesh::Segment> boundary_edges(const std::vector<mesh::Triangle>& triangles) {
  std::vector<mesh::Segment> edges, single;
  for (const mesh::Triangle& t : triangles)
    for (int s = 0; s < 3; ++s) {
      const Index a = t[s], b = t[(s + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end == i + 1) single.push_back(edges[i]);
    i = end;
  }
  return single;
}

std::string file_text(const std::string& file) {
  std::ifstream in = open_input(file);
  std::stringstream text;
  text << in.rdbuf();
  if (!in.is_open()) throw UserError(fmt::format("{}: the file cannot be read; check its permissions", file));
  if (text.str().empty()) throw UserError(fmt::format("{}: the file is empty; export it again", file));
  return text.str();
}

void fail_in_line(const std::string& file, std::size_t line, const std::string& what) {
  throw UserError(fmt::format("{}:{}: {}", file, line, what));
}

bool parse_number(const std::string& word, double& number) {
  std::string text = word;
  const std::size_t exponent = text.find_first_of("dD");  // of Fortran: 1.0D+2
  if (exponent != std::string::npos && exponent > 0 && text.find_first_of("xX") == std::string::npos)
    text[exponent] = 'e';
  char* end = nullptr;
  number = std::strtod(text.c_str(), &end);
  return !text.empty() && end == text.c_str() + text.size() && std::isfinite(number);
}

bool parse_integer(const std::string& word, long& number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace voile::formats
