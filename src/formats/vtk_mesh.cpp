// Sheets from legacy VTK files: POLYDATA or UNSTRUCTURED_GRID, ASCII or binary (big-endian), cells of file versions up
// to 4 (count and corners) and from 5 on (offsets and connectivity).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <map>
#include <set>

#include "mesh_text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

constexpr long vertex_cell = 1, poly_vertex = 2, line_cell = 3, poly_line = 4, triangle_cell = 5, polygon_cell = 7,
               quad_cell = 9;

class VtkReader {
 public:
  explicit VtkReader(const std::string& file) : file_(file), text_(file_text(file)) {}

  mesh::MeshData run() {
    if (!text_.starts_with("# vtk DataFile Version"))
      fail("this is no legacy VTK file (it does not start with '# vtk DataFile Version'); save it as legacy VTK");
    next_line();
    next_line();  // the title
    const std::string form = upper(word());
    if (form != "ASCII" && form != "BINARY") fail(fmt::format("'{}' instead of ASCII or BINARY", form));
    binary_ = form == "BINARY";
    while (skip_blanks()) read_section(upper(word()));
    make_cells();
    mesh_.data.texture.clear();
    mesh_.note_split();
    return std::move(mesh_.data);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw UserError(fmt::format("{}: {}", file_, what)); }

  static std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
  }
  void next_line() { at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1; }
  bool skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return at_ < text_.size();
  }
  std::string word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  /// A count of entries, each of which takes at least a byte of the file.
  std::size_t count() {
    long n = 0;
    const std::string text = word();
    if (!parse_integer(text, n) || n < 0 || static_cast<std::size_t>(n) > text_.size())
      fail(fmt::format("'{}' is no count of entries that the file can hold; export it again", text));
    return static_cast<std::size_t>(n);
  }

  template <class T>
  T decode() {
    if (at_ + sizeof(T) > text_.size()) fail("the file is cut short; export it again");
    std::array<char, sizeof(T)> bytes{};
    std::copy_n(text_.begin() + static_cast<std::ptrdiff_t>(at_), sizeof(T), bytes.begin());
    if constexpr (std::endian::native == std::endian::little) std::reverse(bytes.begin(), bytes.end());
    at_ += sizeof(T);
    return std::bit_cast<T>(bytes);
  }

  double value_of(const std::string& type) {
    if (!binary_) {
      double x = 0.0;
      const std::string text = word();
      if (!parse_number(text, x)) fail(fmt::format("'{}' is no finite number; export it again", text));
      return x;
    }
    if (type == "float") return decode<float>();
    if (type == "double") return decode<double>();
    if (type == "int") return decode<std::int32_t>();
    if (type == "unsigned_int") return decode<std::uint32_t>();
    if (type == "long" || type == "vtktypeint64" || type == "vtkidtype")
      return static_cast<double>(decode<std::int64_t>());
    if (type == "unsigned_long") return static_cast<double>(decode<std::uint64_t>());
    if (type == "short") return decode<std::int16_t>();
    if (type == "unsigned_short") return decode<std::uint16_t>();
    if (type == "char" || type == "signed_char") return decode<std::int8_t>();
    if (type == "unsigned_char") return decode<std::uint8_t>();
    fail(fmt::format("data of type '{}' are not read; save the mesh without them", type));
  }

  /// `n` values that follow the end of this line (binary) or the next blank (ASCII).
  std::vector<double> values(std::size_t n, std::string type) {
    std::transform(type.begin(), type.end(), type.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (binary_) next_line();
    std::vector<double> x;
    for (std::size_t k = 0; k < n; ++k) x.push_back(value_of(type));
    return x;
  }

  void read_section(const std::string& keyword) {
    if (keyword == "DATASET") {
      const std::string kind = upper(word());
      if (kind != "POLYDATA" && kind != "UNSTRUCTURED_GRID")
        fail(fmt::format("a data set of kind {} is no mesh of triangles; save POLYDATA or UNSTRUCTURED_GRID", kind));
    } else if (keyword == "POINTS") {
      const std::size_t n = count();
      const std::vector<double> x = values(3 * n, word());
      for (std::size_t k = 0; k < n; ++k) mesh_.data.positions.emplace_back(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
    } else if (keyword == "CELLS" || keyword == "POLYGONS" || keyword == "LINES" || keyword == "VERTICES") {
      read_cells(keyword);
    } else if (keyword == "TRIANGLE_STRIPS") {
      fail("triangle strips are not read; save triangles");
    } else if (keyword == "CELL_TYPES") {
      for (const double type : values(count(), "int")) types_.push_back(static_cast<long>(type));
    } else if (keyword == "CELL_DATA" || keyword == "POINT_DATA") {
      data_count_ = count();
      of_cells_ = keyword == "CELL_DATA";
    } else if (keyword == "SCALARS") {
      read_scalars();
    } else if (keyword == "FIELD") {
      read_fields();
    } else if (keyword == "METADATA") {
      next_line();  // up to an empty one
      while (at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r') next_line();
    } else if (keyword == "VECTORS" || keyword == "NORMALS") {
      (void)word();
      (void)values(3 * data_count_, word());
    } else {
      fail(fmt::format("a section '{}' is not read; save the mesh without it", keyword));
    }
  }

  /// Counts and corners one after the other, or offsets and connectivity.
  void read_cells(const std::string& keyword) {
    const std::size_t first = count(), second = count();
    const std::size_t here = at_;
    std::vector<std::vector<long>> cells;
    if (upper(word()) == "OFFSETS") {
      const std::vector<double> offsets = values(first, word());
      if (upper(word()) != "CONNECTIVITY") fail("OFFSETS without CONNECTIVITY; export it again");
      const std::vector<double> corners = values(second, word());
      for (std::size_t c = 0; c + 1 < offsets.size(); ++c) {
        if (!(offsets[c] >= 0.0 && offsets[c + 1] >= offsets[c] && offsets[c + 1] <= static_cast<double>(second)))
          fail("OFFSETS of cells do not ascend; export it again");
        const auto at = corners.begin();
        cells.emplace_back(at + static_cast<std::ptrdiff_t>(offsets[c]),
                           at + static_cast<std::ptrdiff_t>(offsets[c + 1]));
      }
    } else {
      at_ = here;
      const std::vector<double> numbers = values(second, "int");
      for (std::size_t k = 0, c = 0; c < first; ++c) {
        const std::size_t n = k < numbers.size() && numbers[k] >= 0.0 ? static_cast<std::size_t>(numbers[k]) : second;
        if (k + 1 + n > numbers.size()) fail("a cell has more corners than the file; export it again");
        cells.emplace_back(numbers.begin() + static_cast<std::ptrdiff_t>(k + 1),
                           numbers.begin() + static_cast<std::ptrdiff_t>(k + 1 + n));
        k += n + 1;
      }
    }
    for (std::vector<long>& cell : cells) {
      cells_.push_back(std::move(cell));
      kinds_.push_back(keyword);
    }
  }

  void read_scalars() {
    const std::string name = word(), type = word();
    std::size_t components = 1;
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    if (at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_]))) components = count();
    skip_blanks();
    if (upper(word()) != "LOOKUP_TABLE") fail("SCALARS without LOOKUP_TABLE; export it again");
    (void)word();
    keep(name, type, values(components * data_count_, type), components);
  }

  void read_fields() {
    (void)word();
    const std::size_t arrays = count();
    for (std::size_t k = 0; k < arrays; ++k) {
      const std::string name = word();
      if (upper(name) == "METADATA") {
        read_section("METADATA");
        --k;
        continue;
      }
      const std::size_t components = count(), tuples = count();
      if (components > 0 && tuples > text_.size() / components)
        fail("a field is larger than the file; export it again");
      const std::string type = word();
      keep(name, type, values(components * tuples, type), components);
    }
  }

  void keep(const std::string& name, const std::string& type, std::vector<double> x, std::size_t components) {
    if (!of_cells_ || components != 1 || type.starts_with("float") || type.starts_with("double")) return;
    const std::string known = upper(name);
    const bool preferred = known == "GROUP" || known == "PHYSICAL" || known == "CELLENTITYIDS";
    if (!group_name_.empty() && (group_preferred_ || !preferred)) return;
    group_name_ = name;
    group_preferred_ = preferred;
    group_values_ = std::move(x);
  }

  /// The kind of a cell as a number of VTK.
  [[nodiscard]] long kind(std::size_t c) const {
    if (kinds_[c] == "CELLS") {
      if (c >= types_.size()) fail("there are fewer CELL_TYPES than CELLS; export it again");
      return types_[c];
    }
    return kinds_[c] == "POLYGONS" ? polygon_cell : kinds_[c] == "LINES" ? poly_line : poly_vertex;
  }

  void make_cells() {
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      std::vector<Index> corners;
      for (const long v : cells_[c]) {
        if (v < 0 || static_cast<std::size_t>(v) >= mesh_.data.positions.size())
          fail(fmt::format("cell {} names a point that does not exist; export it again", c));
        corners.push_back(static_cast<Index>(v));
      }
      const long type = kind(c);
      const bool surface = type == triangle_cell || type == polygon_cell || type == quad_cell;
      const bool curve = type == line_cell || type == poly_line;
      if (!surface && !curve && type != vertex_cell && type != poly_vertex)
        fail(fmt::format("cell {} is of VTK's type {}, no triangle, quadrangle or polygon; save the surface only", c,
                         type));
      if (surface && corners.size() < 3) fail(fmt::format("cell {} has fewer than three corners; remove it", c));
      add_cell(c, corners, surface, curve);
    }
  }

  void add_cell(std::size_t c, const std::vector<Index>& corners, bool surface, bool curve) {
    std::vector<Index> made;
    if (surface) made = mesh_.add_polygon(corners, c);
    if (group_name_.empty() || c >= group_values_.size() || (!surface && !curve)) return;
    mesh::Group& group =
        mesh_.group(fmt::format("{}-{}", group_name_, static_cast<long>(group_values_[c])), surface ? 2 : 1);
    group.vertices.insert(group.vertices.end(), corners.begin(), corners.end());
    group.triangles.insert(group.triangles.end(), made.begin(), made.end());
    for (std::size_t k = 1; curve && k < corners.size(); ++k) group.segments.push_back({corners[k - 1], corners[k]});
  }

  const std::string& file_;
  std::string text_;
  std::size_t at_ = 0, data_count_ = 0;
  bool binary_ = false, of_cells_ = false, group_preferred_ = false;
  GrowingMesh mesh_;
  std::vector<std::vector<long>> cells_;
  std::vector<std::string> kinds_;
  std::vector<long> types_;
  std::string group_name_;
  std::vector<double> group_values_;
};

}  // namespace

mesh::MeshData read_vtk(const std::string& file) {
  return VtkReader(file).run();
}

}  // namespace voile::formats
