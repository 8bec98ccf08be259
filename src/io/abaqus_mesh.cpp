// Sheets from Abaqus input files: *NODE, *ELEMENT, *NSET, *ELSET of one flat part; everything else is passed over.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <sstream>

#include "mesh_text.hpp"
#include "voile/base/error.hpp"

namespace voile::io {

namespace {

using Words = std::vector<std::string>;

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\""), end = text.find_last_not_of(" \t\r\"");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

Words fields(const std::string& line) {
  Words words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, ',');) words.push_back(trimmed(word));
  while (!words.empty() && words.back().empty()) words.pop_back();
  return words;
}

/// Corners of an element type, 0 for one that is no surface element of first order.
int corners_of(const std::string& type) {
  for (const char* name : {"S3", "S3R", "S3RS", "STRI3", "DS3", "M3D3", "R3D3", "SFM3D3", "CPS3", "CPE3"})
    if (type == name) return 3;
  for (const char* name : {"S4", "S4R", "S4R5", "S4RS", "S4RSW", "DS4", "M3D4", "M3D4R", "R3D4", "SFM3D4", "SFM3D4R",
                           "CPS4", "CPS4R", "CPE4", "CPE4R"})
    if (type == name) return 4;
  return 0;
}

class AbaqusReader {
 public:
  explicit AbaqusReader(const std::string& file) : file_(file) {}

  mesh::MeshData run() {
    std::istringstream in(file_text(file_));
    for (std::string text; std::getline(in, text);) {
      ++line_;
      if (text.starts_with("**")) continue;
      if (text.starts_with("*"))
        begin(text);
      else if (!trimmed(text).empty())
        read_data(fields(text));
    }
    add_sets();
    mesh_.data.texture.clear();
    if (mesh_.split > 0)
      mesh_.data.notes.push_back(
          fmt::format("{} quadrangles were split into triangles along their shorter diagonals", mesh_.split));
    return std::move(mesh_.data);
  }

 private:
  enum class Section { other, nodes, elements, node_set, element_set };

  void begin(const std::string& text) {
    const Words words = fields(text);
    const std::string keyword = upper(words[0]);
    std::map<std::string, std::string> parameters;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const std::size_t equal = std::min(words[k].find('='), words[k].size());
      parameters[upper(trimmed(words[k].substr(0, equal)))] =
          equal < words[k].size() ? trimmed(words[k].substr(equal + 1)) : "";
    }
    const auto parameter = [&](const char* name) { return parameters.count(name) ? parameters.at(name) : ""; };
    generate_ = parameters.count("GENERATE") > 0;
    section_ = Section::other;
    if (keyword == "*NODE") {
      section_ = Section::nodes;
      set_ = parameter("NSET");
    } else if (keyword == "*ELEMENT") {
      section_ = Section::elements;
      set_ = parameter("ELSET");
      corners_ = corners_of(upper(parameter("TYPE")));
      if (corners_ == 0)
        fail_in_line(file_, line_,
                     fmt::format("elements of type '{}' are no triangles or quadrangles of first order; export "
                                 "the surface as S3 or S4",
                                 parameter("TYPE")));
    } else if (keyword == "*NSET") {
      section_ = Section::node_set;
      set_ = parameter("NSET");
    } else if (keyword == "*ELSET") {
      section_ = Section::element_set;
      set_ = parameter("ELSET");
    } else if (keyword == "*INCLUDE" || (keyword == "*PART" && ++parts_ > 1)) {
      fail_in_line(file_, line_,
                   fmt::format("{} is not read; write one part, or a flat input file without parts", keyword));
    } else if (keyword == "*INSTANCE") {
      in_instance_ = true;
    } else if (keyword == "*END INSTANCE") {
      in_instance_ = false;
    }
  }

  void read_data(const Words& words) {
    switch (section_) {
      case Section::nodes:
        return add_node(words);
      case Section::elements:
        return add_element(words);
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

  void add_element(const Words& words) {
    if (words.size() != static_cast<std::size_t>(corners_) + 1)
      fail_in_line(file_, line_, fmt::format("the element needs a number and {} nodes", corners_));
    const long tag = integer(words[0]);
    std::vector<Index> corners;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const auto node = nodes_.find(integer(words[k]));
      if (node == nodes_.end()) fail_in_line(file_, line_, fmt::format("there is no node {}", words[k]));
      corners.push_back(node->second);
    }
    if (elements_.count(tag)) fail_in_line(file_, line_, fmt::format("element {} is there twice", tag));
    elements_[tag] = mesh_.add_polygon(corners, static_cast<std::size_t>(tag));
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
    for (const std::string& word : words) {
      const auto named = sets.find(word);
      if (named != sets.end()) {
        const std::vector<long> copy = named->second;
        members.insert(members.end(), copy.begin(), copy.end());
      } else {
        members.push_back(integer(word));
      }
    }
  }

  void add_sets() {
    for (const auto& [name, members] : element_sets_) {
      mesh::Group& group = mesh_.group(name, 2);
      for (const long tag : members)
        if (const auto made = elements_.find(tag); made != elements_.end())
          for (const Index t : made->second) {
            group.triangles.push_back(t);
            group.vertices.insert(group.vertices.end(), mesh_.data.triangles[t].begin(), mesh_.data.triangles[t].end());
          }
    }
    const std::vector<mesh::Segment> edges = boundary_edges(mesh_.data.triangles);
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
      group.dimension = group.segments.empty() ? 0 : 1;
      mesh_.data.groups.push_back(std::move(group));
    }
  }

  const std::string& file_;
  GrowingMesh mesh_;
  Section section_ = Section::other;
  std::string set_;
  int corners_ = 0, parts_ = 0;
  bool generate_ = false, in_instance_ = false;
  std::size_t line_ = 0;
  std::map<long, Index> nodes_;
  std::map<long, std::vector<Index>> elements_;
  std::map<std::string, std::vector<long>> node_sets_, element_sets_;
};

}  // namespace

mesh::MeshData read_abaqus(const std::string& file) {
  return AbaqusReader(file).run();
}

}  // namespace voile::io
