#include "contact_set.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace voile::contact {

namespace {

/// Fraction of the gap to a plane that a step leaves (as ccd.cpp for pairs).
constexpr double plane_kept = 0.2;
/// A first guess may lose this fraction of a gap, or of the activation distance.
constexpr double lost_fraction = 0.5;

template <class Matrix>
Matrix positive_part(const Matrix& h) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(h);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

/// Of the points of the sheet, of any length.
std::vector<Vec3> sheet_normals(const Surface& s, const std::vector<Vec3>& x) {
  std::vector<Vec3> normals(static_cast<std::size_t>(s.sheet_points), Vec3::Zero());
  for (Index t = 0; t < s.sheet_faces; ++t) {
    const auto& p = s.faces[t].points;
    const Vec3 normal = (x[p[1]] - x[p[0]]).cross(x[p[2]] - x[p[0]]);
    for (const Index i : p) normals[i] += normal;
  }
  return normals;
}

}  // namespace

ContactSet::ContactSet(Surface surface, std::vector<Plane> planes, ContactOptions options, std::vector<char> owned)
    : surface_(std::make_unique<Surface>(std::move(surface))),
      planes_(std::move(planes)),
      options_(options),
      candidates_(*surface_, options.distance, std::move(owned)) {}

bool ContactSet::counted(const std::array<Index, 4>& points) const {
  Index lowest = surface_->sheet_points;
  for (Index p : points)
    if (p != no_index) lowest = std::min(lowest, p);
  return lowest < surface_->sheet_points && candidates_.owned()[lowest];
}

double ContactSet::step_fraction(const std::vector<Vec3>& from, const std::vector<Vec3>& to) const {
  double fraction = 1.0;
  candidates_.for_close(from, to, 0.0, [&](const Pair& pair) {
    if (!acts(pair)) return;
    const std::array<Vec3, 4> x = gather(pair, from);
    std::array<Vec3, 4> p = gather(pair, to);
    for (int i = 0; i < 4; ++i) p[i] -= x[i];
    fraction = contact::step_fraction(pair.kind, x, p, offset(pair), fraction);
  });
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points()) {
      if (!plane_acts(p, i)) continue;
      const double gap = plane_gap(p, i, from), end = plane_gap(p, i, to);
      if (end < plane_kept * gap) fraction = std::min(fraction, (1.0 - plane_kept) * gap / (gap - end));
    }
  return fraction;
}

void ContactSet::blocked(const std::vector<Vec3>& from, const std::vector<Vec3>& to,
                         const std::vector<Plane>& planes_to, const std::vector<char>& asked,
                         const std::function<void(const Pair&)>& found) const {
  const auto lost = [&](double before, double after, double room) {
    return after < std::min(lost_fraction * before, room);
  };
  candidates_.for_close(from, to, lost_fraction * options_.distance, [&](const Pair& pair) {
    if (std::none_of(pair.points.begin(), pair.points.end(), [&](Index p) { return p != no_index && asked[p]; }) ||
        !acts(pair))
      return;
    const std::array<Vec3, 4> x = gather(pair, from), end = gather(pair, to);
    std::array<Vec3, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = end[i] - x[i];
    const double xi = offset(pair), room = lost_fraction * pair.fraction * options_.distance;
    const bool near_at_end = axis_distance(pair.kind, end) - xi < room;  // false for most candidates
    if ((near_at_end && lost(distance(pair.kind, x) - xi, distance(pair.kind, end) - xi, room)) ||
        contact::step_fraction(pair.kind, x, p, xi) < 1.0)
      found(pair);
  });
  for (std::size_t k = 0; k < planes_.size(); ++k)
    for (Index i : candidates_.own_points()) {
      const Plane& p = planes_[k];
      if (asked[i] && plane_acts(p, i) &&
          lost(plane_gap(p, i, from), plane_gap(planes_to[k], i, to), lost_fraction * options_.distance))
        found(plane_pair(p, i));
    }
}

// ---- normal contact ------------------------------------------------------------------------------------------------

double ContactSet::energy(const std::vector<Vec3>& x, Part part) const {
  const double barriers = part & normal ? barrier_energy(x) : 0.0;
  if (!(part & friction) || std::isinf(barriers)) return barriers;
  double sum = barriers;
  for (const Sliding& s : sliding_) {
    if (!counted(s.points)) continue;
    const double y = (s.tangents.transpose() * slip_of(s, x)).norm();
    sum += s.force * (y >= slip_ ? y - slip_ / 3.0 : y * y / slip_ * (1.0 - y / (3.0 * slip_)));
  }
  return sum;
}

double ContactSet::barrier_energy(const std::vector<Vec3>& x) const {
  double sum = 0.0;
  Near n;
  bool touches = false;
  candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
    const double d = reach(pair);
    if (touches || !counted(pair.points) || !near(pair, x, d, n)) return;
    const double m = pair.mollify > 0.0 ? mollifier(cross_squared(n.x), pair.mollify).value : 1.0;
    touches = !(n.gap > 0.0);
    if (!touches) sum += pair.area * m * barrier(n.gap, d).value;
  });
  if (touches) return std::numeric_limits<double>::infinity();
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points())
      if (plane_acts(p, i)) sum += surface_->area[i] * barrier(plane_gap(p, i, x), reach(i)).value;
  return options_.stiffness * sum;
}

void ContactSet::pair_gradient(const Pair& pair, const Near& n, double reach, Vec12& g) const {
  const Scalar2 b = barrier(n.gap, reach);
  const Vec3 normal = n.closest.w / n.closest.distance;
  const double scale = options_.stiffness * pair.area;
  for (int i = 0; i < 4; ++i) g.segment<3>(3 * i) = scale * b.first * n.closest.c[i] * normal;
  if (pair.mollify <= 0.0) return;
  const double x = cross_squared(n.x);
  if (x >= pair.mollify) return;
  Vec12 dx;
  (void)cross_squared(n.x, &dx);
  const Scalar2 m = mollifier(x, pair.mollify);
  g = m.value * g + scale * b.value * m.first * dx;
}

void ContactSet::pair_hessian(const Pair& pair, const Near& n, bool positive, Mat12& h) const {
  const Scalar2 b = barrier(n.gap, reach(pair));
  const double scale = options_.stiffness * pair.area, size = n.closest.c.norm();
  Motions motion;
  Mat5 h5 = b.first * distance_hessian(n.x, n.closest, motion);
  h5(0, 0) += b.second * size * size;
  const double x = pair.mollify > 0.0 ? cross_squared(n.x) : 1.0;
  const bool mollified = pair.mollify > 0.0 && x < pair.mollify;
  if (positive && !mollified) h5 = positive_part(h5);
  Eigen::Matrix<double, 12, 5> q;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 5; ++k) q.block<3, 1>(3 * i, k) = motion.weight[k][i] * motion.frame[k];
  h.noalias() = scale * q * h5 * q.transpose();
  if (!mollified) return;
  Vec12 dx, dd;
  Mat12 dxx;
  (void)cross_squared(n.x, &dx, &dxx);
  const Scalar2 m = mollifier(x, pair.mollify);
  const Vec3 normal = n.closest.w / n.closest.distance;
  for (int i = 0; i < 4; ++i) dd.segment<3>(3 * i) = n.closest.c[i] * normal;
  h = m.value * h + scale * (b.first * m.first * (dd * dx.transpose() + dx * dd.transpose()) +
                             b.value * (m.second * dx * dx.transpose() + m.first * dxx));
  if (positive) h = positive_part(h);
}

double ContactSet::add_gradient(const std::vector<Vec3>& x, std::vector<Vec3>& f, Part part) const {
  Near n;
  Vec12 g;
  double squares = 0.0;
  const bool on_face = (part & both) == 0;
  const std::vector<Vec3> upwards = on_face ? sheet_normals(*surface_, x) : std::vector<Vec3>();
  const auto add = [&](Index p, const Vec3& force) {
    if (p == no_index || !surface_->is_sheet(p)) return;
    if (on_face && (force.dot(upwards[p]) < 0.0) != (part == lower_face)) return;
    f[p] += force;
    if (candidates_.owned()[p]) squares += force.squaredNorm();
  };
  if ((part & normal) != 0 || on_face) {
    candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
      const double d = reach(pair);
      if (!near(pair, x, d, n)) return;
      pair_gradient(pair, n, d, g);
      for (int i = 0; i < 4; ++i) add(pair.points[i], g.segment<3>(3 * i));
    });
    for (const Plane& p : planes_)
      for (Index i : candidates_.own_points()) {
        if (!plane_acts(p, i)) continue;
        const double gap = plane_gap(p, i, x), d = reach(i);
        if (gap < d) add(i, options_.stiffness * surface_->area[i] * barrier(gap, d).first * p.normal);
      }
  }
  if (part & friction)
    for (const Sliding& s : sliding_) {
      const Vec2 r = s.tangents.transpose() * slip_of(s, x);
      const double y = r.norm(), rate = friction_rate(y);
      const Vec3 force = s.force * rate * (s.tangents * r);
      for (int i = 0; i < 4; ++i) add(s.points[i], s.c[i] * force);
    }
  return squares;
}

void ContactSet::add_force_on_bodies(const std::vector<Vec3>& x, std::vector<Vec3>& on) const {
  Near n;
  Vec12 g;
  candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
    const double d = reach(pair);
    if (!counted(pair.points) || !near(pair, x, d, n)) return;
    pair_gradient(pair, n, d, g);
    for (int i = 0; i < 4; ++i)
      if (const Index p = pair.points[i]; p != no_index) on[surface_->body_of_point[p]] -= g.segment<3>(3 * i);
  });
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points()) {
      const double gap = plane_gap(p, i, x), d = reach(i);
      if (plane_acts(p, i) && gap < d)
        on[p.body] += options_.stiffness * surface_->area[i] * barrier(gap, d).first * p.normal;
    }
  for (const Sliding& s : sliding_) {
    if (!counted(s.points)) continue;
    const Vec2 r = s.tangents.transpose() * slip_of(s, x);
    const Vec3 force = s.force * friction_rate(r.norm()) * (s.tangents * r);
    if (s.weight == 0.0 && s.carrier >= 0) on[s.carrier] += force;  // a plane has no points
    for (int i = 0; i < 4; ++i)
      if (const Index p = s.points[i]; p != no_index) on[surface_->body_of_point[p]] -= s.c[i] * force;
  }
}

double ContactSet::obstacle_work(const std::vector<Vec3>& x, const Then& at_start) const {
  const std::vector<Vec3>& start = at_start.places;
  double sum = 0.0;
  Near n;
  Vec12 g, then;
  candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
    const bool moved = std::any_of(pair.points.begin(), pair.points.end(), [&](Index p) {
      return p != no_index && !surface_->is_sheet(p) && x[p] != start[p];
    });
    const double d = reach(pair), d_then = reach(pair, at_start.reaches);
    if (!moved || !counted(pair.points) || !near(pair, x, d, n)) return;
    pair_gradient(pair, n, d, g);
    if (near(pair, start, d_then, n)) {
      pair_gradient(pair, n, d_then, then);
      g = 0.5 * (g + then);
    }
    for (int i = 0; i < 4; ++i)
      if (const Index p = pair.points[i]; p != no_index && !surface_->is_sheet(p))
        sum += g.segment<3>(3 * i).dot(x[p] - start[p]);
  });
  for (std::size_t k = 0; k < planes_.size(); ++k)
    for (Index i : candidates_.own_points()) {
      const Plane &now = planes_[k], &then_plane = at_start.planes[k];
      if (!plane_acts(now, i)) continue;
      const double gap = plane_gap(now, i, x), gap_then = plane_gap(then_plane, i, start), d = reach(i),
                   d_then = at_start.reaches.empty() ? options_.distance : at_start.reaches[i];
      if (!(gap < d)) continue;
      double pressure = barrier(gap, d).first;
      if (gap_then > 0.0 && gap_then < d_then) pressure = 0.5 * (pressure + barrier(gap_then, d_then).first);
      // The gap changes by the displacement of the point, and by this.
      const double change = (now.normal - then_plane.normal).dot(start[i]) - (now.level - then_plane.level);
      sum += options_.stiffness * surface_->area[i] * pressure * change;
    }
  return sum;
}

// ---- friction ------------------------------------------------------------------------------------------------------

void ContactSet::lag_friction(const std::vector<Vec3>& x, const std::vector<Vec3>& start, double slip) {
  sliding_.clear();
  slips_known_ = false;
  slip_ = slip;
  lagged_ = true;
  if (!has_friction()) return;
  Near n;
  candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
    const double d = reach(pair);
    if (!near(pair, x, d, n)) return;
    const double m = pair.mollify > 0.0 ? mollifier(cross_squared(n.x), pair.mollify).value : 1.0;
    const double force = -options_.stiffness * pair.area * m * barrier(n.gap, d).first;
    add_sliding(pair, n.closest.c, n.closest.w / n.closest.distance, force, x, start);
  });
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points()) {
      if (!plane_acts(p, i)) continue;
      const double g = plane_gap(p, i, x), d = reach(i);
      if (g >= d) continue;
      add_sliding(plane_pair(p, i), Vec4::UnitX(), p.normal,
                  -options_.stiffness * surface_->area[i] * barrier(g, d).first, x, start);
    }
}

std::vector<double> ContactSet::smallest_gaps(const std::vector<Vec3>& x) const {
  return gaps_of(candidates_.pairs(), x, options_.distance, true);
}

std::vector<double> ContactSet::gaps_within(const std::vector<Vec3>& x, double limit) const {
  std::vector<Box> boxes(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) boxes[i].include(x[i]);
  return gaps_of(find_pairs(*surface_, all_figures(*surface_), boxes, candidates_.owned(), limit), x, limit, false);
}

std::vector<Pair> ContactSet::sheet_pairs_within(const std::vector<Vec3>& x, double limit) const {
  std::vector<Box> boxes(x.size());
  for (const Index i : candidates_.sheet().points) boxes[i].include(x[i]);
  std::vector<Pair> pairs = find_pairs(*surface_, candidates_.sheet(), boxes, candidates_.owned(), limit);
  Near n;
  std::erase_if(pairs, [&](const Pair& pair) { return !near(pair, x, limit, n); });
  return pairs;
}

std::vector<double> ContactSet::gaps_of(const std::vector<Pair>& pairs, const std::vector<Vec3>& x, double limit,
                                        bool as_barrier) const {
  std::vector<double> gaps(static_cast<std::size_t>(surface_->sheet_points), limit);
  Near n;
  for (const Pair& pair : pairs) {
    if (!near(pair, x, as_barrier ? pair.fraction * limit : limit, n)) continue;
    for (Index i : pair.points)
      if (i != no_index && surface_->is_sheet(i)) gaps[i] = std::min(gaps[i], n.gap);
  }
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points())
      if (plane_acts(p, i)) gaps[i] = std::min(gaps[i], plane_gap(p, i, x));
  return gaps;
}

ContactState ContactSet::state(const std::vector<Vec3>& x) const {
  ContactState r;
  Near n;
  candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
    if (!counted(pair.points) || !near(pair, x, pair.fraction * options_.distance, n)) return;
    ++r.pairs;
    if (n.gap >= r.gap) return;
    r.gap = n.gap;
    r.nearest = pair;
  });
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points()) {
      if (!plane_acts(p, i)) continue;
      const double g = plane_gap(p, i, x);
      if (g >= options_.distance) continue;
      ++r.pairs;
      if (g < r.gap) {
        r.gap = g;
        r.nearest = plane_pair(p, i);
      }
    }
  return r;
}

}  // namespace voile::contact
