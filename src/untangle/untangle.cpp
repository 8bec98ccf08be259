#include "untangle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "coincident.hpp"
#include "gaps.hpp"
#include "piercing.hpp"
#include "regions.hpp"
#include "solids.hpp"
#include "tangle.hpp"
#include "voile/errors.hpp"

namespace voile::untangle {

namespace {

/// What the piercings of a round ask of each point; it moves by the mean.
class Corrections {
 public:
  explicit Corrections(const Tangle& tangle)
      : tangle_(tangle), sum_(tangle.pieces.size(), Vec3::Zero()), count_(sum_.size(), 0.0) {}

  void lift(const Lift& l);
  /// Along the contour: the edge by half, the triangle by half the other way, or what alone may move by all.
  void shorten(const Piercing& p);
  void send_back(const Piercing& p, Index end);
  /// The sheet's points come first in x.
  void apply_to(std::vector<Vec3>& x) const {
    for (std::size_t v = 0; v < sum_.size(); ++v) x[v] += sum_[v] / std::max(count_[v], 1.0);
  }

 private:
  void fraction(const std::array<Index, 4>& points, const Vec4& c, const Vec3& d) {
    tangle_.fraction(points, c, d, [&](Index v, const Vec3& movement) {
      sum_[v] += movement;
      count_[v] += 1.0;
    });
  }

  const Tangle& tangle_;
  std::vector<Vec3> sum_;      ///< [m]
  std::vector<double> count_;  ///< of what is asked
};

void Corrections::lift(const Lift& l) {
  fraction({l.edge[0], l.edge[1], no_index, no_index}, Vec4(1.0 - l.t, l.t, 0.0, 0.0), l.way);
}

void Corrections::shorten(const Piercing& p) {
  const Surface& s = tangle_.surface;
  const auto& q = s.faces[p.face].points;
  const Vec3& b = p.weights;
  const Vec3 d = (s.is_sheet(p.edge[0]) && s.is_sheet(q[0]) ? 0.5 : 1.0) * along_contour(tangle_, p);
  fraction({p.edge[0], p.edge[1], no_index, no_index}, Vec4(1.0 - p.t, p.t, 0.0, 0.0), d);
  fraction({q[0], q[1], q[2], no_index}, Vec4(b[0], b[1], b[2], 0.0), -d);
}

void Corrections::send_back(const Piercing& p, Index end) {
  const auto& q = tangle_.surface.faces[p.face].points;
  const Vec3& b = p.weights;
  fraction({end, q[0], q[1], q[2]}, Vec4(1.0, -b[0], -b[1], -b[2]), back_through(tangle_, p, end));
}

/// A piece of the sheet and what pierces it, which is a piece or an obstacle; the piercings between them.
using Groups = std::map<std::pair<Index, Index>, std::vector<Piercing>>;

void add_to(Groups& groups, const Tangle& tangle, const Piercing& p) {
  const Surface& s = tangle.surface;
  const Face& face = s.faces[p.face];
  const Index other = p.face < s.sheet_faces ? tangle.pieces[face.points[0]] : s.sheet_points + face.body;
  groups[{tangle.pieces[p.edge[0]], other}].push_back(p);
}

/// An end on the wrong side goes back through the triangle; if regions do not tell, the line of intersection shortens.
void correct(Corrections& corrections, const Tangle& tangle, const std::vector<Piercing>& group,
             const std::set<Segment>& gaps) {
  std::set<Segment> pierced;
  for (const Piercing& p : group) pierced.insert(p.edge);
  const Sides sides = sides_of(tangle.surface, pierced, gaps);
  for (const Piercing& p : group) {
    const Index end = wrong_end(p.edge, sides);
    if (end == no_index)
      corrections.shorten(p);
    else
      corrections.send_back(p, end);
  }
}

/// Moves what pierces and is pierced. An edge of an obstacle has no wrong side: its line of intersection shortens.
void uncross(Tangle& tangle, const Solids& solids, const FacePairs& pairs) {
  const std::vector<Piercing> found = find_piercings(tangle, pairs);
  Corrections corrections(tangle);
  for (const Lift& l : solids.lifts(tangle, found)) corrections.lift(l);
  Groups groups;
  for (const Piercing& p : found) {
    if (!tangle.surface.is_sheet(p.edge[0]))
      corrections.shorten(p);
    else if (!solids.are_passed(tangle, p))
      add_to(groups, tangle, p);
  }
  const std::set<Segment> gaps = border_gaps(tangle, found);
  for (const auto& [parts, group] : groups) correct(corrections, tangle, group, gaps);
  corrections.apply_to(tangle.x);
}

void count_movement(const std::vector<Vec3>& from, const std::vector<Vec3>& to, UntangleResult& r) {
  r.moved = 0;
  r.farthest = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double way = (to[i] - from[i]).norm();
    if (way > 0.0) ++r.moved;
    r.farthest = std::max(r.farthest, way);
  }
}

}  // namespace

UntangleResult untangle(const Surface& surface, const std::vector<Plane>& planes, const std::vector<Mat3>& free,
                        const FindIntersections& find, const UntangleOptions& options, std::vector<Vec3>& x) {
  if (x.size() != surface.rest.size() || free.size() != static_cast<std::size_t>(surface.sheet_points))
    throw InternalError(fmt::format("untangle: {} positions and {} projectors for {} points, {} of the sheet", x.size(),
                                    free.size(), surface.points(), surface.sheet_points));
  const std::vector<Vec3> start = x;
  Tangle tangle(surface, free, options, x);
  Solids solids(surface);
  Gaps gaps(tangle, planes);
  UntangleResult r, best;
  std::vector<Vec3> best_x, before;
  for (;; ++r.rounds) {
    const auto pairs = find(x);
    r.left = pairs.size();
    r.gap = gaps.smallest();
    count_movement(start, x, r);
    r.done = pairs.empty() && r.gap > 0.0 && r.farthest <= options.limit;
    if (r.done && (!best.done || r.gap > best.gap)) {
      best = r;
      best_x = x;
    }
    const bool wide = r.gap >= least_gap * options.activation_distance;
    // A round that moved nothing is the last: so would be all others.
    if ((r.done && wide) || r.rounds == options.rounds || r.farthest > options.limit || x == before) break;
    before = x;
    part_coincident(tangle);
    if (!pairs.empty()) {
      solids.leave(tangle, pairs);
      uncross(tangle, solids, pairs);
    }
    gaps.widen(pairs.empty());
  }
  if (!best.done) return r;
  x = best_x;
  return best;
}

}  // namespace voile::untangle
