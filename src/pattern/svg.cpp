// Outlines in SVG files: paths, polygons, closed polylines and rectangles, with the transforms of their groups.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <pugixml.hpp>
#include <sstream>

#include "base/length_unit.hpp"
#include "base/text.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// x -> m x + shift
struct Affine {
  Mat2 m = Mat2::Identity();
  Vec2 shift = Vec2::Zero();
  [[nodiscard]] Affine then_inside(const Affine& inner) const { return {m * inner.m, m * inner.shift + shift}; }
};

std::vector<double> numbers_of(const std::string& where, const std::string& text) {
  std::vector<double> numbers;
  for (const char* at = text.c_str(); *at;) {
    if (std::isspace(static_cast<unsigned char>(*at)) || *at == ',') {
      ++at;
      continue;
    }
    char* end = nullptr;
    const double x = std::strtod(at, &end);
    if (end == at || !std::isfinite(x)) throw UserError(fmt::format("{}: '{:.20}' is no number", where, at));
    numbers.push_back(x);
    at = end;
  }
  return numbers;
}

/// One of the functions of a transform.
Affine function_of(const std::string& where, const std::string& name, const std::vector<double>& a) {
  const auto fail = [&] {
    return UserError(
        fmt::format("{}: transform '{}' with {} numbers is unknown; apply the transforms in the drawing "
                    "program",
                    where, name, a.size()));
  };
  const auto given = [&](std::size_t k, double otherwise) { return k < a.size() ? a[k] : otherwise; };
  Affine t;
  if (a.empty() || a.size() > 6) throw fail();
  const double angle = a[0] * std::numbers::pi / 180.0;
  if (name == "matrix" && a.size() == 6) {
    t.m << a[0], a[2], a[1], a[3];
    t.shift = {a[4], a[5]};
  } else if (name == "translate" && a.size() <= 2) {
    t.shift = {a[0], given(1, 0.0)};
  } else if (name == "scale" && a.size() <= 2) {
    t.m = Vec2(a[0], given(1, a[0])).asDiagonal();
  } else if (name == "rotate" && (a.size() == 1 || a.size() == 3)) {
    t.m = Eigen::Rotation2Dd(angle).toRotationMatrix();
    const Vec2 centre(given(1, 0.0), given(2, 0.0));
    t.shift = centre - t.m * centre;
  } else if (name == "skewX" && a.size() == 1) {
    t.m(0, 1) = std::tan(angle);
  } else if (name == "skewY" && a.size() == 1) {
    t.m(1, 0) = std::tan(angle);
  } else {
    throw fail();
  }
  return t;
}

Affine transform_of(const std::string& where, const std::string& text) {
  Affine all;
  std::size_t at = 0;
  while ((at = text.find_first_not_of(" \t\r\n,", at)) != std::string::npos) {
    const std::size_t open = text.find('(', at), close = text.find(')', at);
    if (open == std::string::npos || close == std::string::npos || close < open)
      throw UserError(fmt::format("{}: the transform '{}' cannot be read", where, text));
    std::string name = text.substr(at, open - at);
    name.erase(name.find_last_not_of(" \t\r\n") + 1);
    all = all.then_inside(function_of(where, name, numbers_of(where, text.substr(open + 1, close - open - 1))));
    at = close + 1;
  }
  if (!(std::abs(all.m.determinant()) > 0.0))
    throw UserError(fmt::format("{}: the transform '{}' leaves no area", where, text));
  return all;
}

constexpr double user_units_of_inch = 96.0;  ///< W3C, Cascading Style Sheets Level 2, 4.3.2

/// Length of a width or height in metres, or 0 if it has no unit of length.
double metres(const std::string& text) {
  constexpr std::array units{std::pair{"mm", 1e-3},        std::pair{"cm", 1e-2},       std::pair{"in", inch},
                             std::pair{"pt", inch / 72.0}, std::pair{"pc", inch / 6.0}, std::pair{"m", 1.0}};
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  for (const auto& [name, length] : units)
    if (std::strcmp(end, name) == 0) return x * length;
  return 0.0;
}

/// A length in user units of where it stands; one with a unit is that of 96 user units an inch, whatever the drawing's scale.
double user_units(const std::string& where, const pugi::xml_node& node, const char* key) {
  const std::string text = node.attribute(key).value();
  if (text.empty()) return 0.0;
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end), length = metres(text);
  if (length != 0.0) return length / inch * user_units_of_inch;
  if (end != text.c_str() && std::isfinite(x) && (*end == 0 || std::strcmp(end, "px") == 0 || x == 0.0)) return x;
  throw UserError(
      fmt::format("{}: {} = '{}' is no length; give a number, or one with mm, cm, in, pt, pc or px", where, key, text));
}

/// The style of an element without spaces, each entry after a semicolon.
std::string style_of(const pugi::xml_node& node) {
  std::string style = std::string(";") + node.attribute("style").value();
  std::erase_if(style, [](unsigned char c) { return std::isspace(c); });
  return style;
}

std::vector<std::string> split_at(char separator, const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

class SvgReader {
 public:
  SvgReader(const std::filesystem::path& file, const ReadOptions& options) : options_(options) { pattern_.file = file; }

  Pattern run() {
    const std::string text = text_of(pattern_.file);
    pugi::xml_document document;
    const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
    if (!result)
      throw UserError(fmt::format("{}: this is not valid XML: {} (at byte {} of {}); export the drawing again as SVG",
                                  pattern_.file.string(), result.description(), result.offset, text.size()));
    const pugi::xml_node root = document.child("svg");
    if (!root) throw UserError(fmt::format("{}: this is no SVG: it has no <svg> element", pattern_.file.string()));
    unit_ = options_.unit > 0.0 ? options_.unit : file_unit(root);
    Affine to_metres;
    to_metres.m = Vec2(unit_, -unit_).asDiagonal();  // y points down in the file
    read_style_sheets(root);
    walk(root, to_metres, "");
    if (pattern_.pieces.empty())
      throw UserError(fmt::format(
          "{}: there is no outline in it; draw each piece as a closed path, polygon, polyline or rect{}",
          pattern_.file.string(),
          seen_.empty() ? "" : fmt::format("; `pieces` names none of those there are: {}", join(seen_, ", "))));
    return std::move(pattern_);
  }

 private:
  [[nodiscard]] double file_unit(const pugi::xml_node& root) const {
    const auto fail = [&](const std::string& why) {
      return UserError(
          fmt::format("{}: {}, so it is unknown how long a unit is; give the key unit of [[panel]], the length "
                      "of a unit in metres (0.001 for millimetres)",
                      pattern_.file.string(), why));
    };
    const std::string width = root.attribute("width").value(), height = root.attribute("height").value();
    const std::vector<double> box = numbers_of(pattern_.file.string() + ": viewBox", root.attribute("viewBox").value());
    if (box.size() != 4 || !(box[2] > 0.0) || !(box[3] > 0.0)) throw fail("it has no viewBox");
    const double x = metres(width), y = metres(height);
    if (!(x > 0.0)) throw fail(fmt::format("its width '{}' has no unit of length", width));
    const double ratio = y > 0.0 ? (y / box[3]) / (x / box[2]) : 1.0;
    if (std::abs(ratio - 1.0) > 1e-3)
      throw fail(
          fmt::format("width and height make a unit of x {:.4g} m and one of y {:.4g} m", x / box[2], y / box[3]));
    return x / box[2];
  }

  /// What is drawn nowhere as it stands.
  static bool is_hidden(const std::string& element) {
    for (const char* name : {"defs", "clipPath", "symbol", "pattern", "marker", "mask", "metadata", "style", "text"})
      if (element == name) return true;
    return false;
  }

  /// Classes that the style sheet hides. Throws UserError where it hides something by another selector.
  void read_style_sheet(const pugi::xml_node& node) {
    std::string text;
    for (const pugi::xml_node& part : node.children()) text += part.value();
    std::erase_if(text, [](unsigned char c) { return std::isspace(c); });
    for (std::size_t at = 0; (at = text.find("/*")) != std::string::npos;)
      text.erase(at, text.find("*/", at) == std::string::npos ? std::string::npos : text.find("*/", at) + 2 - at);
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t open = text.find('{', at), close = text.find('}', at);
      if (open == std::string::npos || close == std::string::npos || close < open) return;
      const std::string selectors = text.substr(at, open - at), rule = ";" + text.substr(open + 1, close - open - 1);
      at = close + 1;
      if (!hides(rule)) continue;
      for (const std::string& selector : split_at(',', selectors)) {
        if (selector.size() < 2 || selector[0] != '.' || selector.find_first_of(".#>:[*+~", 1) != std::string::npos)
          throw UserError(fmt::format(
              "{}: its style sheet hides what '{}' selects, which is not read; hide shapes by the attribute "
              "display=\"none\"",
              pattern_.file.string(), selector));
        hidden_classes_.push_back(selector.substr(1));
      }
    }
  }

  void read_style_sheets(const pugi::xml_node& parent) {
    for (const pugi::xml_node& node : parent.children())
      std::strcmp(node.name(), "style") == 0 ? read_style_sheet(node) : read_style_sheets(node);
  }

  static bool hides(const std::string& style) {
    for (const char* rule : {";display:none", ";visibility:hidden", ";visibility:collapse"})
      if (style.find(rule) != std::string::npos) return true;
    return false;
  }

  /// By itself, not by what it is in.
  [[nodiscard]] bool is_made_hidden(const pugi::xml_node& node) const {
    const std::string visibility = node.attribute("visibility").value();
    if (std::strcmp(node.attribute("display").value(), "none") == 0 || visibility == "hidden" ||
        visibility == "collapse" || hides(style_of(node)))
      return true;
    const std::vector<std::string> classes = split_at(' ', node.attribute("class").value());
    return std::any_of(classes.begin(), classes.end(),
                       [&](const std::string& name) { return contains(hidden_classes_, name); });
  }

  /// What would be drawn in another size or place than is read here.
  static void refuse_placed(const pugi::xml_node& node, const std::string& element, const std::string& where) {
    if (style_of(node).find(";transform:") != std::string::npos)
      throw UserError(fmt::format("{}: its style has a transform; make it the attribute transform", where));
    if (element == "svg" &&
        (node.attribute("viewBox") || node.attribute("x").as_double() != 0.0 || node.attribute("y").as_double() != 0.0))
      throw UserError(fmt::format(
          "{}: a drawing within the drawing, with a place or a viewBox of its own; make it a group (<g>) with a "
          "transform",
          where));
  }

  void walk(const pugi::xml_node& parent, const Affine& outer, const std::string& group) {
    for (const pugi::xml_node& node : parent.children()) {
      std::string element = node.name();
      element = element.substr(element.find(':') == std::string::npos ? 0 : element.find(':') + 1);
      if (node.type() != pugi::node_element || is_hidden(element)) continue;
      std::string name = node.attribute("inkscape:label").value();
      if (name.empty()) name = node.attribute("id").value();
      if (name.empty()) name = group;
      const std::string where = fmt::format("{}: {} '{}'", pattern_.file.string(), element, name);
      if (is_made_hidden(node)) {
        pattern_.notes.push_back(fmt::format("{} is hidden (display or visibility), and is passed over", where));
        continue;
      }
      refuse_placed(node, element, where);
      const Affine here = outer.then_inside(transform_of(where, node.attribute("transform").value()));
      if (element == "g" || element == "svg" || element == "a" || element == "switch")
        walk(node, here, name);
      else
        read_outline(node, element, where, name, here);
    }
  }

  [[nodiscard]] static std::vector<Curve> polygon(const std::string& where, const std::string& text, bool must_close) {
    const std::vector<double> x = numbers_of(where, text);
    std::vector<Vec2> points;
    for (std::size_t k = 0; k + 1 < x.size(); k += 2) points.emplace_back(x[k], x[k + 1]);
    if (x.size() % 2 || points.size() < 3)
      throw UserError(fmt::format("{}: {} numbers are no outline; give pairs x,y, at least three", where, x.size()));
    const bool is_closed = points.front() == points.back();
    if (must_close && !is_closed)
      throw UserError(
          fmt::format("{}: the outline is open: its last point is not its first; close it or make it a "
                      "polygon",
                      where));
    if (is_closed) points.pop_back();
    std::vector<Curve> curves;
    for (std::size_t k = 0; k < points.size(); ++k)
      curves.push_back(Curve::bezier({points[k], points[(k + 1) % points.size()]}));
    return curves;
  }

  [[nodiscard]] static std::vector<Curve> rectangle(const std::string& where, const pugi::xml_node& node) {
    const double x = user_units(where, node, "x"), y = user_units(where, node, "y"),
                 w = user_units(where, node, "width"), h = user_units(where, node, "height");
    if (!(w > 0.0 && h > 0.0)) throw UserError(fmt::format("{}: width and height must be positive numbers", where));
    if (node.attribute("rx") || node.attribute("ry"))
      throw UserError(fmt::format("{}: its corners are round; convert it to a path", where));
    return polygon(where, fmt::format("{} {} {} {} {} {} {} {}", x, y, x + w, y, x + w, y + h, x, y + h), false);
  }

  void read_outline(const pugi::xml_node& node, const std::string& element, const std::string& where,
                    const std::string& name, const Affine& place) {
    const bool is_line =
        element == "line" || element == "circle" || element == "ellipse" || element == "image" || element == "use";
    const bool is_outline = element == "path" || element == "polygon" || element == "polyline" || element == "rect";
    const std::vector<std::string>& wanted = options_.pieces;
    if (is_outline) seen_.push_back(name);
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), name) == wanted.end()) return;
    if (is_line) pattern_.notes.push_back(fmt::format("{} is passed over; a piece is a path, polygon or rect", where));
    if (!is_outline) return;
    std::vector<std::vector<Curve>> loops;
    if (element == "path")
      loops = read_svg_path(where, node.attribute("d").value());
    else
      loops.push_back(element == "rect" ? rectangle(where, node)
                                        : polygon(where, node.attribute("points").value(), element == "polyline"));
    Piece& piece = pattern_.pieces.emplace_back();
    piece.name = name;
    if (name.empty())
      throw UserError(fmt::format("{}: outline {} has no name; give it or its group an id", pattern_.file.string(),
                                  pattern_.pieces.size() - 1));
    for (const std::vector<Curve>& loop : loops) {
      std::vector<Edge> edges;
      for (const Curve& c : loop) edges.push_back({c.mapped(place.m, place.shift)});
      piece.add_loop(std::move(edges));
    }
  }

  const ReadOptions& options_;
  Pattern pattern_;
  std::vector<std::string> seen_, hidden_classes_;  ///< names of outlines, and of classes of the style sheet
  double unit_ = 0.0;
};

}  // namespace

Pattern read_svg(const std::filesystem::path& file, const ReadOptions& options) {
  return SvgReader(file, options).run();
}

}  // namespace voile::pattern
