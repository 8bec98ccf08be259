// Friction of contact pairs: slips, what turns with an obstacle, the second derivative.
#include <algorithm>
#include <cmath>

#include "contact_set.hpp"

namespace voile::contact {

Vec3 ContactSet::slip_of(const Sliding& s, const std::vector<Vec3>& x) const {
  Vec3 w = s.carried - s.start;
  for (int i = 0; i < 4; ++i)
    if (s.points[i] != no_index) w += s.c[i] * x[s.points[i]];
  return w;
}

double ContactSet::friction_work(const std::vector<Vec3>& x) const {
  double sum = 0.0;
  for (const Sliding& s : sliding_) {
    if (!counted(s.points)) continue;
    const double y = (s.tangents.transpose() * slip_of(s, x)).norm();
    sum += s.force * friction_rate(y) * y * y;
  }
  return sum;
}

void ContactSet::follow_slips(const std::vector<Vec3>& x) {
  for (Sliding& s : sliding_) {
    const Vec2 r = s.tangents.transpose() * slip_of(s, x);
    if (slips_known_ && r != s.slip) s.change = (r - s.slip).norm();
    s.slip = r;
  }
  slips_known_ = true;
}

/// With the true second derivative what slips overshoots, sticks and slips in turns as long as iterates are far from
/// the solution; near it the secant converges only linearly, and at the limit of sticking hardly at all.
Mat2 ContactSet::friction_stiffness(const Vec2& r, bool secant) const {
  const double y = r.norm(), rate = friction_rate(y);
  Mat2 k = rate * Mat2::Identity();
  if (!secant && y > 0.0) k -= r * r.transpose() / (y * std::pow(std::max(y, slip_), 2));
  return k;
}

void ContactSet::add_sliding(const Pair& pair, const Vec4& c, const Vec3& n, double normal_force,
                             const std::vector<Vec3>& x, const std::vector<Vec3>& start) {
  const double mu = surface_->rules[pair.body_a][pair.body_b].friction;
  if (mu <= 0.0 || normal_force <= 0.0) return;
  Sliding s{pair.points,  c,  {},  mu * normal_force, Vec3::Zero(), Vec3::Zero(),
            Vec3::Zero(), -1, 0.0, no_index,          Vec3::Zero()};
  s.tangents.col(0) = n.unitOrthogonal();
  s.tangents.col(1) = n.cross(s.tangents.col(0));
  double sheet = 0.0;
  for (int i = 0; i < 4; ++i) {
    if (pair.points[i] == no_index) continue;
    const Vec3 part = c[i] * x[pair.points[i]];
    s.start += c[i] * start[pair.points[i]];
    if (surface_->is_sheet(pair.points[i])) {
      s.place += part;
      sheet += c[i];
    } else {
      s.carrier = surface_->body_of_point[pair.points[i]];
      s.face = face_of(pair.points[i]);
      s.axis += part;
      s.weight += c[i];
    }
  }
  if (s.weight != 0.0) {
    s.place /= sheet;
    s.axis /= s.weight;
  } else if (pair.points[1] == no_index) {
    s.carrier = pair.body_b;  // a plane has no points
  }
  sliding_.push_back(s);
}

bool ContactSet::has_friction() const {
  return std::any_of(surface_->rules.begin(), surface_->rules.end(), [](const auto& row) {
    return std::any_of(row.begin(), row.end(), [](const Rule& r) { return r.touch && r.friction > 0.0; });
  });
}

Index ContactSet::face_of(Index point) {
  if (face_of_point_.empty()) {
    face_of_point_.assign(static_cast<std::size_t>(surface_->points()), no_index);
    for (Index f = surface_->sheet_faces; f < static_cast<Index>(surface_->faces.size()); ++f)
      for (const Index p : surface_->faces[static_cast<std::size_t>(f)].points) face_of_point_[p] = f;
  }
  return face_of_point_[point];
}

namespace {

/// Along the first side of a triangle, across it, and normal.
Mat3 axes_of(const Face& f, const std::vector<Vec3>& x) {
  const Vec3 side = x[f.points[1]] - x[f.points[0]], normal = side.cross(x[f.points[2]] - x[f.points[0]]).normalized();
  Mat3 axes;
  axes << side.normalized(), normal.cross(side.normalized()), normal;
  return axes;
}

}  // namespace

void ContactSet::carry(const Carrier& displacement, const std::vector<Vec3>& start, const std::vector<Vec3>& now) {
  for (Sliding& s : sliding_) {
    if (s.carrier < 0) continue;
    // What the obstacle's points have moved is in the slip already; a plane has none.
    const std::optional<Vec3> at_place = displacement(s.carrier, s.place);
    if (at_place) {
      s.carried = s.weight != 0.0 ? Vec3(s.weight * (*at_place - *displacement(s.carrier, s.axis))) : Vec3(-*at_place);
    } else if (s.face != no_index) {
      const Face& face = surface_->faces[static_cast<std::size_t>(s.face)];
      const Vec3 way = s.place - s.axis;
      s.carried = s.weight * (axes_of(face, now) * axes_of(face, start).transpose() * way - way);
    }
  }
}

}  // namespace voile::contact
