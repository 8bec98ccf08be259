#include "curvature.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "free_sides.hpp"
#include "patch_fit.hpp"

namespace voile::energy {

namespace {

/// A linear functional of the point positions, and what it is of the rest shape, in some chart.
struct Functional {
  std::map<Index, double> weights;
  Vec3 rest = Vec3::Zero();
};

/// Largest condition number at which a least-squares ring fit is accepted before another ring is added.
constexpr double max_ring_condition = 60.0;
constexpr int max_rings = 3;
/// Relative difference below which two bending stiffnesses are the same.
constexpr double same_stiffness = 1e-9;

/// Whether D is the same in all axes.
bool is_isotropic(const Mat3& d) {
  const double within = same_stiffness * d.norm();
  return std::abs(d(0, 0) - d(1, 1)) <= within && std::abs(d(0, 2)) <= within && std::abs(d(1, 2)) <= within &&
         std::abs(d(2, 2) - 0.5 * (d(0, 0) - d(0, 1))) <= within;
}

/// Derivative of the monomials along direction n.
Row6 slope_row(const Vec2& p, const Vec2& n) {
  Row6 row;
  row << 0.0, n.x(), n.y(), p.x() * n.x(), p.y() * n.y(), p.x() * n.y() + p.y() * n.x();
  return row;
}

/// Contribution of a slope along n on a side to (k11, k22, 2 k12).
Vec3 voigt(const Vec2& slope, const Vec2& n) {
  return {slope.x() * n.x(), slope.y() * n.y(), slope.x() * n.y() + slope.y() * n.x()};
}

/// `turn`: from the chart of the fit to that of `to`.
void add(Functional& to, const Fit& fit, const Row6& functional, double factor, const Mat3& turn = Mat3::Identity()) {
  const Eigen::RowVectorXd w = factor * functional * fit.coefficients;
  Vec3 rest = Vec3::Zero();
  for (std::size_t i = 0; i < fit.points.size(); ++i) {
    to.weights[fit.points[i]] += w[static_cast<Eigen::Index>(i)];
    rest += w[static_cast<Eigen::Index>(i)] * fit.rest[i];
  }
  to.rest += turn * rest;
}

}  // namespace

struct CurvatureBuilder::Impl {
  struct Entry {
    mesh::Patch patch;
    Beyond beyond;
    Fit fit;
  };

  const Sheet& sheet;
  mesh::PatchMesh patches;
  std::unordered_map<Index, Entry> entries;
  /// The patches cut along all jumps of the stiffness: rings stay on one side. Made when the first is asked for.
  std::optional<mesh::PatchMesh> apart;

  const Entry& entry(Index t) {
    const auto found = entries.find(t);
    if (found != entries.end()) return found->second;
    const mesh::Frame frame = sheet.frame(t);
    Entry e;
    e.patch = patches.patch(t, frame);
    e.beyond = jumps_of(t, e.patch);
    e.fit = fit_patch(e.patch, frame.origin, sheet.material(t).bending, e.beyond);
    return entries.emplace(t, std::move(e)).first->second;
  }

  /// Stiffness beyond the sides of t where it is another one.
  Beyond jumps_of(Index t, const mesh::Patch& patch) const {
    Beyond beyond;
    if (sheet.options().bending == BendingOperator::six_node) return beyond;  // as published
    const Mat3& here = sheet.material(t).bending;
    for (int s = 0; s < 3; ++s) {
      const Index other = patches.apex(t, s) == no_index ? no_index : sheet.mesh().neighbour(t, s);
      if (other == no_index) continue;
      const Mat3& there = sheet.material(other).bending;
      const bool same = sheet.material_index(t) == sheet.material_index(other);
      if (same && is_isotropic(here)) continue;
      const int so = sheet.mesh().side_in_neighbour(t, s);
      const Vec2 mine = side_of(patch, s).tangent,
                 theirs = -side_of(patches.patch(other, sheet.frame(other)), so).tangent;
      const double turn = std::atan2(mine.y(), mine.x()) - std::atan2(theirs.y(), theirs.x());
      const Mat3 seen = rotated_stiffness(there, turn);
      if ((seen - here).norm() > same_stiffness * here.norm()) beyond[s] = seen;
    }
    return beyond;
  }

  const mesh::PatchMesh& one_sided() {
    if (!apart) {
      std::vector<mesh::TriangleSide> sides;
      for (Index t = 0; t < sheet.mesh().triangle_count(); ++t) {
        const Beyond beyond = jumps_of(t, patches.patch(t, sheet.frame(t)));
        for (int s = 0; s < 3; ++s)
          if (beyond[s]) sides.push_back({t, s});
      }
      apart = sides.empty() ? patches : patches.cut_along(sides);
    }
    return *apart;
  }

  bool usable(const Fit& fit) const { return fit.condition <= sheet.options().max_patch_condition; }

  /// Ring fit around triangle t, or around its side s, about `origin` in the plane of t.
  Fit ring_fit(Index t, int s, const Vec2& origin) {
    const mesh::Frame frame = sheet.frame(t);
    // Of a side the same from both triangles: their numbers say which one defines its slope.
    const double across = s < 0 ? entry(t).patch.area : entry(sheet.mesh().neighbour(t, s)).patch.area;
    const double scale = std::sqrt(0.5 * (entry(t).patch.area + across));
    Fit best;
    for (int rings = 1; rings <= max_rings; ++rings) {
      Fit fit = fit_rings(one_sided().unfolded_rings(t, s, rings, frame), frame.origin, origin, scale);
      if (fit.condition < best.condition) best = std::move(fit);
      if (best.condition <= max_ring_condition) break;
    }
    return best;
  }

  /// phi of interior side s of t as seen from t, times `factor`, added to `to`. `turn`: from the chart of t to that of
  /// `to`.
  void add_interior_slope(Functional& to, Index t, int s, double factor, const Mat3& turn = Mat3::Identity()) {
    const Index other = sheet.mesh().neighbour(t, s);
    const Mat3 across = turn * sheet.mesh().chart_join(t, s).turn;
    if (other < t) {  // one triangle defines the slope, so that both see exactly the same
      add_interior_slope(to, other, sheet.mesh().side_in_neighbour(t, s), -factor, across);
      return;
    }
    const int so = sheet.mesh().side_in_neighbour(t, s);
    const Entry &here = entry(t), &there = entry(other);
    const Side mine = side_of(here.patch, s), theirs = side_of(there.patch, so);
    const auto use = [&](double fraction_here, double fraction_there) {
      if (fraction_here > 0.0) add(to, here.fit, slope_row(mine.middle, mine.normal), factor * fraction_here, turn);
      if (fraction_there > 0.0)
        add(to, there.fit, slope_row(theirs.middle, theirs.normal), -factor * fraction_there, across);
    };
    const bool good_here = here.fit.complete && usable(here.fit), good_there = there.fit.complete && usable(there.fit);
    if (good_here || good_there) {
      const double fraction = good_here && good_there ? own_weight(here, t, s) : good_here ? 1.0 : 0.0;
      use(fraction, 1.0 - fraction);
      return;
    }
    if (here.beyond[s] && add_ring_slopes(to, t, s, factor, turn)) return;
    const Fit rings = ring_fit(t, s, mine.middle);
    if (!here.beyond[s] && rings.condition <= max_ring_condition) {
      add(to, rings, slope_row(Vec2::Zero(), mine.normal), factor, turn);
    } else if (usable(here.fit) || usable(there.fit)) {  // narrow strips: the free-edge condition completes the patch
      const double fraction = usable(here.fit) && usable(there.fit) ? own_weight(here, t, s)
                              : usable(here.fit)                    ? 1.0
                                                                    : 0.0;
      use(fraction, 1.0 - fraction);
    } else {
      add_linear_slope(to, here.patch, s, mine, 0.5 * factor, turn);
      add_linear_slope(to, there.patch, so, theirs, -0.5 * factor, across);
    }
  }

  /// Weight of the slope that t finds for its side s, beside that of its neighbour: the stiffer side errs at greater cost.
  double own_weight(const Entry& here, Index t, int s) const {
    if (!here.beyond[s]) return 0.5;
    const Vec2 n = side_of(here.patch, s).normal;
    const double own = normal_stiffness(sheet.material(t).bending, n), other = normal_stiffness(*here.beyond[s], n);
    return own / (own + other);
  }

  /// phi of a jump from rings on each side; false if neither has enough points.
  bool add_ring_slopes(Functional& to, Index t, int s, double factor, const Mat3& turn) {
    const Index other = sheet.mesh().neighbour(t, s);
    const int so = sheet.mesh().side_in_neighbour(t, s);
    const Side mine = side_of(entry(t).patch, s), theirs = side_of(entry(other).patch, so);
    const Fit here = ring_fit(t, -1, mine.middle), there = ring_fit(other, -1, theirs.middle);
    const bool good_here = here.condition <= max_ring_condition, good_there = there.condition <= max_ring_condition;
    const double fraction = good_here && good_there ? own_weight(entry(t), t, s) : good_here ? 1.0 : 0.0;
    if (fraction > 0.0) add(to, here, slope_row(Vec2::Zero(), mine.normal), factor * fraction, turn);
    if (good_there && fraction < 1.0)
      add(to, there, slope_row(Vec2::Zero(), theirs.normal), -factor * (1.0 - fraction),
          turn * sheet.mesh().chart_join(t, s).turn);
    return good_here || good_there;
  }

  /// Slope of the flat triangle itself: the last resort, exact for linear fields only.
  static void add_linear_slope(Functional& to, const mesh::Patch& p, int s, const Side& side, double factor,
                               const Mat3& turn) {
    const int a = (s + 1) % 3, b = (s + 2) % 3;
    const double height = 2.0 * p.area / side.length;
    const double along = (p.coordinates[s] - p.coordinates[a]).dot(side.tangent) / side.length;
    to.weights[p.points[s]] -= factor / height;
    to.weights[p.points[a]] += factor * (1.0 - along) / height;
    to.weights[p.points[b]] += factor * along / height;
    to.rest += turn * ((factor / height) * ((1.0 - along) * (p.rest[a] - p.rest[s]) + along * (p.rest[b] - p.rest[s])));
  }

  CurvatureOperator build(Index t);
  Unreleased edge_slope(Index t);
  CurvatureOperator six_node(Index t);
};

namespace {

CurvatureOperator operator_of(const std::map<Index, Vec3>& columns, const Mat3& rest) {
  CurvatureOperator op;
  op.rest = rest;
  op.weights.resize(3, static_cast<Eigen::Index>(columns.size()));
  for (const auto& [point, w] : columns) {
    op.weights.col(static_cast<Eigen::Index>(op.points.size())) = w;
    op.points.push_back(point);
  }
  return op;
}

/// Moves one-row functionals into an operator with ascending points.
CurvatureOperator collect(const std::array<Functional, 3>& rows) {
  std::map<Index, Vec3> columns;
  Mat3 rest;
  for (int r = 0; r < 3; ++r) {
    for (const auto& [point, w] : rows[r].weights) columns.try_emplace(point, Vec3::Zero()).first->second[r] += w;
    rest.row(r) = rows[r].rest.transpose();
  }
  return operator_of(columns, rest);
}

}  // namespace

CurvatureBuilder::Unreleased CurvatureBuilder::Impl::edge_slope(Index t) {
  const mesh::Patch& patch = entry(t).patch;
  std::array<Functional, 3> rows;
  Unreleased result;
  for (int s = 0; s < 3; ++s) {
    const int a = (s + 1) % 3, b = (s + 2) % 3;
    const Side side = side_of(patch, s);
    const double fraction = side.length / patch.area;
    const Vec3 along = fraction * voigt(side.tangent, side.normal) / side.length;
    for (int r = 0; r < 3; ++r) {
      rows[r].weights[patch.points[b]] += along[r];
      rows[r].weights[patch.points[a]] -= along[r];
      rows[r].rest += along[r] * (patch.rest[b] - patch.rest[a]);
    }
    const Vec3 across = fraction * voigt(side.normal, side.normal);
    if (patch.points[3 + s] == no_index) {
      result.sides.push_back(s);
      result.across.push_back(across);
      continue;
    }
    Functional slope;
    if (patches.is_mirror(patch.points[3 + s])) {
      const double height = 2.0 * patch.area / side.length;
      slope.weights[patch.points[3 + s]] = 0.5 / height;
      slope.weights[patch.points[s]] = -0.5 / height;
      slope.rest = 0.5 / height * (patch.rest[3 + s] - patch.rest[s]);
    } else {
      add_interior_slope(slope, t, s, 1.0);
    }
    for (int r = 0; r < 3; ++r) {
      for (const auto& [point, w] : slope.weights) rows[r].weights[point] += across[r] * w;
      rows[r].rest += across[r] * slope.rest;
    }
  }
  result.operator_ = collect(rows);
  return result;
}

CurvatureOperator CurvatureBuilder::Impl::six_node(Index t) {
  const Entry& here = entry(t);
  Fit fit = here.fit;
  if (!usable(fit)) {
    Fit rings = ring_fit(t, -1, Vec2::Zero());
    if (rings.condition < fit.condition) fit = std::move(rings);
  }
  std::array<Functional, 3> rows;
  for (int r = 0; r < 3; ++r) {
    Row6 second = Row6::Zero();
    second[3 + r] = r == 2 ? 2.0 : 1.0;
    if (fit.condition < 1e12) add(rows[r], fit, second, 1.0);
  }
  return collect(rows);
}

CurvatureOperator CurvatureBuilder::Impl::build(Index t) {
  if (sheet.options().bending == BendingOperator::six_node) return six_node(t);
  auto [op, sides, across] = edge_slope(t);
  const Mat3 condensed = condense_free_sides(across, sheet.material(t).bending);
  op.weights = condensed * op.weights;
  op.rest = condensed * op.rest;
  return op;
}

namespace {

/// cut + weight (whole - cut).
CurvatureOperator between(const CurvatureOperator& cut, const CurvatureOperator& whole, double weight) {
  std::map<Index, Vec3> columns;
  const auto add_columns = [&](const CurvatureOperator& op, double fraction) {
    for (std::size_t i = 0; i < op.points.size(); ++i)
      columns.try_emplace(op.points[i], Vec3::Zero()).first->second +=
          fraction * op.weights.col(static_cast<Eigen::Index>(i));
  };
  add_columns(cut, 1.0 - weight);
  add_columns(whole, weight);
  return operator_of(columns, (1.0 - weight) * cut.rest + weight * whole.rest);
}

}  // namespace

/// The sheet cut along its seams, and which triangles know of that.
struct CurvatureBuilder::Cut {
  Impl impl;
  std::unordered_map<Index, double> factor;  ///< of triangles beside a seam, then of their neighbours
  std::vector<char> near;                    ///< triangles that a fit could reach a seam from
  double smallest;

  explicit Cut(const Sheet& sheet);
  [[nodiscard]] double factor_of(Index t) const {
    const auto found = factor.find(t);
    return found == factor.end() ? smallest : found->second;
  }
};

CurvatureBuilder::Cut::Cut(const Sheet& sheet)
    : impl{sheet, sheet.patches(), {}, {}},
      near(static_cast<std::size_t>(sheet.mesh().triangle_count()), 0),
      smallest(std::numeric_limits<double>::infinity()) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  std::vector<mesh::TriangleSide> sides;
  const auto lower = [&](Index t, double f) {
    double& least = factor.try_emplace(t, f).first->second;
    least = std::min(least, f);
  };
  for (const BendingSide& s : sheet.seams()) {
    sides.push_back(s.side);
    smallest = std::min(smallest, s.factor);
    lower(s.side.triangle, s.factor);
    near[s.side.triangle] = 1;
  }
  impl.patches = sheet.patches().cut_along(sides);
  const std::unordered_map<Index, double> beside = factor;
  for (const auto& [t, f] : beside)
    for (int k = 0; k < 3; ++k)
      if (const Index n = mesh.neighbour(t, k); n != no_index && !beside.contains(n)) lower(n, f);
  for (int ring = 0; ring <= max_rings; ++ring) {
    const std::vector<char> before = near;
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      if (before[t])
        for (const Index v : mesh.triangles()[t])
          for (const Index n : mesh.triangles_of_vertex(v)) near[n] = 1;
  }
}

CurvatureBuilder::CurvatureBuilder(const Sheet& sheet)
    : impl_(std::make_unique<Impl>(Impl{sheet, sheet.patches(), {}, {}})) {
  if (!sheet.seams().empty()) cut_ = std::make_unique<Cut>(sheet);
}
CurvatureBuilder::~CurvatureBuilder() = default;

CurvatureOperator CurvatureBuilder::build(Index t) {
  CurvatureOperator whole = impl_->build(t);
  if (!cut_ || !cut_->near[t]) return whole;
  const CurvatureOperator cut = cut_->impl.build(t);
  if (cut.points == whole.points && cut.weights == whole.weights) return whole;
  return between(cut, whole, std::sqrt(cut_->factor_of(t)));
}

CurvatureBuilder::Unreleased CurvatureBuilder::build_unreleased(Index t) {
  return impl_->edge_slope(t);
}

double CurvatureBuilder::patch_condition(Index t) {
  return impl_->entry(t).fit.condition;
}

}  // namespace voile::energy
