// Sheets from Abaqus input files: *NODE, *ELEMENT, *NSET, *ELSET of one flat part; everything else is passed over.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "abaqus_words.hpp"
#include "element_parts.hpp"
#include "mesh_text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

using Words = AbaqusWords;

/// Corners and nodes of an element type; none for one that is neither a surface nor a truss, which Gmsh writes for curves.
struct Shape {
  std::size_t corners = 0, nodes = 0;
};

Shape shape_of(const std::string& type) {
  static const std::map<std::string, Shape> shapes = [] {
    std::map<std::string, Shape> all;
    const auto add = [&](Shape shape, std::initializer_list<const char*> names) {
      for (const char* name : names) all[name] = shape;
    };
    add({2, 2}, {"T3D2", "T2D2"});
    add({2, 3}, {"T3D3", "T2D3"});
    add({3, 3}, {"S3", "S3R", "S3RS", "STRI3", "DS3", "M3D3", "R3D3", "SFM3D3", "CPS3", "CPE3"});
    add({3, 6}, {"S6", "STRI65", "DS6", "M3D6", "SFM3D6", "CPS6", "CPE6"});
    add({4, 4}, {"S4", "S4R", "S4R5", "S4RS", "S4RSW", "DS4", "M3D4", "M3D4R", "R3D4", "SFM3D4", "SFM3D4R", "CPS4",
                 "CPS4R", "CPE4", "CPE4R"});
    add({4, 8}, {"S8", "S8R", "S8R5", "DS8", "M3D8", "M3D8R", "SFM3D8", "SFM3D8R", "CPS8", "CPS8R", "CPE8", "CPE8R"});
    add({4, 9}, {"S9R5", "M3D9", "M3D9R"});
    return all;
  }();
  const auto at = shapes.find(type);
  return at == shapes.end() ? Shape{} : at->second;
}

class AbaqusReader {
 public:
  explicit AbaqusReader(std::string file) : file_(std::move(file)) {}

  mesh::MeshData run(const std::string& text) {
    read(text, 0);
    if (mesh_.data.triangles.empty() && !skipped_.empty())
      throw UserError(
          fmt::format("{}: elements of type '{}' are no triangles or quadrangles; export the surface as S3 or S4",
                      file_, skipped_.begin()->first));
    add_sets();
    mesh_.data.texture.clear();
    if (mesh_.split > 0)
      mesh_.data.notes.push_back(
          fmt::format("{} quadrangles were split into triangles along their shorter diagonals", mesh_.split));
    if (second_order_ > 0)
      mesh_.data.notes.push_back(
          fmt::format("{} elements of second order were split into triangles between their nodes", second_order_));
    for (const auto& [type, count] : skipped_)
      if (count > 0)
        mesh_.data.notes.push_back(fmt::format("{} elements of type {} were left out: they are no part of a sheet",
                                               count, type.empty() ? "(none)" : type));
    return std::move(mesh_.data);
  }

 private:
  enum class Section { other, nodes, elements, skipped_elements, node_set, element_set, system };

  /// One file, and those that it includes.
  void read(const std::string& all, int depth) {
    std::istringstream in(all);
    line_ = 0;
    for (std::string text; abaqus_line(in, text, line_);) {
      if (text.starts_with("*"))
        begin(text, depth);
      else if (!abaqus_trimmed(text).empty())
        read_data(abaqus_fields(text));
    }
  }

  /// Its name counts from the folder of the file that includes it, and what is open goes on in it.
  void include(const std::string& name, int depth) {
    if (name.empty() || std::filesystem::path(name).is_absolute())
      fail_in_line(file_, line_, "*INCLUDE needs INPUT = a name beside this file, which does not begin with '/'");
    if (depth >= most_included)
      fail_in_line(file_, line_,
                   fmt::format("files include each other more than {} deep; is it a loop?", most_included));
    const std::string outer = file_;
    const std::size_t line = line_;
    const std::filesystem::path inner = std::filesystem::path(outer).parent_path() / name;
    std::error_code ignored;
    if (!std::filesystem::exists(inner, ignored) || std::filesystem::is_directory(inner, ignored))
      fail_in_line(file_, line_, fmt::format("*INCLUDE: there is no file {}", inner.string()));
    file_ = inner.string();
    read(file_text(file_), depth + 1);
    file_ = outer;
    line_ = line;
  }

  void begin(const std::string& text, int depth) {
    const Words words = abaqus_fields(text);
    const std::string keyword = abaqus_upper(words[0]);
    const std::map<std::string, std::string> parameters = abaqus_parameters(words);
    const auto parameter = [&](const char* name) { return parameters.count(name) ? parameters.at(name) : ""; };
    generate_ = parameters.count("GENERATE") > 0;
    const Section before = section_;
    section_ = Section::other;
    if ((keyword == "*NODE" || keyword == "*ELEMENT") && parameters.count("INPUT") > 0)
      fail_in_line(file_, line_, keyword + ", INPUT: lines of another file are read by *INCLUDE");
    if (keyword.ends_with("GEN") || keyword.ends_with("COPY") || keyword == "*NFILL" || keyword == "*NMAP")
      fail_in_line(file_, line_, keyword + ": nodes and elements that keywords make are not read; write each out");
    if (keyword == "*NODE") {
      section_ = Section::nodes;
      set_ = parameter("NSET");
      if (const std::string system = abaqus_upper(parameter("SYSTEM")); !system.empty() && system != "R")
        fail_in_line(file_, line_,
                     "*NODE, SYSTEM=" + system + ": coordinates along curves are not read; write x, y and z");
    } else if (keyword == "*ELEMENT") {
      section_ = Section::elements;
      set_ = parameter("ELSET");
      type_ = abaqus_upper(parameter("TYPE"));
      shape_ = shape_of(type_);
      if (shape_.corners > 0) return;
      section_ = Section::skipped_elements;
      skipped_.emplace(type_, 0);
    } else if (keyword == "*NSET") {
      section_ = Section::node_set;
      begin_set(parameter("NSET"));
      if (parameters.count("ELSET")) add_nodes_of(parameter("ELSET"));
    } else if (keyword == "*ELSET") {
      section_ = Section::element_set;
      begin_set(parameter("ELSET"));
    } else if (keyword == "*SYSTEM") {
      section_ = Section::system;
    } else if (keyword == "*ASSEMBLY" || keyword == "*END ASSEMBLY") {
      in_assembly_ = keyword == "*ASSEMBLY";
    } else if (keyword == "*INCLUDE") {
      section_ = before;
      include(parameter("INPUT"), depth);
    } else if (keyword == "*PART" && ++parts_ > 1) {
      fail_in_line(file_, line_,
                   fmt::format("{} is not read; write one part, or a flat input file without parts", keyword));
    } else if (keyword == "*INSTANCE") {
      in_instance_ = true;
    } else if (keyword == "*END INSTANCE") {
      in_instance_ = false;
    }
  }

  /// Whatever its capitals.
  template <class Sets>
  [[nodiscard]] static auto find_set(Sets& sets, const std::string& name) {
    const auto exactly = sets.find(name);
    if (exactly != sets.end()) return exactly;
    return std::find_if(sets.begin(), sets.end(),
                        [&](const auto& s) { return abaqus_upper(s.first) == abaqus_upper(name); });
  }

  /// The assembly's sets are others than those of the part, whatever they are called.
  void begin_set(const std::string& name) {
    set_ = name;
    if (!in_assembly_ || !assembly_sets_.insert(abaqus_upper(name)).second) return;
    const auto rename = [&](auto& sets) {
      const auto of_part = find_set(sets, name);
      if (of_part == sets.end()) return;
      auto set = sets.extract(of_part);
      set.key() = abaqus_part_set(set.key());
      sets.insert(std::move(set));
    };
    rename(node_sets_);
    rename(element_sets_);
  }

  void read_data(const Words& words) {
    switch (section_) {
      case Section::system:
        fail_in_line(file_, line_, "*SYSTEM is not read; write the nodes in global axes");
      case Section::nodes:
        return add_node(words);
      case Section::elements:
        return add_element(words);
      case Section::skipped_elements:
        skip_element(words);
        return;
      case Section::node_set:
        return add_members(words, node_sets_[set_]);
      case Section::element_set:
        return add_members(words, element_sets_[set_]);
      case Section::other:
        if (in_instance_) fail_in_line(file_, line_, "an *INSTANCE that is moved is not read; write a flat input file");
    }
  }

  [[nodiscard]] long integer(const std::string& word) const {
    long value = 0;
    if (!parse_integer(word, value) || value < 0)
      fail_in_line(file_, line_, fmt::format("'{}' is no number of a node or element", word));
    return value;
  }

  void add_node(const Words& words) {
    if (words.size() < 3) fail_in_line(file_, line_, "a node needs a number and coordinates");
    const long tag = integer(words[0]);
    Vec3 x = Vec3::Zero();
    for (std::size_t k = 1; k < std::min<std::size_t>(words.size(), 4); ++k)
      if (!parse_number(words[k], x[static_cast<Eigen::Index>(k) - 1]))
        fail_in_line(file_, line_, fmt::format("'{}' is no finite coordinate", words[k]));
    if (!nodes_.emplace(tag, static_cast<Index>(mesh_.data.positions.size())).second)
      fail_in_line(file_, line_, fmt::format("node {} is there twice; write a flat input file without parts", tag));
    mesh_.data.positions.push_back(x);
    mesh_.data.vertex_tags.push_back(static_cast<std::size_t>(tag));
    if (!set_.empty()) node_sets_[set_].push_back(tag);
  }

  /// Elements that other programs know; their numbers may be in sets.
  void skip_element(const Words& words) {
    long tag = 0;
    if (!words.empty() && parse_integer(words[0], tag)) ++skipped_[type_];
  }

  void add_element(const Words& words) {
    if (words.size() != shape_.nodes + 1)
      fail_in_line(file_, line_, fmt::format("the element needs a number and {} nodes", shape_.nodes));
    const long tag = integer(words[0]);
    std::vector<Index> nodes;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const auto node = nodes_.find(integer(words[k]));
      if (node == nodes_.end()) fail_in_line(file_, line_, fmt::format("there is no node {}", words[k]));
      nodes.push_back(node->second);
    }
    // A quadrangle with a node twice is a triangle.
    if (shape_.nodes == 4 && nodes.size() == 4) nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    if (shape_.nodes == 4 && nodes.size() > 1 && nodes.front() == nodes.back()) nodes.pop_back();
    const bool collapsed = shape_.nodes == 4 && nodes.size() == 3;
    if (elements_.count(tag) || lines_.count(tag))
      fail_in_line(file_, line_, fmt::format("element {} is there twice", tag));
    if (shape_.corners > 2 && shape_.nodes > shape_.corners) ++second_order_;
    const Index split_before = mesh_.split;
    for (const std::vector<std::size_t>& part :
         first_order_parts(collapsed ? 3 : shape_.corners, collapsed ? 3 : shape_.nodes)) {
      std::vector<Index> corners;
      for (const std::size_t i : part) corners.push_back(nodes[i]);
      if (shape_.corners == 2) {
        lines_[tag].push_back({corners[0], corners[1]});
        continue;
      }
      const std::vector<Index> made = mesh_.add_polygon(corners, static_cast<std::size_t>(tag));
      elements_[tag].insert(elements_[tag].end(), made.begin(), made.end());
    }
    if (shape_.nodes > shape_.corners) mesh_.split = split_before;  // they have a note of their own
    if (!set_.empty()) element_sets_[set_].push_back(tag);
  }

  /// Numbers, ranges "first, last, step" or names of other sets of the same kind.
  void add_members(const Words& words, std::vector<long>& members) {
    const auto& sets = section_ == Section::node_set ? node_sets_ : element_sets_;
    if (generate_) {
      const long first = integer(words[0]), last = words.size() > 1 ? integer(words[1]) : first;
      const long step = words.size() > 2 ? integer(words[2]) : 1;
      if (step < 1 || last < first || (last - first) / step > 100000000L)
        fail_in_line(file_, line_, "'first, last, step' of GENERATE must ascend");
      for (long k = first; k <= last; k += step) members.push_back(k);
      return;
    }
    for (const std::string& whole : words) {
      long tag = 0;
      const std::string word = abaqus_without_instance(whole);
      const auto named = sets.count(whole) == 0 && parse_integer(word, tag) ? sets.end()
                         : sets.count(whole) > 0                            ? sets.find(whole)
                                                                            : find_set(sets, word);
      if (named != sets.end()) {
        const std::vector<long> copy = named->second;
        members.insert(members.end(), copy.begin(), copy.end());
      } else {
        members.push_back(integer(word));
      }
    }
  }

  /// *NSET, ELSET: the nodes of its elements.
  void add_nodes_of(const std::string& elements) {
    const auto named = find_set(element_sets_, abaqus_without_instance(elements));
    if (named == element_sets_.end())
      fail_in_line(file_, line_, fmt::format("*NSET, ELSET={}: there is no such set above; define it first", elements));
    std::vector<long>& members = node_sets_[set_];
    const auto add = [&](Index node) { members.push_back(static_cast<long>(mesh_.data.vertex_tags[node])); };
    for (const long tag : named->second) {
      if (const auto made = elements_.find(tag); made != elements_.end())
        for (const Index t : made->second)
          for (const Index v : mesh_.data.triangles[static_cast<std::size_t>(t)]) add(v);
      if (const auto made = lines_.find(tag); made != lines_.end())
        for (const mesh::Segment& s : made->second)
          for (const Index v : s) add(v);
    }
  }

  void add_sets() {
    for (const auto& [name, members] : element_sets_) {
      mesh::Group surface{name, 2, {}, {}, {}}, curve{name, 1, {}, {}, {}};
      for (const long tag : members) {
        if (const auto made = elements_.find(tag); made != elements_.end())
          for (const Index t : made->second) {
            surface.triangles.push_back(t);
            const mesh::Triangle& corners = mesh_.data.triangles[static_cast<std::size_t>(t)];
            surface.vertices.insert(surface.vertices.end(), corners.begin(), corners.end());
          }
        if (const auto made = lines_.find(tag); made != lines_.end())
          for (const mesh::Segment& s : made->second) {
            curve.segments.push_back(s);
            curve.vertices.insert(curve.vertices.end(), s.begin(), s.end());
          }
      }
      for (mesh::Group* group : {&surface, &curve})
        if (!group->vertices.empty()) mesh_.data.groups.push_back(std::move(*group));
    }
    const std::vector<mesh::Segment> edges = boundary_edges(mesh_.data.triangles);
    std::set<Index> border;
    for (const mesh::Segment& s : edges) border.insert(s.begin(), s.end());
    for (const auto& [name, members] : node_sets_) {
      std::vector<char> in(mesh_.data.positions.size(), 0);
      mesh::Group group{name, 0, {}, {}, {}};
      for (const long tag : members)
        if (const auto node = nodes_.find(tag); node != nodes_.end()) {
          in[node->second] = 1;
          group.vertices.push_back(node->second);
        }
      for (const mesh::Segment& s : edges)
        if (in[s[0]] && in[s[1]]) group.segments.push_back(s);
      for (std::size_t t = 0; t < mesh_.data.triangles.size(); ++t) {
        const mesh::Triangle& corners = mesh_.data.triangles[t];
        if (in[corners[0]] && in[corners[1]] && in[corners[2]]) group.triangles.push_back(static_cast<Index>(t));
      }
      set_dimension(group, border);
      if (group.dimension != 2 || !is_element_set(group)) mesh_.data.groups.push_back(std::move(group));
    }
  }

  /// Whether an area of nodes is that of elements whose set has its name, as preprocessors write both. One of other nodes becomes
  /// points, which that name may have too.
  [[nodiscard]] bool is_element_set(mesh::Group& group) const {
    const auto same = std::find_if(mesh_.data.groups.begin(), mesh_.data.groups.end(),
                                   [&](const mesh::Group& g) { return g.name == group.name && g.dimension == 2; });
    if (same == mesh_.data.groups.end()) return false;
    if (std::set<Index>(same->vertices.begin(), same->vertices.end()) ==
        std::set<Index>(group.vertices.begin(), group.vertices.end()))
      return true;
    group.dimension = 0;
    group.triangles.clear();
    return false;
  }

  /// An area where its triangles have all nodes: who holds slopes holds those of the area. A curve where all are on the border,
  /// else points.
  void set_dimension(mesh::Group& group, const std::set<Index>& border) const {
    std::set<Index> covered;
    for (const Index t : group.triangles)
      covered.insert(mesh_.data.triangles[static_cast<std::size_t>(t)].begin(),
                     mesh_.data.triangles[static_cast<std::size_t>(t)].end());
    const std::set<Index> all(group.vertices.begin(), group.vertices.end());
    const bool beside = std::includes(border.begin(), border.end(), all.begin(), all.end());
    group.dimension = !all.empty() && covered == all ? 2 : beside && !group.segments.empty() ? 1 : 0;
    if (group.dimension != 1) group.segments.clear();
    if (group.dimension != 2) group.triangles.clear();
  }

  static constexpr int most_included = 8;

  std::string file_;  ///< that is being read
  GrowingMesh mesh_;
  Section section_ = Section::other;
  std::string set_, type_;
  Shape shape_;
  int parts_ = 0;
  bool generate_ = false, in_instance_ = false, in_assembly_ = false;
  std::set<std::string> assembly_sets_;  ///< in capitals
  std::size_t line_ = 0, second_order_ = 0;
  std::map<std::string, std::size_t> skipped_;  ///< elements by their types
  std::map<long, Index> nodes_;
  std::map<long, std::vector<Index>> elements_;
  std::map<long, std::vector<mesh::Segment>> lines_;
  std::map<std::string, std::vector<long>> node_sets_, element_sets_;
};

}  // namespace

mesh::MeshData read_abaqus(const std::string& file) {
  return read_abaqus_text(file, file_text(file));
}

mesh::MeshData read_abaqus_text(const std::string& file, const std::string& text) {
  return AbaqusReader(file).run(text);
}

}  // namespace voile::formats
