#include "seams.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/text.hpp"
#include "names.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Ratios of the lengths of the two sides: what is refused, and what is remarked.
constexpr double largest_ratio = 4.0, unusual_ratio = 2.0;

using Side = std::vector<EdgeUse>;

std::string edge_name(const std::vector<Panel>& panels, const EdgeUse& e) {
  return fmt::format("{}/{}", panels[e.panel].piece.name, e.edge);
}

std::size_t corner(const std::vector<Panel>& panels, const EdgeUse& e, bool at_end) {
  return at_end == e.reversed ? e.edge : panels[e.panel].piece.next(e.edge);
}

Vec3 corner_place(const std::vector<Panel>& panels, const EdgeUse& e, bool at_end) {
  return panels[e.panel].place(panels[e.panel].piece.point(corner(panels, e, at_end)));
}

Side reversed(Side side) {
  std::reverse(side.begin(), side.end());
  for (EdgeUse& e : side) e.reversed = !e.reversed;
  return side;
}

class Resolver {
 public:
  explicit Resolver(const std::vector<Panel>& panels)
      : panels_(panels), sense_(panels.size(), 1), chain_(panels.size()) {
    std::iota(chain_.begin(), chain_.end(), std::size_t{0});
  }

  void add(const SeamRequest& r) {
    SeamLine line;
    line.sides = {chain(r, r.edges), chain(r, r.to)};
    line.name = seam_name(r.name, r.edges, r.to);
    use(r, line);
    for (const SeamLine& other : found_.lines)
      if (other.name == line.name)
        throw UserError(fmt::format("{}: seam '{}': another seam has this name", r.where, line.name));
    orient(r, line);
    measure(r, line);
    check_dart(r, line);
    found_.lines.push_back(std::move(line));
    requests_.push_back(&r);
  }

  Seams take() {
    note_layers();
    for (std::size_t k = 0; k < found_.lines.size(); ++k) check_twist(*requests_[k], found_.lines[k]);
    return std::move(found_);
  }

 private:
  [[noreturn]] static void fail(const SeamRequest& r, const std::string& message) {
    throw UserError(fmt::format("{}: {}", r.where, message));
  }

  [[nodiscard]] std::size_t panel(const SeamRequest& r, const std::string& name, const std::string& given) const {
    return find_panel(panels_, name, r.where, given);
  }

  /// All edges of a side: "PIECE/FROM..TO" means those from a point to another, in the order of the file.
  [[nodiscard]] Side uses(const SeamRequest& r, const std::vector<std::string>& given) const {
    Side all;
    for (const std::string& name : given) {
      const std::size_t slash = name.rfind('/'), dots = name.find("..", slash == std::string::npos ? 0 : slash);
      if (slash == std::string::npos || dots == std::string::npos) {
        all.push_back(edge(r, name));
        continue;
      }
      const std::size_t p = panel(r, name.substr(0, slash), name);
      const Piece& piece = panels_[p].piece;
      const auto from = find_point(panels_[p], name.substr(slash + 1, dots - slash - 1)),
                 to = find_point(panels_[p], name.substr(dots + 2));
      if (!from || !to || *from == *to)
        fail(r, fmt::format("'{}': write PIECE/FROM..TO with two points of the piece, which has 0 to {}{}", name,
                            piece.edges.size() - 1, named_points(panels_[p])));
      if (piece.loop_of(*from).begin != piece.loop_of(*to).begin)
        fail(r, fmt::format("'{}': one of the points is on the outline, or on one hole, and the other on another hole, "
                            "so no edges lead from one to the other; name points of one of them",
                            name));
      for (std::size_t k = *from; k != *to; k = piece.next(k)) all.push_back({p, k, false});
    }
    return all;
  }

  [[nodiscard]] EdgeUse edge(const SeamRequest& r, const std::string& given) const {
    const std::size_t slash = given.rfind('/');
    if (slash == std::string::npos) fail(r, fmt::format("'{}': write an edge as PIECE/EDGE", given));
    const std::size_t p = panel(r, given.substr(0, slash), given);
    const std::string word = given.substr(slash + 1);
    const std::vector<Edge>& edges = panels_[p].piece.edges;
    if (const auto k = number_below(word, edges.size())) return {p, *k, false};
    std::vector<std::size_t> labelled;
    for (std::size_t k = 0; k < edges.size(); ++k)
      if (!word.empty() && edges[k].label == word) labelled.push_back(k);
    if (labelled.size() == 1) return {p, labelled.front(), false};
    fail(r, labelled.empty()
                ? fmt::format("'{}': the piece has no such edge; it has {}, counted from 0", given, edges.size())
                : fmt::format("'{}': edges {} have this label; name one by its number", given, join(labelled, ", ")));
  }

  using Key = std::pair<std::size_t, std::size_t>;  ///< panel and edge
  static Key key(const EdgeUse& e) { return {e.panel, e.edge}; }

  [[nodiscard]] std::set<std::string> names_of(const Side& side) const {
    std::set<std::string> names;
    for (const EdgeUse& e : side) names.insert(edge_name(panels_, e));
    return names;
  }

  /// An edge may be in several seams, but once in each of them, and with another edge in only one.
  void use(const SeamRequest& r, const SeamLine& line) {
    std::set<Key> own;
    for (const Side& side : line.sides)
      for (const EdgeUse& e : side)
        if (!own.insert(key(e)).second)
          fail(r, fmt::format("seam '{}': edge {} is in it twice; an edge cannot be sewn to itself: name another edge, "
                              "or divide it by a point",
                              line.name, edge_name(panels_, e)));
    const std::array sides{names_of(line.sides[0]), names_of(line.sides[1])};
    for (std::size_t k = 0; k < found_.lines.size(); ++k) {
      const std::array other{names_of(found_.lines[k].sides[0]), names_of(found_.lines[k].sides[1])};
      if (other == sides || other == std::array{sides[1], sides[0]})
        fail(r, fmt::format("{} {} sewn to {} in a seam already ({}); remove one of the seams, or divide the edge, "
                            "of a pleat as docs/howto/sew-a-pattern.md has it",
                            fmt::join(sides[0], ", "), own.size() == 2 ? "is" : "are", fmt::join(sides[1], ", "),
                            requests_[k]->where));
    }
    for (const Key& e : own) used_[e].push_back(found_.lines.size());
  }

  /// Where three layers and more meet, which a wrong name may also be the cause of.
  void note_layers() {
    for (const auto& [edge, seams] : used_) {
      if (seams.size() < 2) continue;
      std::vector<std::string> names;
      for (const std::size_t k : seams) names.push_back(fmt::format("'{}'", found_.lines[k].name));
      found_.notes.push_back(fmt::format("edge {} is in {} seams, {}: {} layers or more meet there in one line",
                                         edge_name(panels_, {edge.first, edge.second, false}), seams.size(),
                                         join(names, ", "), seams.size() + 1));
    }
  }
  /// Sheets end where three layers meet, so their right sides need not agree.
  [[nodiscard]] bool is_layered(const EdgeUse& e) const { return used_.at(key(e)).size() > 1; }

  /// Directions of the edges of a side such that each begins where the one before ends.
  [[nodiscard]] Side chain(const SeamRequest& r, const std::vector<std::string>& names) const {
    const Side given = uses(r, names);
    Side best;
    double least = std::numeric_limits<double>::infinity();
    for (const bool turned : {false, true}) {
      Side side;
      double gaps = 0.0;
      for (EdgeUse e : given) {
        e.reversed = turned;
        if (!side.empty()) gaps += append_direction(side.back(), e);
        side.push_back(e);
      }
      if (gaps < least) best = side;
      least = std::min(least, gaps);
    }
    return best;
  }

  /// Chooses the direction of an edge after another; returns the way between them.
  [[nodiscard]] double append_direction(const EdgeUse& before, EdgeUse& e) const {
    std::array<double, 2> gap{};
    for (const bool turned : {false, true}) {
      e.reversed = turned;
      const bool shared = before.panel == e.panel && corner(panels_, before, true) == corner(panels_, e, false);
      gap[turned] =
          shared ? 0.0 : (corner_place(panels_, before, true) - corner_place(panels_, e, false)).norm() + 1e-9;
    }
    e.reversed = gap[1] < gap[0];
    return std::min(gap[0], gap[1]);
  }

  /// Mean distance of points that would meet, and the largest.
  [[nodiscard]] std::pair<double, double> distances(const Side& a, const Side& b) const {
    constexpr int parts = 16;
    std::vector<double> fractions;
    for (int i = 0; i <= parts; ++i) fractions.push_back(static_cast<double>(i) / parts);
    const std::vector<Vec3> x = places(a, fractions), y = places(b, fractions);
    double sum = 0.0, most = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += (x[i] - y[i]).norm() / static_cast<double>(x.size());
      most = std::max(most, (x[i] - y[i]).norm());
    }
    return {sum, most};
  }

  [[nodiscard]] std::vector<Vec3> places(const Side& side, const std::vector<double>& fractions) const {
    const double total = length_of(panels_, side);
    std::vector<Vec3> x;
    std::size_t k = 0;
    double before = 0.0;
    for (const double f : fractions) {
      const auto length = [&] { return panels_[side[k].panel].piece.edges[side[k].edge].curve.length(); };
      while (k + 1 < side.size() && f * total > before + length()) before += length(), ++k;
      const double local = std::clamp((f * total - before) / length(), 0.0, 1.0);
      const Curve& c = panels_[side[k].panel].piece.edges[side[k].edge].curve;
      x.push_back(
          panels_[side[k].panel].place(c.at(c.parameters_at({side[k].reversed ? 1.0 - local : local}).front())));
    }
    return x;
  }

  /// The side turned so that it begins at a point.
  void begin_at(const SeamRequest& r, const std::string& given, Side& side) const {
    const auto [p, k] = find_point(panels_, r.where + ": meet", given);
    const auto is_here = [&, p = p, k = k](const EdgeUse& e, bool at_end) {
      return e.panel == p && corner(panels_, e, at_end) == k;
    };
    if (is_here(side.front(), false)) return;
    if (!is_here(side.back(), true))
      fail(r, fmt::format("meet: '{}' is no end of its side, which runs from {}@{} to {}@{}", given,
                          panels_[side.front().panel].piece.name, corner(panels_, side.front(), false),
                          panels_[side.back().panel].piece.name, corner(panels_, side.back(), true)));
    side = reversed(side);
  }

  /// Whether a side ends where it begins, as round a hole: then `meet` does not say which way it goes.
  [[nodiscard]] bool is_closed(const Side& side) const {
    return side.front().panel == side.back().panel &&
           corner(panels_, side.front(), false) == corner(panels_, side.back(), true);
  }

  /// Whether two sides end in one point of a piece: at the end of each that is named.
  [[nodiscard]] bool fraction_end(const Side& a, bool a_at_end, const Side& b, bool b_at_end) const {
    const EdgeUse &e = a_at_end ? a.back() : a.front(), &f = b_at_end ? b.back() : b.front();
    return e.panel == f.panel && corner(panels_, e, a_at_end) == corner(panels_, f, b_at_end);
  }

  void orient(const SeamRequest& r, SeamLine& line) {
    auto& [a, b] = line.sides;
    // The legs of a dart meet in their tip, whatever else is nearer.
    if (r.meet.empty() && r.sense == Sense::nearest) {
      const bool as_is = fraction_end(a, false, b, false) || fraction_end(a, true, b, true);
      const bool turned = fraction_end(a, false, b, true) || fraction_end(a, true, b, false);
      if (turned && !as_is) b = reversed(b);
      if (turned != as_is) return;
    }
    if (!r.meet.empty()) {
      begin_at(r, r.meet[0], a);
      begin_at(r, r.meet[1], b);
      if (is_closed(a) && is_closed(b) && distances(a, reversed(b)).first < distances(a, b).first) b = reversed(b);
      return;
    }
    const double as_is = distances(a, b).first, turned = distances(a, reversed(b)).first;
    if (r.sense == Sense::against) b = reversed(b);
    const double taken = r.sense == Sense::against ? turned : as_is, other = r.sense == Sense::against ? as_is : turned;
    if (r.sense == Sense::nearest) {
      Side& side = is_closed(b) && !is_closed(a) ? a : b;  // the points that the note names mean this way
      if (turned < as_is) side = reversed(side);
      found_.notes.push_back(fmt::format(
          "seam '{}': {}@{} meets {}@{}, which is the shorter way at the start ({:.3g} m on average, {:.3g} m "
          "the other way round); the key meet sets it",
          line.name, panels_[a.front().panel].piece.name, corner(panels_, a.front(), false),
          panels_[b.front().panel].piece.name, corner(panels_, b.front(), false), std::min(as_is, turned),
          std::max(as_is, turned)));
    } else if (taken > 2.0 * other + 0.02) {
      found_.notes.push_back(
          fmt::format("seam '{}': its sides are {:.3g} m apart at the start, the other way round {:.3g} m; if it comes "
                      "out twisted, correct its sense in {}",
                      line.name, taken, other, r.where));
    }
  }

  void measure(const SeamRequest& r, SeamLine& line) {
    for (std::size_t s = 0; s < 2; ++s) line.lengths[s] = length_of(panels_, line.sides[s]);
    line.farthest = distances(line.sides[0], line.sides[1]).second;
    const auto [low, high] = std::minmax(line.lengths[0], line.lengths[1]);
    if (high > largest_ratio * low)
      fail(r, fmt::format("seam '{}': its sides are {:.4g} m and {:.4g} m long; more than {:g} times as much cannot be "
                          "gathered: correct the edges, or the unit of a piece",
                          line.name, line.lengths[0], line.lengths[1], largest_ratio));
    if (high > unusual_ratio * low)
      found_.notes.push_back(
          fmt::format("seam '{}': sides of {:.4g} m and {:.4g} m are sewn together, {:.2g} times as "
                      "much",
                      line.name, line.lengths[0], line.lengths[1], high / low));
  }

  /// Two edges of one piece with but a short one between them: a dart whose legs have no common tip.
  void check_dart(const SeamRequest& r, const SeamLine& line) const {
    if (line.sides[0].size() != 1 || line.sides[1].size() != 1) return;
    const EdgeUse &a = line.sides[0].front(), &b = line.sides[1].front();
    if (a.panel != b.panel) return;
    const Panel& p = panels_[a.panel];
    for (const auto& [first, second] : {std::pair{a.edge, b.edge}, std::pair{b.edge, a.edge}}) {
      const std::size_t between = p.piece.next(first);
      if (between == second) {  // neighbours: their common corner must stay one point
        const bool tip = corner(panels_, a, false) == corner(panels_, b, false) ||
                         corner(panels_, a, true) == corner(panels_, b, true);
        if (!tip)
          fail(r,
               fmt::format("seam '{}': edges {} and {} of piece '{}' have point {} in common, but it would be sewn to "
                           "the far end of the other: an edge would collapse; let their far ends meet",
                           line.name, first, second, p.piece.name, second));
      } else if (p.piece.next(between) == second && p.piece.next(second) != first) {
        const double gap = p.piece.edges[between].curve.length();
        if (gap < p.size && gap < 0.2 * std::min(line.lengths[0], line.lengths[1]))
          fail(r, fmt::format(
                      "seam '{}': the legs {} and {} of a dart in piece '{}' have no common tip: edge {} of {:.3g} m "
                      "lies between them, shorter than a cell; let both legs end at one point, or make the cells "
                      "smaller",
                      line.name, first, second, p.piece.name, between, gap));
      }
    }
  }

  /// +1 if the fabric lies on that side of an edge on which it lies of the sides of its triangles: an outline that goes round
  /// as they do, a hole that goes the other way.
  [[nodiscard]] int way_round(const EdgeUse& e) const {
    const Piece& piece = panels_[e.panel].piece;
    const bool as_triangles = (piece.signed_area(piece.loop_of(e.edge)) > 0.0) != piece.turned;
    return as_triangles == piece.is_in_outline(e.edge) ? 1 : -1;
  }

  /// Whether all seams so far leave a surface with two sides: panels hang together in chains, each with a sense.
  void check_twist(const SeamRequest& r, const SeamLine& line) {
    const auto root = [&](std::size_t p) {
      int sense = 1;
      for (; chain_[p] != p; p = chain_[p]) sense *= sense_[p];
      return std::pair{p, sense};
    };
    const auto way = [&](const EdgeUse& e) { return way_round(e) * (e.reversed ? -1 : 1); };
    const auto tie = [&](const EdgeUse& a, const EdgeUse& b) {
      const int wanted = way(a) * way(b) < 0 ? 1 : -1;
      const auto [p, s] = root(a.panel);
      const auto [q, t] = root(b.panel);
      if (p == q && s * t != wanted)
        fail(r, fmt::format("seam '{}' between {} and {} closes a chain of pieces with a twist: the right side of the "
                            "fabric would meet the wrong side; let the other ends meet, or turn a piece over",
                            line.name, edge_name(panels_, a), edge_name(panels_, b)));
      if (p == q) return;
      chain_[q] = p;
      sense_[q] = s * t * wanted;
    };
    double end_a = 0.0;  // share at which an edge of the one side ends
    for (const EdgeUse& a : line.sides[0]) {
      const double begin_a = end_a;
      end_a += length_of(panels_, {a}) / line.lengths[0];
      double end_b = 0.0;
      for (const EdgeUse& b : line.sides[1]) {
        const double begin_b = end_b;
        end_b += length_of(panels_, {b}) / line.lengths[1];
        if (is_layered(a) || is_layered(b)) continue;
        if (std::min(end_a, end_b) - std::max(begin_a, begin_b) > 0.01) tie(a, b);
      }
    }
  }

  const std::vector<Panel>& panels_;
  std::map<Key, std::vector<std::size_t>> used_;  ///< numbers of the seams of each edge
  std::vector<const SeamRequest*> requests_;      ///< of the seams
  std::vector<int> sense_;                        ///< of each panel against the one it hangs on
  std::vector<std::size_t> chain_;                ///< that one
  Seams found_;
};

}  // namespace

double length_of(const std::vector<Panel>& panels, const std::vector<EdgeUse>& side) {
  double sum = 0.0;
  for (const EdgeUse& e : side) sum += panels[e.panel].piece.edges[e.edge].curve.length();
  return sum;
}

std::string seam_name(const std::string& given, const std::vector<std::string>& edges,
                      const std::vector<std::string>& to) {
  return given.empty() ? fmt::format("{}-{}", edges.front(), to.front()) : given;
}

Seams resolve_seams(const std::vector<Panel>& panels, const std::vector<SeamRequest>& requests) {
  Resolver resolver(panels);
  for (const SeamRequest& r : requests) resolver.add(r);
  return resolver.take();
}

}  // namespace voile::pattern
