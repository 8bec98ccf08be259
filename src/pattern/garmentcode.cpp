// Patterns of GarmentCode: JSON as its release 2.0 writes it, and older.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

using Json = nlohmann::json;

/// A part of the file with words for where it is.
class Node {
 public:
  Node(const Json& json, std::string where) : json_(json), where_(std::move(where)) {}

  [[noreturn]] void fail(const std::string& message) const { throw UserError(fmt::format("{}: {}", where_, message)); }
  [[nodiscard]] bool has(const char* key) const {
    return json_.is_object() && json_.contains(key) && !json_[key].is_null();
  }
  [[nodiscard]] Node operator[](const char* key) const {
    if (!has(key)) fail(fmt::format("'{}' is missing; export the pattern again", key));
    return {json_[key], fmt::format("{}, {}", where_, key)};
  }
  [[nodiscard]] Node at(std::size_t k, const std::string& what) const {
    return {json_[k], fmt::format("{}, {}", where_, what)};
  }
  [[nodiscard]] std::size_t size() const { return json_.size(); }
  [[nodiscard]] bool is_array() const { return json_.is_array(); }
  [[nodiscard]] bool is_text() const { return json_.is_string(); }
  [[nodiscard]] const Json& json() const { return json_; }
  [[nodiscard]] const Node& object() const {
    if (!json_.is_object()) fail("a table { ... } is expected here");
    return *this;
  }
  [[nodiscard]] const Node& array(std::size_t least = 0) const {
    if (!json_.is_array() || json_.size() < least)
      fail(fmt::format("a list{} is expected here", least > 0 ? fmt::format(" of at least {}", least) : ""));
    return *this;
  }
  [[nodiscard]] double number() const {
    const double x = json_.is_number()    ? json_.get<double>()
                     : json_.is_boolean() ? (json_.get<bool>() ? 1.0 : 0.0)
                                          : NAN;
    if (!std::isfinite(x)) fail("a finite number is expected here");
    return x;
  }
  [[nodiscard]] std::size_t index(std::size_t end, const char* what) const {
    if (!json_.is_number_integer()) fail("a whole number is expected here");
    const auto k = json_.get<std::int64_t>();
    if (k < 0 || static_cast<std::size_t>(k) >= end)
      fail(fmt::format("there is no {} {}; there are {}, counted from 0", what, k, end));
    return static_cast<std::size_t>(k);
  }
  [[nodiscard]] std::string text() const {
    if (!is_text()) fail("a text is expected here");
    return json_.get<std::string>();
  }
  template <int n>
  [[nodiscard]] Eigen::Matrix<double, n, 1> vector() const {
    if (!json_.is_array() || json_.size() != n) fail(fmt::format("{} numbers are expected here", n));
    Eigen::Matrix<double, n, 1> x;
    for (int i = 0; i < n; ++i) x[i] = Node(json_[static_cast<std::size_t>(i)], where_).number();
    return x;
  }

 private:
  const Json& json_;
  std::string where_;
};

class GarmentCodeReader {
 public:
  GarmentCodeReader(const std::filesystem::path& file, const Json& json, const ReadOptions& options)
      : options_(options), root_(json, file.string()) {
    pattern_.file = file;
  }

  Pattern run() {
    const Node pattern = root_.object()["pattern"].object();
    unit_ = options_.unit > 0.0 ? options_.unit : file_unit();
    if (root_.has("properties") && root_["properties"].object().has("curvature_coords"))
      relative_ = root_["properties"]["curvature_coords"].text() != "absolute";
    const Node panels = pattern["panels"].object();
    if (panels.size() == 0) panels.fail("there are no panels");
    for (const auto& [name, panel] : panels.json().items())
      read_panel(name, Node(panel, fmt::format("{}: panel '{}'", pattern_.file.string(), name)).object());
    if (pattern.has("stitches")) read_stitches(pattern["stitches"].array());
    return std::move(pattern_);
  }

 private:
  [[nodiscard]] double file_unit() const {
    if (!root_.has("properties") || !root_["properties"].object().has("units_in_meter")) return 0.01;
    const Node units = root_["properties"]["units_in_meter"];
    if (!(units.number() > 0.0)) units.fail("a positive number is expected: how many units are a metre");
    return 1.0 / units.number();
  }

  /// Control points are given from the start in terms of the edge and what is square to it, or in the panel.
  [[nodiscard]] Vec2 control(const Node& given, const Vec2& a, const Vec2& b) const {
    const Vec2 p = given.vector<2>(), e = b - a;
    return relative_ ? Vec2(a + p[0] * e + p[1] * Vec2(-e[1], e[0])) : Vec2(unit_ * p);
  }

  [[nodiscard]] Curve read_curve(const Node& edge, const Vec2& a, const Vec2& b) {
    if (!edge.has("curvature")) return Curve::bezier({a, b});
    const Node c = edge["curvature"];
    is_old_ = is_old_ || c.is_array();
    if (c.is_array()) return Curve::bezier({a, control(c, a, b), b});
    const std::string type = c.object()["type"].text();
    const Node params = c["params"];
    if (type == "quadratic") return Curve::bezier({a, control(params.array(1).at(0, "0"), a, b), b});
    if (type == "cubic")
      return Curve::bezier(
          {a, control(params.array(2).at(0, "0"), a, b), control(params.array(2).at(1, "1"), a, b), b});
    if (type != "circle") c.fail(fmt::format("unknown kind of curve '{}'; use quadratic, cubic or circle", type));
    const double radius = unit_ * params.array(3).at(0, "radius").number(), chord = (b - a).norm();
    if (!(radius >= 0.5 * chord * (1.0 - 1e-6)))
      c.fail(
          fmt::format("a circle of radius {:.4g} m does not reach from end to end, which are {:.4g} m apart; make "
                      "the radius at least half of that",
                      radius, chord));
    return Curve::circle(a, b, std::max(radius, 0.5 * chord), params.at(1, "large").number() != 0.0,
                         params.at(2, "right").number() != 0.0);
  }

  [[nodiscard]] Mat3 rotation(const Node& panel) {
    const Vec3 degrees = panel["rotation"].vector<3>();
    const auto turn = [&](int k) {
      return Mat3(Eigen::AngleAxisd(degrees[k] * std::numbers::pi / 180.0, Vec3::Unit(k)).toRotationMatrix());
    };
    const Mat3 zyx = turn(2) * turn(1) * turn(0), xyz = turn(0) * turn(1) * turn(2);
    if ((zyx - xyz).norm() > 1e-6) two_angles.push_back(pattern_.pieces.back().name);
    return options_.euler_xyz ? xyz : zyx;
  }

  void read_panel(const std::string& name, const Node& panel) {
    const std::vector<std::string>& wanted = options_.pieces;
    known_[name] = panel["edges"].array().size();
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), name) == wanted.end()) return;
    Piece& piece = pattern_.pieces.emplace_back();
    piece.name = name;
    const Node vertices = panel["vertices"].array(), edges = panel["edges"];
    std::vector<Vec2> points;
    for (std::size_t k = 0; k < vertices.size(); ++k)
      points.emplace_back(unit_ * vertices.at(k, fmt::format("{}", k)).vector<2>());
    if (edges.size() == 0) edges.fail("there are no edges; a piece has at least two");
    std::vector<Edge> loop;
    std::size_t at = 0, first = 0;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const Node edge = edges.at(k, fmt::format("edge {}", k)).object();
      const Node ends = edge["endpoints"].array(2);
      const std::size_t i = ends.at(0, "start").index(points.size(), "vertex"),
                        j = ends.at(1, "end").index(points.size(), "vertex");
      if (!loop.empty() && i != at && at == first) {  // a hole, or the outline after it
        piece.add_loop(std::move(loop));
        loop.clear();
      }
      if (loop.empty()) first = i;
      if (!loop.empty() && i != at)
        edge.fail(fmt::format("it starts at vertex {}, but edge {} before it ends at vertex {}: {}", i, k - 1, at,
                              j == at ? "the edge runs backwards; exchange its endpoints, and turn its curvature round"
                                      : "the outline is open there; let each edge begin where the one before ends"));
      at = j;
      if ((points[i] - points[j]).norm() == 0.0)
        edge.fail("both ends are at the same place; remove the edge or move one of them");
      loop.push_back({read_curve(edge, points[i], points[j]), edge.has("label") ? edge["label"].text() : ""});
    }
    if (loop.size() < 2 || at != first)
      panel.fail(
          fmt::format("the outline is open: edge {} ends at vertex {}, but edge {} starts at vertex {}; close it",
                      edges.size() - 1, at, edges.size() - loop.size(), first));
    piece.add_loop(std::move(loop));
    piece.turned = piece.signed_area() < 0.0;
    piece.rotation = rotation(panel);
    piece.translation = unit_ * panel["translation"].vector<3>();
  }

  [[nodiscard]] StitchEnd read_end(const Node& side) const {
    const std::string panel = side.object()["panel"].text();
    const auto at = known_.find(panel);
    if (at == known_.end())
      side.fail(fmt::format("there is no panel '{}'; correct the name or remove the stitch", panel));
    return {panel, side["edge"].index(at->second, "edge")};
  }

  void read_stitches(const Node& stitches) {
    for (std::size_t k = 0; k < stitches.size(); ++k) {
      const Node stitch = stitches.at(k, fmt::format("stitch {}", k)).array(2);
      Stitch s{{read_end(stitch.at(0, "first side")), read_end(stitch.at(1, "second side"))},
               is_old_ ? Sense::nearest : Sense::against,
               k};
      if (stitch.size() > 2) {
        const Node third = stitch.at(2, "third entry");
        if (third.is_text() && third.text() == "right_wrong")
          s.sense = Sense::along;
        else
          third.fail("unknown; it may be \"right_wrong\", or nothing");
      }
      const auto cut = [&](const StitchEnd& e) {
        return std::none_of(pattern_.pieces.begin(), pattern_.pieces.end(),
                            [&](const Piece& p) { return p.name == e.piece; });
      };
      if (!cut(s.sides[0]) || !cut(s.sides[1])) pattern_.stitches.push_back(s);
    }
  }

  const ReadOptions& options_;
  Node root_;
  Pattern pattern_;
  std::map<std::string, std::size_t> known_;  ///< panels and how many edges they have
  double unit_ = 0.01;
  bool relative_ = true;
  bool is_old_ = false;  ///< written before stitches had a sense, as control points without a kind of curve tell

 public:
  std::vector<std::string> two_angles;  ///< panels whose place depends on the order of the angles
};

}  // namespace

Pattern read_garmentcode(const std::filesystem::path& file, const ReadOptions& options) {
  const std::string text = text_of(file);
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& e) {
    throw UserError(fmt::format("{}: this is not valid JSON (at byte {} of {}); export the pattern again",
                                file.string(), e.byte, text.size()));
  } catch (const Json::exception& e) {  // a number that none can hold
    throw UserError(fmt::format("{}: this is not valid JSON ({}); export the pattern again", file.string(), e.what()));
  }
  GarmentCodeReader reader(file, json, options);
  Pattern pattern = reader.run();
  for (const std::string& name : reader.two_angles)
    pattern.notes.push_back(fmt::format(
        "{}: panel '{}' is turned about more than one axis; the order taken is {}; if it is placed wrongly, give "
        "euler = \"{}\"",
        file.string(), name, options.euler_xyz ? "Rx Ry Rz" : "Rz Ry Rx", options.euler_xyz ? "zyx" : "xyz"));
  return pattern;
}

}  // namespace voile::pattern
