// Sheets from OBJ files: faces with texture coordinates, groups, polylines.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "mesh_text.hpp"
#include "obj_sheet.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

class ObjReader {
 public:
  explicit ObjReader(const std::string& file) : file_(file) {}

  /// A line of stitches is kept as it is.
  struct StitchLine {
    std::vector<std::string> words;
    std::size_t line;
  };

  void run() {
    std::istringstream in(file_text(file_));
    std::string text;
    while (std::getline(in, text)) {
      ++line_;
      // A line that ends with a backslash goes on.
      while (text.ends_with("\\") || text.ends_with("\\\r")) {
        text.erase(text.rfind('\\'));
        std::string more;
        if (!std::getline(in, more)) break;
        ++line_;
        text += " " + more;
      }
      read_line(text.substr(0, text.find('#')));
    }
    if (!textured_) mesh_.data.texture.clear();
  }

  mesh::MeshData take_mesh() {
    mesh_.note_split();
    if (!stitches_.empty())
      mesh_.data.notes.push_back(
          fmt::format("{} lines 'stitch' are passed over, and what they sew stays apart; mesh.merge joins vertices at "
                      "the same place, a [[spring]] of type 'pair' pulls others together, and pieces that are cut by "
                      "[[panel]] are sewn there",
                      stitches_.size()));
    return std::move(mesh_.data);
  }

  ObjSheet take_sheet() {
    ObjSheet sheet{std::move(mesh_.data), {}};
    for (const StitchLine& s : stitches_) sheet.stitches.push_back(stitch(s, sheet.mesh.positions.size()));
    return sheet;
  }

 private:
  [[nodiscard]] PointStitch stitch(const StitchLine& s, std::size_t vertices) const {
    std::array<long, 3> v{};
    for (std::size_t i = 0; i < 3; ++i)
      if (i >= s.words.size() || !parse_integer(s.words[i], v[i]) || v[i] < 0 || v[i] >= static_cast<long>(vertices))
        fail_in_line(file_, s.line,
                     fmt::format("three vertices must follow 'stitch', counted from 0; there are {}", vertices));
    PointStitch found{static_cast<Index>(v[0]), static_cast<Index>(v[1]), static_cast<Index>(v[2]), 0.0, s.line};
    if (s.words.size() != 4 || !parse_number(s.words[3], found.fraction) || found.fraction < 0.0 ||
        found.fraction > 1.0)
      fail_in_line(file_, s.line, "a fraction from 0 to 1 must follow the vertices of 'stitch', and nothing more");
    return found;
  }

  void read_line(const std::string& text) {
    std::istringstream words(text);
    std::string keyword, word;
    std::vector<std::string> rest;
    if (!(words >> keyword)) return;
    while (words >> word) rest.push_back(word);
    if (keyword == "v") mesh_.data.positions.emplace_back(number(rest, 0), number(rest, 1), number(rest, 2));
    if (keyword == "vt") texture_.emplace_back(number(rest, 0), rest.size() > 1 ? number(rest, 1) : 0.0);
    if (keyword == "f") add_face(rest);
    if (keyword == "l") add_line(rest);
    if (keyword == "g") groups_ = rest;
    if (keyword == "stitch") stitches_.push_back({rest, line_});
    if (keyword == "o") object_ = rest.empty() ? "" : rest[0];
    if (keyword == "usemtl") material_ = rest.empty() ? "" : rest[0];
  }

  [[nodiscard]] double number(const std::vector<std::string>& words, std::size_t k) const {
    double x = 0.0;
    if (k >= words.size() || !parse_number(words[k], x)) fail_in_line(file_, line_, "finite numbers must follow");
    return x;
  }

  /// A number of a list that has `count` entries so far; from 1, or from -1 backwards.
  [[nodiscard]] Index index(const std::string& word, std::size_t count, const char* what) const {
    long i = 0;
    if (!parse_integer(word, i) || i == 0 || std::abs(i) > static_cast<long>(count))
      fail_in_line(file_, line_, fmt::format("'{}' is no number of one of {} {}", word, count, what));
    return static_cast<Index>(i > 0 ? i - 1 : static_cast<long>(count) + i);
  }

  void add_face(const std::vector<std::string>& words) {
    if (words.size() < 3) fail_in_line(file_, line_, "a face needs three corners or more; remove it");
    std::vector<Index> corners;
    std::vector<Vec2> texture;
    for (const std::string& word : words) {
      const std::size_t first = std::min(word.find('/'), word.size()),
                        second = std::min(word.find('/', first + 1), word.size());
      corners.push_back(index(word.substr(0, first), mesh_.data.positions.size(), "vertices"));
      if (second > first + 1)
        texture.push_back(
            texture_[index(word.substr(first + 1, second - first - 1), texture_.size(), "texture coordinates")]);
    }
    textured_ = textured_ || !texture.empty();
    const std::vector<Index> made = mesh_.add_polygon(corners, ++faces_, texture);
    std::vector<std::string> names = groups_;
    for (const std::string& name : {object_, material_})
      if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    for (const std::string& name : names) {
      mesh::Group& group = mesh_.group(name, 2);
      group.triangles.insert(group.triangles.end(), made.begin(), made.end());
      group.vertices.insert(group.vertices.end(), corners.begin(), corners.end());
    }
  }

  void add_line(const std::vector<std::string>& words) {
    std::vector<Index> corners;
    for (const std::string& word : words)
      corners.push_back(index(word.substr(0, word.find('/')), mesh_.data.positions.size(), "vertices"));
    for (const std::string& name : groups_) {
      mesh::Group& group = mesh_.group(name, 1);
      group.vertices.insert(group.vertices.end(), corners.begin(), corners.end());
      for (std::size_t k = 1; k < corners.size(); ++k) group.segments.push_back({corners[k - 1], corners[k]});
    }
  }

  const std::string& file_;
  GrowingMesh mesh_;
  std::vector<Vec2> texture_;
  std::vector<std::string> groups_;
  std::string object_, material_;
  std::size_t line_ = 0, faces_ = 0;
  std::vector<StitchLine> stitches_;
  bool textured_ = false;
};

}  // namespace

mesh::MeshData read_obj_mesh(const std::string& file) {
  ObjReader reader(file);
  reader.run();
  return reader.take_mesh();
}

ObjSheet read_obj_sheet(const std::string& file) {
  ObjReader reader(file);
  reader.run();
  return reader.take_sheet();
}

}  // namespace voile::formats
