#include "repair.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/decompositions.hpp"
#include "undo.hpp"

namespace voile::adapt {

namespace {

/// Of the condition, below which a change counts as one.
constexpr double improvement = 0.98;
/// L/h of edges that may go where a patch is bad.
constexpr double shortish = 0.9;
/// What counts as such where sums are made.
constexpr double infinite_condition = 1e6;
/// Times that what is left is looked at again.
constexpr int searches = 4;
/// Of the triangulation in all searches of a remeshing: where contact refuses what would help, all are made.
constexpr int most_copies = 100;

using Row6 = Eigen::Matrix<double, 1, 6>;

/// Monomials, scaled so that the condition number does not depend on the direction of the axes.
Row6 row_of(const Vec2& p) {
  Row6 row;
  row << 1.0, p.x(), p.y(), 0.5 * p.x() * p.x(), 0.5 * p.y() * p.y(), std::sqrt(0.5) * p.x() * p.y();
  return row;
}

/// Triangles whose patches hold a triangle: itself and its neighbours.
void add_patches(const Surface& s, Index t, std::vector<Index>& to) {
  const auto add = [&](Index n) {
    if (std::find(to.begin(), to.end(), n) == to.end()) to.push_back(n);
  };
  add(t);
  for (Index h = 3 * t; h < 3 * t + 3; ++h)
    if (s.twin[h] != no_index) add(s.twin[h] / 3);
}

double worst_condition(const Surface& s, const std::vector<Index>& triangles) {
  double worst = 0.0;
  for (Index t : triangles) worst = std::max(worst, patch_condition(s, t));
  return worst;
}

/// Turns the edge if the worst patch around gets better by that.
bool mend_by_flip(Surface& s, Index h, const Options& options) {
  const Index g = s.twin[h];
  if (g == no_index) return false;
  std::vector<Index> around;
  add_patches(s, h / 3, around);
  add_patches(s, g / 3, around);
  const double before = worst_condition(s, around);
  const Counts counts = s.counts;
  Surface::Budget budgets[2];
  if (!s.allowed.empty())
    for (const int i : {0, 1}) budgets[i] = {s.moved[(i ? g : h) / 3], s.allowed[(i ? g : h) / 3]};
  if (try_flip(s, h, options, FlipRule::none) != Outcome::done) return false;
  if (worst_condition(s, around) < improvement * before) return true;
  // Turning the new edge gives the old triangles, each in the other's place.
  s.flip(next(h));
  s.counts = counts;
  if (!s.allowed.empty())
    for (const int i : {0, 1}) {
      s.moved[(i ? h : g) / 3] = budgets[i].moved;
      s.allowed[(i ? h : g) / 3] = budgets[i].allowed;
    }
  return false;
}

/// Where a vertex may be moved to: towards the mean of its neighbours, and around.
std::vector<Vec2> targets_of(const Fan& fan) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : fan.plane) mean += p / fan.size();
  double reach = std::numeric_limits<double>::infinity();
  for (const Vec2& p : fan.plane) reach = std::min(reach, (p - fan.centre).norm());
  std::vector<Vec2> targets{mean, 0.5 * (mean + fan.centre)};
  for (const double step : {0.1, 0.3})
    for (int k = 0; k < 8; ++k) {
      const double a = k * std::numbers::pi / 4.0;
      targets.emplace_back(fan.centre + step * reach * Vec2(std::cos(a), std::sin(a)));
    }
  return targets;
}

/// Moves a vertex towards the mean of its neighbours if the worst patch around gets better by that.
bool mend_by_move(Surface& s, Index v, const Options& options) {
  if (s.fixed[v] || s.on_feature[v]) return false;
  const Star star = star_of(s, v);
  std::vector<Index> around;
  for (Index e : star.spokes) add_patches(s, e / 3, around);
  const double before = worst_condition(s, around);
  const Fan fan = make_fan(s, star, 0, star.triangles());
  const MoveUndo undo(s, star);
  for (const Vec2& target : targets_of(fan)) {
    if (try_move(s, star, fan, target, options.smallest_angle) != Outcome::done) continue;
    if (worst_condition(s, around) < improvement * before) return true;
    undo(s, star);
  }
  return false;
}

bool remove_vertex(Surface& s, Index v, const Options& options) {
  if (s.fixed[v] || s.on_feature[v]) return false;
  const Star star = star_of(s, v);
  for (int k = 0; k < star.triangles(); ++k)
    if (try_collapse(s, star, k, options, {false}) == Outcome::done) return true;
  return false;
}

/// Inner vertices of a triangle that have few neighbours.
Index sparse_vertex(const Surface& s, Index t, int edges) {
  for (Index h = 3 * t; h < 3 * t + 3; ++h) {
    const Surface::Valence v = s.valence(h);
    if (v.inside && v.edges <= edges) return s.origin(h);
  }
  return no_index;
}

bool mend(Surface& s, Index t, const Options& options) {
  const Index sparse = sparse_vertex(s, t, 3);
  if (sparse != no_index && remove_vertex(s, sparse, options)) return true;
  std::vector<Index> sides;
  for (Index h = 3 * t; h < 3 * t + 3; ++h) {
    sides.push_back(h);
    if (s.twin[h] != no_index) sides.insert(sides.end(), {next(s.twin[h]), prev(s.twin[h])});
  }
  for (Index h : sides)
    if (mend_by_flip(s, h, options)) return true;
  for (Index h = 3 * t; h < 3 * t + 3; ++h)
    if (mend_by_move(s, s.vertex[h], options)) return true;
  for (Index h = 3 * t; h < 3 * t + 3; ++h)
    if (s.twin[h] != no_index && mend_by_move(s, s.apex(s.twin[h]), options)) return true;
  for (Index h : sides)
    if (s.metric_length(h) < shortish && try_collapse_edge(s, h, options) == Outcome::done) return true;
  const Index four = sparse_vertex(s, t, 4);
  return four != no_index && remove_vertex(s, four, options);
}

/// Whether a patch wants to be mended.
bool is_bad(const Surface& s, Index t) {
  return !s.dead[t] && !s.frozen[t] && patch_condition(s, t) > largest_condition;
}

void unite(std::vector<Index>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// A triangle and those that share a vertex with it, `rings` times over.
std::vector<Index> triangles_around(const Surface& s, Index t, int rings) {
  std::vector<Index> found{t};
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<Index> vertices;
    for (Index n : found)
      for (Index h = 3 * n; h < 3 * n + 3; ++h) vertices.push_back(s.vertex[h]);
    unite(vertices);
    for (Index v : vertices)
      for (Index e : star_of(s, v).spokes) found.push_back(e / 3);
    unite(found);
  }
  return found;
}

/// How far patches are beyond the limit, all together.
double excess(const Surface& s, const std::vector<Index>& triangles) {
  double sum = 0.0;
  for (Index t : triangles)
    if (is_bad(s, t)) sum += std::log(std::min(patch_condition(s, t), infinite_condition) / largest_condition);
  return sum;
}

/// What single changes cannot mend: one that need not gain by itself, then what gains beside it, all taken back if patches
/// around are not better together. `copies`: how many may still be made to take changes back.
bool mend_by_search(Surface& s, Index t, int rings, const Options& options, int& copies) {
  const std::vector<Index> near = triangles_around(s, t, rings), inner = triangles_around(s, t, rings + 1),
                           outer = triangles_around(s, t, rings + 3);
  const double before = excess(s, outer);
  const Surface start = s;
  const auto gains = [&] {
    --copies;
    for (int pass = 0; pass < 4; ++pass)
      for (Index n : inner)
        if (is_bad(s, n)) (void)mend(s, n, options);
    if (excess(s, outer) < improvement * before) return true;
    s = start;
    return false;
  };
  std::vector<Index> sides, vertices;
  for (Index n : near)
    for (Index h = 3 * n; h < 3 * n + 3; ++h) {
      if (s.twin[h] == no_index || s.twin[h] > h) sides.push_back(h);
      if (!s.fixed[s.vertex[h]] && !s.on_feature[s.vertex[h]]) vertices.push_back(s.vertex[h]);
    }
  unite(vertices);
  for (Index h : sides)
    if (copies > 0 && try_flip(s, h, options, FlipRule::none) == Outcome::done && gains()) return true;
  for (Index v : vertices) {
    const Star star = star_of(s, v);
    const Fan fan = make_fan(s, star, 0, star.triangles());
    for (const Vec2& target : targets_of(fan))
      if (copies > 0 && try_move(s, star, fan, target, options.smallest_angle) == Outcome::done && gains()) return true;
  }
  for (Index h : sides)
    if (copies > 0 && s.metric_length(h) < shortish && try_collapse_edge(s, h, options) == Outcome::done && gains())
      return true;
  return false;
}

}  // namespace

double patch_condition(const Surface& s, Index t) {
  const Index c = 3 * t;
  const Vec3 centre = (s.rest[c] + s.rest[c + 1] + s.rest[c + 2]) / 3.0;
  const Vec3 cross = (s.rest[c + 1] - s.rest[c]).cross(s.rest[c + 2] - s.rest[c]);
  const Vec3 normal = cross.normalized(), e1 = (s.rest[c + 1] - s.rest[c]).normalized(), e2 = normal.cross(e1);
  const double scale = std::sqrt(0.5 * cross.norm());
  const auto flat = [&](const Vec3& x) { return Vec2((x - centre).dot(e1), (x - centre).dot(e2)); };
  Mat6 m;
  for (int i = 0; i < 3; ++i) {
    const Index h = c + i, g = s.twin[h];
    if (g == no_index) return 0.0;
    m.row(i) = row_of(flat(s.rest[h]) / scale);
    // In the neighbour's chart the side begins where it ends here.
    const Vec3 start = s.rest[prev(g)], side = s.rest[next(g)] - start, x = s.rest[g] - start;
    const double own = side.norm(), along = x.dot(side) / own, away = (x - along / own * side).norm();
    const Vec2 a = flat(s.rest[next(h)]), d = flat(s.rest[prev(h)]) - a, unit = d.normalized();
    const double stretch = d.norm() / own;
    m.row(3 + i) = row_of((a + stretch * (along * unit + away * Vec2(unit.y(), -unit.x()))) / scale);
  }
  const Eigen::VectorXd squares = eigenvalues(Eigen::MatrixXd(m.transpose() * m));
  const double low = squares[0], high = squares[5];
  // Below this the small one is round-off.
  return low > 1e-14 * high ? std::sqrt(high / low) : std::numeric_limits<double>::infinity();
}

void repair(Surface& s, const Options& options) {
  std::vector<Index> look, left;
  for (Index t = 0; t < s.triangle_slots(); ++t) look.push_back(t);
  for (int pass = 0; pass < 8 && !look.empty(); ++pass) {
    std::vector<Index> again;
    for (Index t : look) {
      if (!is_bad(s, t)) continue;
      // Found before: the triangle itself may go.
      const std::vector<Index> around = triangles_around(s, t, 2);
      std::vector<Index>& to = mend(s, t, options) ? again : left;
      to.insert(to.end(), around.begin(), around.end());
    }
    unite(again);
    look.swap(again);
  }
  left.insert(left.end(), look.begin(), look.end());
  unite(left);
  int copies = most_copies;
  for (int pass = 0, mended = 1; pass < searches && (pass < 2 || mended > 0); ++pass) {
    mended = 0;
    for (Index t : left)
      if (copies > 0 && is_bad(s, t)) mended += mend_by_search(s, t, std::min(pass + 1, 2), options, copies);
  }
}

Outcome try_move_well(Surface& s, const Star& star, const Fan& fan, const Vec2& target, double angle) {
  std::vector<Index> around;
  for (Index e : star.spokes) add_patches(s, e / 3, around);
  const double limit = std::max(largest_condition, worst_condition(s, around));
  const MoveUndo undo(s, star);
  const Outcome outcome = try_move(s, star, fan, target, angle);
  if (outcome != Outcome::done || worst_condition(s, around) <= limit) return outcome;
  undo(s, star);
  return Outcome::quality;
}

Quality quality_of(const Surface& s) {
  Quality q;
  std::vector<double> angles;
  for (Index t = 0; t < s.triangle_slots(); ++t) {
    if (s.dead[t]) continue;
    const Vec3 &a = s.rest[3 * t], &b = s.rest[3 * t + 1], &c = s.rest[3 * t + 2];
    angles.push_back(smallest_angle(a, b, c, (b - a).cross(c - a)));
    const double condition = patch_condition(s, t);
    q.largest_condition = std::max(q.largest_condition, condition);
    if (condition > largest_condition) ++q.ill_conditioned;
  }
  q.smallest_angle = *std::min_element(angles.begin(), angles.end());
  const auto rank = static_cast<std::ptrdiff_t>(angles.size() / 100);
  std::nth_element(angles.begin(), angles.begin() + rank, angles.end());
  q.percent_angle = angles[static_cast<std::size_t>(rank)];
  for (Index v = 0; v < s.vertex_slots(); ++v) {
    if (s.gone[v]) continue;
    const Surface::Valence valence = s.valence(s.leaving[v]);
    if (valence.inside && valence.edges == 3) ++q.valence_three;
    if (valence.inside && valence.edges == 4) ++q.valence_four;
  }
  return q;
}

}  // namespace voile::adapt
