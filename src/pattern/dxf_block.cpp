// Blocks of AAMA/ASTM D6673, a piece each: what its layers say.
#include "dxf_block.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dxf_slits.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Layers of a piece.
const std::string boundary = "1", turn_points = "2", curve_points = "3", notches = "4", mirror_line = "6",
                  grain_line = "7", cutout = "11", sew_line = "14";
/// Change of direction at which a boundary without turn points has a corner [rad].
constexpr double corner_angle = 15.0 * 3.14159265358979 / 180.0;
/// Fraction of the extent of a piece within which marks count as on its outline, and lines as the same.
constexpr double on_outline = 1e-3;
/// Fraction of the extent of a piece within which a notch belongs to its outline: those of the boundary, seen from the sew line, do.
constexpr double near_outline = 0.08;

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
    std::vector<Vec2> slits;
    std::vector<Curve> outline = one_outline(mirror, slits);
    for (const Curve& c : outline) size_ = std::max(size_, (c.start() - outline.front().start()).norm());
    Piece piece;
    piece.add_loop(divided(std::move(outline), mirror, slits, {"", piece.point_names}, notes));
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
  std::vector<Curve> one_outline(const std::vector<Curve>& mirror, std::vector<Vec2>& slits) const {
    std::string layer = sew_line;
    std::vector<Curve> curves = curves_on(block_.entities, layer, &slits);
    if (curves.empty()) curves = curves_on(block_.entities, layer = boundary, &slits);
    take_out_double_lines(curves, slits);
    std::vector<std::vector<Curve>> outlines = join_curves(fmt::format("{}, layer {}", where_, layer), curves, mirror);
    if (outlines.size() != 1)
      throw UserError(fmt::format("{}: layer {} has {} outlines, and a piece has one; put others on other layers",
                                  where_, layer, outlines.size()));
    take_out_slits(outlines.front(), slits);
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

  /// An outline, what lies before each of its curves, and the line that it unfolds across, if any.
  struct Outline {
    std::vector<Curve> curves;
    std::vector<bool> corners, marks;
    const Curve* mirror;
  };

  [[nodiscard]] bool is_on(const Curve& mirror, const Curve& c) const {
    double away = 0.0;
    for (int i = 0; i <= 8; ++i) away = std::max(away, distance_from(mirror, c.at(i / 8.0)));
    return away <= on_outline * size_;
  }

  /// Divides the curve of the outline that a notch lies nearest to, and says before which curve it then lies. The fold stays
  /// whole: a notch there is inside of the piece.
  std::size_t divide_at(Outline& o, const Vec2& notch) const {
    std::vector<Curve>& outline = o.curves;
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity(), fraction = 0.0;
    for (std::size_t k = 0; k < outline.size(); ++k) {
      if (o.mirror && is_on(*o.mirror, outline[k])) continue;
      const auto [t, distance] = outline[k].nearest(notch);
      if (distance < least) best = k, fraction = t;
      least = std::min(least, distance);
    }
    if (least > near_outline * size_) return outline.size();
    const std::size_t next = (best + 1) % outline.size();
    const double tolerance = on_outline * size_;
    const auto at = static_cast<std::ptrdiff_t>(best);
    if ((outline[best].start() - outline[best].at(fraction)).norm() <= tolerance) return best;
    if ((outline[best].end() - outline[best].at(fraction)).norm() <= tolerance) return next;
    auto [first, second] = outline[best].split(fraction);
    outline[best] = std::move(first);
    outline.insert(outline.begin() + at + 1, std::move(second));
    o.corners.insert(o.corners.begin() + at + 1, false);
    o.marks.insert(o.marks.begin() + at + 1, false);
    return best + 1;
  }

  /// Where names of points go, and what they begin with.
  struct Naming {
    std::string prefix;
    std::vector<std::string>& names;
  };

  /// Edges between corners, slits and notches, from the first corner on, and names of their points.
  std::vector<Edge> divided(std::vector<Curve> curves, const std::vector<Curve>& mirror, const std::vector<Vec2>& slits,
                            const Naming& naming, std::vector<std::string>& notes) const {
    Outline o{std::move(curves), {}, {}, mirror.empty() ? nullptr : &mirror.front()};
    o.corners = corners_of(o.curves, mirror);
    o.marks.assign(o.curves.size(), false);
    std::vector<Vec2> all = points_on(block_.entities, notches);
    all.insert(all.end(), slits.begin(), slits.end());
    for (const Vec2& notch : all) {
      if (const std::size_t k = divide_at(o, notch); k < o.curves.size()) {
        o.marks[k] = true;
        continue;
      }
      const bool on_fold = o.mirror && distance_from(*o.mirror, notch) <= on_outline * size_;
      notes.push_back(fmt::format("{}: a notch, ({:.4g}, {:.4g}) in the file's units, {}", where_, notch[0], notch[1],
                                  on_fold ? "lies on the mirror line, inside of the whole piece: it divides no edge"
                                          : "is too far from the outline to divide it"));
    }
    return joined(std::move(o.curves), std::move(o.corners), std::move(o.marks), naming);
  }

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
      if (is_on(mirror, piece.edges[k].curve)) return k;
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

}  // namespace

std::vector<Curve> curves_on(const std::vector<DxfEntity>& entities, const std::string& layer,
                             std::vector<Vec2>* slits) {
  std::vector<Curve> all;
  for (const DxfEntity& e : entities)
    if (e.layer == layer)
      for (Curve& c : curves_of(e, slits)) all.push_back(std::move(c));
  return all;
}

bool is_piece(const DxfBlock& block) {
  return std::any_of(block.entities.begin(), block.entities.end(),
                     [](const DxfEntity& e) { return e.layer == boundary || e.layer == sew_line; });
}

Piece read_block(const std::string& where, const DxfBlock& block, std::vector<std::string>& notes) {
  return BlockReader(where, block).run(notes);
}

}  // namespace voile::pattern
