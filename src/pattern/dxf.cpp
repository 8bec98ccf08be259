// Pieces of a DXF: closed outlines of a drawing, or blocks as AAMA/ASTM D6673 has them, a piece each.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "dxf_entities.hpp"
#include "readers.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"
#include "voile/pattern/outline.hpp"

namespace voile::pattern {

namespace {

/// Layers of a piece.
const std::string boundary = "1", turn_points = "2", curve_points = "3", notches = "4", mirror_line = "6",
                  grain_line = "7", cutout = "11", sew_line = "14";
/// Change of direction at which a boundary without turn points has a corner [rad].
constexpr double corner_angle = 15.0 * 3.14159265358979 / 180.0;
/// Share of the extent of a piece within which marks count as on its outline, and lines as the same.
constexpr double on_outline = 1e-3;
/// Share of the extent of a piece within which a notch belongs to its outline: those of the boundary, seen from the sew line, do.
constexpr double near_outline = 0.08;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// What follows a word such as "Piece Name:" in one of the texts of a block; empty if none has it.
std::string told(const std::vector<DxfEntity>& entities, const std::string& word) {
  for (const DxfEntity& e : entities) {
    if (e.type != "TEXT" && e.type != "MTEXT" && e.type != "ATTRIB") continue;
    const std::string text = e.text(1);
    if (!lower(text).starts_with(word)) continue;
    const std::size_t at = text.find_first_not_of(" \t", word.size());
    if (at != std::string::npos) return text.substr(at);
  }
  return "";
}

std::vector<Curve> curves_on(const std::vector<DxfEntity>& entities, const std::string& layer) {
  std::vector<Curve> all;
  for (const DxfEntity& e : entities)
    if (e.layer == layer)
      for (Curve& c : curves_of(e)) all.push_back(std::move(c));
  return all;
}

std::vector<Vec2> points_on(const std::vector<DxfEntity>& entities, const std::string& layer) {
  std::vector<Vec2> all;
  for (const DxfEntity& e : entities)
    if (e.layer == layer && e.type == "POINT") all.push_back(e.point(10, 20));
  return all;
}

/// One block.
class BlockReader {
 public:
  BlockReader(std::string where, const DxfBlock& block) : where_(std::move(where)), block_(block) {}

  /// In the file's units. The outline is unfolded across its mirror line.
  Piece run(std::vector<std::string>& notes) {
    const std::vector<DxfEntity>& all = block_.entities;
    const std::vector<Curve> mirror = curves_on(all, mirror_line);
    std::vector<Curve> outline = one_outline(mirror);
    for (const Curve& c : outline) size_ = std::max(size_, (c.start() - outline.front().start()).norm());
    Piece piece;
    piece.add_loop(divided(std::move(outline), mirror, piece.point_names, notes));
    const std::size_t fold = mirror.empty() ? no_edge : fold_of(piece, mirror.front());
    const std::vector<std::vector<Curve>> holes =
        join_curves(fmt::format("{}, layer {}", where_, cutout), curves_on(all, cutout), mirror);
    for (std::size_t k = 0; k < holes.size(); ++k)
      piece.add_loop(joined(holes[k], corners_of(holes[k], mirror), {}, {fmt::format("h{}", k), piece.point_names}));
    const std::vector<Curve> grain = curves_on(all, grain_line);
    if (!grain.empty()) piece.grain = (grain.front().end() - grain.front().start()).normalized();
    if (!mirror.empty()) {
      unfold(where_, piece, fold);
      notes.push_back(fmt::format("{}: unfolded across its mirror line (layer 6)", where_));
    }
    return piece;
  }

 private:
  std::vector<Curve> one_outline(const std::vector<Curve>& mirror) const {
    std::string layer = sew_line;
    std::vector<Curve> curves = curves_on(block_.entities, layer);
    if (curves.empty()) curves = curves_on(block_.entities, layer = boundary);
    std::vector<std::vector<Curve>> outlines = join_curves(fmt::format("{}, layer {}", where_, layer), curves, mirror);
    if (outlines.size() != 1)
      throw UserError(fmt::format("{}: layer {} has {} outlines, and a piece has one; put others on other layers",
                                  where_, layer, outlines.size()));
    return std::move(outlines.front());
  }

  [[nodiscard]] bool is_among(const std::vector<Vec2>& marks, const Vec2& x) const {
    return std::any_of(marks.begin(), marks.end(), [&](const Vec2& m) { return (m - x).norm() <= on_outline * size_; });
  }

  /// Whether the outline turns between two of its curves.
  static bool turns(const Curve& a, const Curve& b) {
    const Vec2 d = a.derivative(1.0), e = b.derivative(0.0);
    return std::abs(std::atan2(d[0] * e[1] - d[1] * e[0], d.dot(e))) > corner_angle;
  }

  /// Whether a corner lies before each curve: where it begins on the mirror line, and as corners_without() says.
  [[nodiscard]] std::vector<bool> corners_of(const std::vector<Curve>& outline,
                                             const std::vector<Curve>& mirror) const {
    std::vector<bool> corners = corners_without(outline);
    for (std::size_t k = 0; k < outline.size() && !mirror.empty(); ++k)
      if (distance_from(mirror.front(), outline[k].start()) <= on_outline * size_) corners[k] = true;
    return corners;
  }

  /// At turn points; without, at what is no curve point; without, where it turns.
  [[nodiscard]] std::vector<bool> corners_without(const std::vector<Curve>& outline) const {
    const std::size_t n = outline.size();
    const std::vector<Vec2> turn = points_on(block_.entities, turn_points),
                            smooth = points_on(block_.entities, curve_points);
    std::vector<bool> marked(n), unmarked(n), sharp(n);
    for (std::size_t k = 0; k < n; ++k) {
      marked[k] = is_among(turn, outline[k].start());
      unmarked[k] = !is_among(smooth, outline[k].start());
      sharp[k] = turns(outline[(k + n - 1) % n], outline[k]);
    }
    const auto count = [&](const std::vector<bool>& some) {
      return static_cast<std::size_t>(std::count(some.begin(), some.end(), true));
    };
    for (const std::vector<bool>* some : {&marked, &unmarked, &sharp})
      if (count(*some) >= 2 && (some != &unmarked || count(unmarked) < n)) return *some;
    return std::vector<bool>(n, true);
  }

  /// Divides the curve of the outline that a notch lies nearest to, and says before which curve it then lies.
  std::size_t divide_at(std::vector<Curve>& outline, std::vector<bool>& corners, std::vector<bool>& marks,
                        const Vec2& notch) const {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity(), share = 0.0;
    for (std::size_t k = 0; k < outline.size(); ++k) {
      const auto [t, distance] = outline[k].nearest(notch);
      if (distance < least) best = k, share = t;
      least = std::min(least, distance);
    }
    if (least > near_outline * size_) return outline.size();
    const std::size_t next = (best + 1) % outline.size();
    const double tolerance = on_outline * size_;
    const auto at = static_cast<std::ptrdiff_t>(best);
    if ((outline[best].start() - outline[best].at(share)).norm() <= tolerance) return best;
    if ((outline[best].end() - outline[best].at(share)).norm() <= tolerance) return next;
    auto [first, second] = outline[best].split(share);
    outline[best] = std::move(first);
    outline.insert(outline.begin() + at + 1, std::move(second));
    corners.insert(corners.begin() + at + 1, false);
    marks.insert(marks.begin() + at + 1, false);
    return best + 1;
  }

  /// Edges between corners and notches, from the first corner on, and names of their points.
  std::vector<Edge> divided(std::vector<Curve> outline, const std::vector<Curve>& mirror,
                            std::vector<std::string>& names, std::vector<std::string>& notes) const {
    std::vector<bool> corners = corners_of(outline, mirror), marks(outline.size(), false);
    for (const Vec2& notch : points_on(block_.entities, notches))
      if (const std::size_t k = divide_at(outline, corners, marks, notch); k < outline.size())
        marks[k] = true;
      else
        notes.push_back(
            fmt::format("{}: a notch, ({:.4g}, {:.4g}) in the file's units, is too far from the outline to divide it",
                        where_, notch[0], notch[1]));
    return joined(std::move(outline), std::move(corners), std::move(marks), {"", names});
  }

  /// Where names of points go, and what they begin with.
  struct Naming {
    std::string prefix;
    std::vector<std::string>& names;
  };

  /// Edges from corner or notch to corner or notch, from the first corner on. `marks`: notches; may be empty.
  static std::vector<Edge> joined(std::vector<Curve> loop, std::vector<bool> corners, std::vector<bool> marks,
                                  const Naming& naming) {
    marks.resize(loop.size(), false);
    const auto first = std::find(corners.begin(), corners.end(), true) - corners.begin();
    for (std::vector<bool>* some : {&corners, &marks}) std::rotate(some->begin(), some->begin() + first, some->end());
    std::rotate(loop.begin(), loop.begin() + first, loop.end());
    std::vector<Edge> edges;
    std::vector<Curve> parts;
    std::size_t corner = 0, notch = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      if (corners[k] || marks[k]) {
        if (!parts.empty()) edges.push_back({Curve::chain(std::move(parts))});
        parts.clear();
        naming.names.push_back(naming.prefix +
                               (corners[k] ? fmt::format("c{}", corner++) : fmt::format("n{}", notch++)));
      }
      parts.push_back(loop[k]);
    }
    edges.push_back({Curve::chain(std::move(parts))});
    return edges;
  }

  /// Of a point from a straight line, prolonged.
  static double distance_from(const Curve& line, const Vec2& x) {
    const Vec2 along = (line.end() - line.start()).normalized(), d = x - line.start();
    return std::abs(along[0] * d[1] - along[1] * d[0]);
  }

  /// The edge that lies on the mirror line.
  [[nodiscard]] std::size_t fold_of(const Piece& piece, const Curve& mirror) const {
    for (std::size_t k = 0; k < piece.edges.size(); ++k) {
      double away = 0.0;
      for (int i = 0; i <= 8; ++i) away = std::max(away, distance_from(mirror, piece.edges[k].curve.at(i / 8.0)));
      if (away <= on_outline * size_) return k;
    }
    throw UserError(fmt::format(
        "{}: no edge of the outline lies on its mirror line (layer 6), across which it would unfold; let the "
        "outline of the half run along it in one edge",
        where_));
  }

  std::string where_;
  const DxfBlock& block_;
  double size_ = 0.0;  ///< of the outline
};

class DxfReader {
 public:
  DxfReader(const std::filesystem::path& file, const ReadOptions& options)
      : options_(options), file_(read_dxf_entities(file)) {
    pattern_.file = file;
    pattern_.notes = file_.notes;
  }

  Pattern run() {
    unit_ = options_.unit > 0.0 ? options_.unit : file_unit();
    note_placed();
    std::vector<const DxfBlock*> blocks;
    for (const DxfBlock& b : file_.blocks)
      if (std::any_of(b.entities.begin(), b.entities.end(),
                      [](const DxfEntity& e) { return e.layer == boundary || e.layer == sew_line; }))
        blocks.push_back(&b);
    if (blocks.empty()) {
      read_drawing();
      if (!placed_.empty() && !pattern_.pieces.empty())
        pattern_.notes.push_back(fmt::format(
            "{}: blocks that are placed are passed over; explode {} if they are pieces", name(), join(placed_, ", ")));
    } else {
      read_blocks(blocks);
    }
    if (pattern_.pieces.empty())
      throw UserError(fmt::format(
          "{}: there is no outline in it; draw each piece as a closed polyline or as lines, arcs and splines "
          "that join, or export blocks of AAMA/ASTM{}{}",
          name(),
          placed_.empty() ? ""
                          : fmt::format("; blocks that are placed are passed over, explode {}", join(placed_, ", ")),
          seen_.empty() ? "" : fmt::format("; `pieces` names none of those there are: {}", join(seen_, ", "))));
    return std::move(pattern_);
  }

 private:
  [[nodiscard]] std::string name() const { return pattern_.file.string(); }
  [[nodiscard]] bool is_wanted(const std::string& piece) const {
    return options_.pieces.empty() ||
           std::find(options_.pieces.begin(), options_.pieces.end(), piece) != options_.pieces.end();
  }

  [[nodiscard]] int variable(const char* key) const {
    const auto at = file_.variables.find(key);
    return at == file_.variables.end() ? -1 : std::atoi(at->second.c_str());
  }

  [[nodiscard]] double file_unit() {
    static const std::map<int, double> units{{1, 0.0254}, {2, 0.3048},  {4, 1e-3}, {5, 1e-2},
                                             {6, 1.0},    {10, 0.9144}, {14, 0.1}};
    if (const auto at = units.find(variable("$INSUNITS")); at != units.end()) return at->second;
    std::string words = told(file_.entities, "units:");
    for (const DxfBlock& b : file_.blocks)
      if (words.empty()) words = told(b.entities, "units:");
    words = lower(words);
    if (words.starts_with("metric")) return 1e-3;
    if (words.starts_with("english")) return 0.0254;
    const int measurement = variable("$MEASUREMENT");
    if (measurement != 0 && measurement != 1)
      throw UserError(fmt::format(
          "{}: neither $INSUNITS nor $MEASUREMENT nor a text 'Units:' says how long a unit is; give the key unit "
          "of [[panel]], the length of a unit in metres (0.001 for millimetres)",
          name()));
    pattern_.notes.push_back(
        fmt::format("{}: $MEASUREMENT = {}, so a unit is taken for {}; the key unit of [[panel]] would say so", name(),
                    measurement, measurement == 1 ? "a millimetre" : "an inch"));
    return measurement == 1 ? 1e-3 : 0.0254;
  }

  /// Blocks are read as they are, wherever a drawing places them: in no other size.
  void note_placed() {
    for (const DxfEntity& e : file_.entities) {
      if (e.type != "INSERT") continue;
      const std::string block = e.text(2);
      for (const int scale : {41, 42})
        if (std::abs(std::abs(e.real(scale, 1.0)) - 1.0) > 1e-9)
          e.fail(fmt::format("it places block '{}' {:g} times as large; explode it, or draw the block in its size",
                             block, e.real(scale, 1.0)));
      if (std::find(placed_.begin(), placed_.end(), block) == placed_.end()) placed_.push_back(block);
    }
  }

  void add(Piece piece) {
    const Mat2 scale = unit_ * Mat2::Identity();
    for (Edge& e : piece.edges) e.curve = e.curve.mapped(scale, Vec2::Zero());
    pattern_.pieces.push_back(std::move(piece));
  }

  static std::vector<Edge> edges_of(const std::vector<Curve>& loop) {
    std::vector<Edge> edges;
    for (const Curve& c : loop) edges.push_back({c});
    return edges;
  }

  void read_blocks(const std::vector<const DxfBlock*>& blocks) {
    std::map<std::string, int> count;
    for (const DxfBlock* b : blocks) ++count[told(b->entities, "piece name:")];
    for (const DxfBlock* b : blocks) {
      // Where sizes of one piece are there, or none has a name, blocks go by their own.
      const std::string own = told(b->entities, "piece name:"),
                        piece_name = own.empty() || count[own] > 1 ? b->name : own;
      seen_.push_back(piece_name);
      if (!is_wanted(piece_name)) continue;
      Piece piece = BlockReader(fmt::format("{}: block '{}'", name(), b->name), *b).run(pattern_.notes);
      piece.name = piece_name;
      add(std::move(piece));
    }
  }

  /// The outline that each one is a hole of, or its own number: of outlines that lie within each other every second one is a
  /// hole in that around it.
  static std::vector<std::size_t> pieces_of(const std::vector<std::vector<Curve>>& outlines) {
    Polygons polygons;
    for (const std::vector<Curve>& outline : outlines) polygons.push_back(polygon_of(outline));
    std::vector<std::vector<std::size_t>> around(outlines.size());
    for (std::size_t k = 0; k < outlines.size(); ++k)
      for (std::size_t other = 0; other < outlines.size(); ++other)
        if (other != k && is_inside(polygons[other], polygons[k].front())) around[k].push_back(other);
    std::vector<std::size_t> piece_of(outlines.size());
    for (std::size_t k = 0; k < outlines.size(); ++k) {
      piece_of[k] = k;
      for (const std::size_t other : around[k])
        if (around[k].size() % 2 == 1 && around[other].size() + 1 == around[k].size()) piece_of[k] = other;
    }
    return piece_of;
  }

  /// Each outline of a layer is a piece, called after the layer.
  void read_drawing() {
    std::vector<std::string> layers;
    for (const DxfEntity& e : file_.entities)
      if (std::find(layers.begin(), layers.end(), e.layer) == layers.end()) layers.push_back(e.layer);
    for (const std::string& layer : layers) {
      const auto wants = [&](const std::string& piece) { return piece == layer || piece.starts_with(layer + "-"); };
      if (!options_.pieces.empty() && std::none_of(options_.pieces.begin(), options_.pieces.end(), wants)) {
        seen_.push_back(layer);
        continue;
      }
      const std::vector<std::vector<Curve>> outlines =
          join_curves(fmt::format("{}: layer '{}'", name(), layer), curves_on(file_.entities, layer), {});
      const std::vector<std::size_t> piece_of = pieces_of(outlines);
      std::size_t count = 0, number = 0;
      for (std::size_t k = 0; k < outlines.size(); ++k) count += piece_of[k] == k ? 1 : 0;
      for (std::size_t k = 0; k < outlines.size(); ++k) {
        if (piece_of[k] != k) continue;
        Piece piece;
        piece.name = count == 1 ? layer : fmt::format("{}-{}", layer, number++);
        seen_.push_back(piece.name);
        if (!is_wanted(piece.name)) continue;
        piece.add_loop(edges_of(outlines[k]));
        for (std::size_t hole = 0; hole < outlines.size(); ++hole)
          if (hole != k && piece_of[hole] == k) piece.add_loop(edges_of(outlines[hole]));
        add(std::move(piece));
      }
    }
  }

  const ReadOptions& options_;
  DxfFile file_;
  Pattern pattern_;
  std::vector<std::string> seen_;    ///< names of outlines
  std::vector<std::string> placed_;  ///< names of blocks
  double unit_ = 0.0;
};

}  // namespace

Pattern read_dxf(const std::filesystem::path& file, const ReadOptions& options) {
  return DxfReader(file, options).run();
}

}  // namespace voile::pattern
