// voile-gmsh: reads what only the Gmsh library can, for src/formats/gmsh.cpp and gmsh_view.cpp, and fills polygons, for
// src/formats/gmsh_polygon.cpp; answers with bytes. A program of its own, so that the solver starts without the libraries for
// X and OpenGL that Gmsh needs.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>

#include "base/child_process.hpp"
#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "elements.hpp"
#include "formats/geo_parameters.hpp"
#include "formats/gmsh.hpp"
#include "formats/mesh_bytes.hpp"
#include "outlines.hpp"
#include "polygons.hpp"
#include "script.hpp"
#include "session.hpp"
#include "views.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 3> dimension_names{"point", "curve", "surface"};

/// Gmsh's number of an algorithm.
constexpr double for_quadrangles = 8.0;

void mesh_geo(const std::string& file, const Script& script, const MeshOptions& options) {
  script.open();
  if (options.size > 0.0) {
    for (const char* name : {"Mesh.MeshSizeMin", "Mesh.MeshSizeMax"}) gmsh::option::setNumber(name, options.size);
    gmsh::option::setNumber("Mesh.MeshSizeFactor", 1.0);
  }
  if (options.algorithm > 0) gmsh::option::setNumber("Mesh.Algorithm", options.algorithm);
  double algorithm = 0.0;
  gmsh::option::getNumber("Mesh.Algorithm", algorithm);
  if (algorithm == for_quadrangles)  // it needs a field of crosses, and ends the process without one
    throw UserError(file + ": algorithm 8 of Gmsh is for quadrangles alone; choose another, as 5 or 6");
  gmsh::model::mesh::generate(2);
  check_log(file, "meshing");
}

// ------------------------------------------------------------------------------------------------------ model -> data

/// Version of a .msh file, 0 for a .geo.
double file_version(const std::string& file) {
  std::ifstream in = open_input(file);
  std::string word;
  for (int k = 0; k < 100 && in >> word; ++k)
    if (word == "$MeshFormat") {
      double version = 0.0;
      in >> version;
      return version;
    }
  return 0.0;
}

class Converter {
 public:
  Converter(const std::string& file, double scale) : file_(file), scale_(scale), elements_(file) {
    data_.source = file;
  }

  mesh::MeshData run() {
    (void)elements_.of(3, -1);
    (void)elements_.of(2, -1);
    find_repetitions();
    add_triangles();
    add_vertices();
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    for (const auto& [dimension, tag] : groups)
      if (dimension <= 2) add_group(dimension, tag);
    if (const std::string note = split_note(file_); !note.empty()) data_.notes.push_back(note);
    return std::move(data_);
  }

 private:
  /// Format 2.2 stores an element once for each physical group of its entity, and Gmsh puts every element of an entity
  /// in all groups that occur in it. Repetitions are dropped; where there are none, the groups of the file got mixed
  /// up.
  void find_repetitions() {
    if (const double version = file_version(file_); !(version >= 2.0 && version < 3.0)) return;
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities);
    for (const auto& [dimension, tag] : entities) {
      std::vector<int> groups;
      gmsh::model::getPhysicalGroupsForEntity(dimension, tag, groups);
      if (groups.size() < 2 || dimension > 2) continue;
      const Elements all = elements_.of(dimension, tag);
      const std::size_t n = static_cast<std::size_t>(dimension) + 1;
      std::map<std::vector<std::size_t>, std::size_t> copies;
      for (std::size_t e = 0; e < all.tags.size(); ++e) {
        const auto first = all.nodes.begin() + static_cast<std::ptrdiff_t>(e * n);
        if (copies[{first, first + static_cast<std::ptrdiff_t>(n)}]++ > 0) repeated_.insert(all.tags[e]);
      }
      for (const auto& entry : copies)
        if (entry.second != groups.size()) throw UserError(mixed_groups(dimension, tag, groups));
    }
  }

  [[nodiscard]] std::string mixed_groups(int dimension, int tag, const std::vector<int>& groups) const {
    std::vector<std::string> names;
    for (int g : groups) names.push_back(fmt::format("'{}'", group_name(dimension, g)));
    return fmt::format(
        "{}: the elements of elementary {} {} belong to different physical groups ({}), which format 2.2 cannot tell "
        "apart; give each group its own elementary number (second tag) or save as format 4.1",
        file_, dimension_names[static_cast<std::size_t>(dimension)], tag, join(names, ", "));
  }

  void add_triangles() {
    const Elements all = elements_.all(2);
    std::vector<std::pair<std::size_t, std::size_t>> order;  // tag, position
    for (std::size_t e = 0; e < all.tags.size(); ++e)
      if (!repeated_.count(all.tags[e])) order.emplace_back(all.tags[e], e);
    if (order.empty())
      throw UserError(fmt::format("{}: there are no triangles; mesh a surface (dimension 2){}", file_,
                                  " and, if physical groups are defined, put the surface in one"));
    std::sort(order.begin(), order.end());
    std::vector<std::size_t> used;
    for (const auto& entry : order)
      for (std::size_t i = 0; i < 3; ++i) used.push_back(all.nodes[3 * entry.second + i]);
    data_.vertex_tags = used;
    std::sort(data_.vertex_tags.begin(), data_.vertex_tags.end());
    data_.vertex_tags.erase(std::unique(data_.vertex_tags.begin(), data_.vertex_tags.end()), data_.vertex_tags.end());
    for (std::size_t t = 0; t < order.size(); ++t) {
      data_.triangles.push_back({vertex(used[3 * t]), vertex(used[3 * t + 1]), vertex(used[3 * t + 2])});
      data_.triangle_tags.push_back(order[t].first);
    }
  }

  void add_vertices() {
    data_.positions.assign(data_.vertex_tags.size(), Vec3::Constant(std::nan("")));
    for (const auto& [tag, x] : elements_.nodes())
      if (const Index v = vertex(tag); v != no_index) data_.positions[static_cast<std::size_t>(v)] = scale_ * x;
    for (std::size_t v = 0; v < data_.positions.size(); ++v)
      if (!data_.positions[v].allFinite())
        throw UserError(fmt::format("{}: node {} has no finite coordinates", file_, data_.vertex_tags[v]));
  }

  void add_group(int dimension, int tag) {
    const std::string name = group_name(dimension, tag);
    auto at = std::find_if(data_.groups.begin(), data_.groups.end(),
                           [&](const mesh::Group& g) { return g.name == name && g.dimension == dimension; });
    if (at == data_.groups.end()) {
      data_.groups.push_back({name, dimension, {}, {}, {}});
      at = data_.groups.end() - 1;
    }
    std::vector<int> entities;
    gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, entities);
    for (const int entity : entities) add_entity(*at, elements_.of(dimension, entity));
    if (at->vertices.empty())
      throw UserError(fmt::format("{}: physical {} '{}' has no elements; mesh it or remove the group", file_,
                                  dimension_names[static_cast<std::size_t>(dimension)], name));
    sort_unique(at->vertices);
    sort_unique(at->triangles);
  }

  void add_entity(mesh::Group& group, const Elements& elements) {
    const std::size_t n = static_cast<std::size_t>(group.dimension) + 1;
    for (std::size_t e = 0; e < elements.tags.size(); ++e) {
      if (repeated_.count(elements.tags[e])) continue;
      std::array<Index, 3> v{};
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t node = elements.nodes[n * e + i];
        v[i] = vertex(node);
        if (v[i] == no_index)
          throw UserError(
              fmt::format("{}: physical {} '{}': node {} belongs to no triangle; take it out of the group "
                          "or make it part of the surface (in a .geo: Point{{..}} In Surface{{..}})",
                          file_, dimension_names[n - 1], group.name, node));
        group.vertices.push_back(v[i]);
      }
      if (group.dimension == 1) group.segments.push_back({v[0], v[1]});
      if (group.dimension == 2) add_triangles_of(elements.tags[e], group);
    }
  }

  /// An element that was split has several, which its tag stands for.
  void add_triangles_of(std::size_t tag, mesh::Group& group) const {
    const auto [begin, end] = std::equal_range(data_.triangle_tags.begin(), data_.triangle_tags.end(), tag);
    for (auto at = begin; at != end; ++at)
      group.triangles.push_back(static_cast<Index>(at - data_.triangle_tags.begin()));
  }

  static void sort_unique(std::vector<Index>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }

  [[nodiscard]] static Index position(const std::vector<std::size_t>& tags, std::size_t tag) {
    const auto at = std::lower_bound(tags.begin(), tags.end(), tag);
    return at != tags.end() && *at == tag ? static_cast<Index>(at - tags.begin()) : no_index;
  }
  [[nodiscard]] Index vertex(std::size_t tag) const { return position(data_.vertex_tags, tag); }

  std::string file_;
  double scale_;
  ElementReader elements_;
  mesh::MeshData data_;
  std::set<std::size_t> repeated_;  ///< tags of elements that repeat an earlier one of their entity
};

/// What main() was given by src/formats/gmsh.cpp: the file, whether it is a script, and the options.
std::string read(const std::vector<std::string>& words) {
  const std::string& file = words.at(1);
  const auto number = [](const std::string& text) { return std::strtod(text.c_str(), nullptr); };
  MeshOptions options;
  options.size = number(words.at(3));
  options.algorithm = static_cast<int>(number(words.at(4)));
  options.scale = number(words.at(5));
  for (std::size_t k = 7; k + 1 < words.size(); k += 2) options.parameters[words[k]] = number(words[k + 1]);
  try {
    std::optional<Script> script;
    std::unique_ptr<MemoryFile> bytes;
    if (words.at(2) == "geo")
      script.emplace(file, options.parameters);
    else
      bytes = without_byte_order_mark(file);
    const Session session(rights_of(words.at(6)));
    if (script) {
      mesh_geo(file, *script, options);
    } else {
      gmsh::open(bytes ? bytes->name() : file);
      check_log(file, "reading");
    }
    mesh::MeshData data = Converter(file, options.scale).run();
    if (!session.filtered())
      data.notes.push_back(fmt::format(
          "{}: this system does not filter system calls (seccomp), so that Gmsh has read it with more rights "
          "than it needs; see docs/reference/security.md before you open files of strangers here",
          file));
    return to_bytes(data);
  } catch (const std::string& message) {  // what Gmsh throws
    throw UserError(fmt::format("{}: Gmsh: {}", file, printable(message)));
  }
}

std::string version() {
  // The library tells its version at run time only once it is initialised.
  const Session session(Rights::confined);
  std::string text;
  gmsh::option::getString("General.Version", text);
  return text;
}

}  // namespace

}  // namespace voile::formats

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv, argv + argc);
  return voile::answer_to_parent([&] {
    if (argc == 1) return voile::formats::version();
    if (words.at(2) == "polygons") return voile::formats::fill_polygons(words.at(1));
    if (words.at(2) == "outlines") return voile::formats::outlines_of(words);
    if (words.at(2) == "view") return voile::formats::view_at_points(words.at(1));
    return voile::formats::read(words);
  });
}
