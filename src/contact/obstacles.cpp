#include "obstacles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "distance.hpp"
#include "geometry/winding.hpp"

namespace voile::contact {

namespace {

/// x -> A x + b of a rigid motion at time t.
struct RigidMap {
  Mat3 a = Mat3::Identity();
  Vec3 b = Vec3::Zero();
  RigidMap(const std::function<Vec3(const Vec3&, double)>& motion, double t) {
    if (!motion) return;
    b = motion(Vec3::Zero(), t);
    for (int k = 0; k < 3; ++k) a.col(k) = Vec3::Unit(k) + motion(Vec3::Unit(k), t) - b;
  }
};

using Corners = std::array<Vec3, 3>;

bool pierces(const Vec3& a, const Vec3& b, const Corners& t) {
  const auto volume = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
    return (q - p).cross(r - p).dot(s - p);
  };
  if (volume(t[0], t[1], t[2], a) * volume(t[0], t[1], t[2], b) > 0.0) return false;
  const double u = volume(a, b, t[0], t[1]), v = volume(a, b, t[1], t[2]), w = volume(a, b, t[2], t[0]);
  return (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
}

/// Distance of a segment and a triangle; 0 if it pierces.
double distance(const Vec3& a, const Vec3& b, const Corners& t) {
  if (pierces(a, b, t)) return 0.0;
  double least =
      std::min(point_triangle({a, t[0], t[1], t[2]}).distance, point_triangle({b, t[0], t[1], t[2]}).distance);
  for (std::size_t k = 0; k < 3; ++k) least = std::min(least, edge_edge({a, b, t[k], t[(k + 1) % 3]}).distance);
  return least;
}

double distance(const Corners& s, const Corners& t) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k)
    least = std::min({least, distance(s[k], s[(k + 1) % 3], t), distance(t[k], t[(k + 1) % 3], s)});
  return least;
}

Box box_of(const Corners& t) {
  Box box;
  for (const Vec3& x : t) box.include(x);
  return box;
}

}  // namespace

Obstacles::Obstacles(std::vector<Obstacle> list, int first_body, Surface& surface)
    : list_(std::move(list)), first_body_(first_body) {
  for (std::size_t k = 0; k < list_.size(); ++k) {
    const Obstacle& o = list_[k];
    first_point_.push_back(no_index);
    if (o.shape == Obstacle::Shape::plane) continue;
    using Segments = std::vector<mesh::Segment>;
    first_point_.back() = append(surface, body(k), o.points, o.triangles,
                                 o.shape == Obstacle::Shape::capsule ? Segments{{0, 1}} : Segments{});
  }
}

std::optional<std::size_t> Obstacles::of_body(int body) const {
  if (body < first_body_ || body >= first_body_ + static_cast<int>(list_.size())) return std::nullopt;
  return static_cast<std::size_t>(body - first_body_);
}

bool Obstacles::any_passable() const {
  return std::any_of(list_.begin(), list_.end(), [](const Obstacle& o) { return o.passable; });
}

std::vector<Plane> Obstacles::planes() const {
  std::vector<Plane> planes;
  for (std::size_t k = 0; k < list_.size(); ++k)
    if (list_[k].shape == Obstacle::Shape::plane) planes.push_back({body(k), list_[k].normal.normalized(), 0.0});
  return planes;
}

void Obstacles::place(double time, std::vector<Vec3>& x, std::vector<Plane>& planes) const {
  std::size_t plane = 0;
  for (std::size_t k = 0; k < list_.size(); ++k) {
    const Obstacle& o = list_[k];
    if (o.shape == Obstacle::Shape::plane) {
      const RigidMap map(o.motion, time);
      Plane& p = planes[plane++];
      p.normal = (map.a * o.normal).normalized();
      p.level = p.normal.dot(map.a * o.points.front() + map.b);
      continue;
    }
    const auto at = static_cast<std::size_t>(first_point_[k]);
    if (o.frames) {
      const std::vector<Vec3> now = o.frames(time);
      std::copy(now.begin(), now.end(), x.begin() + static_cast<std::ptrdiff_t>(at));
      continue;
    }
    for (std::size_t i = 0; i < o.points.size(); ++i)
      x[at + i] = o.motion ? Vec3(o.points[i] + o.motion(o.points[i], time)) : o.points[i];
  }
}

std::optional<Vec3> Obstacles::displacement(int body, const Vec3& place, double before, double now) const {
  const std::optional<std::size_t> k = of_body(body);
  if (!k) return Vec3::Zero();
  if (list_[*k].frames) return std::nullopt;
  if (!list_[*k].motion) return Vec3::Zero();
  const RigidMap then(list_[*k].motion, before), here(list_[*k].motion, now);
  return Vec3(here.a * (then.a.transpose() * (place - then.b)) + here.b - place);
}

std::vector<Vec3> Obstacles::points(std::size_t k, const std::vector<Vec3>& x) const {
  if (first_point_[k] == no_index) return {};
  const auto first = x.begin() + first_point_[k];
  return {first, first + static_cast<std::ptrdiff_t>(list_[k].points.size())};
}

bool Obstacles::is_free(std::size_t k, const Corners& own, const std::vector<Vec3>& x, const std::vector<Plane>& planes,
                        double apart) const {
  const Obstacle& o = list_[k];
  if (o.shape == Obstacle::Shape::plane)
    return std::all_of(own.begin(), own.end(), [&](const Vec3& p) {
      return std::all_of(planes.begin(), planes.end(), [&](const Plane& plane) {
        return plane.body != body(k) || plane.normal.dot(p) - plane.level >= apart;
      });
    });
  const auto first = static_cast<std::size_t>(first_point_[k]);
  if (o.shape == Obstacle::Shape::sphere) return point_triangle({x[first], own[0], own[1], own[2]}).distance >= apart;
  if (o.shape == Obstacle::Shape::capsule) return distance(x[first], x[first + 1], own) >= apart;
  const Box box = box_of(own);
  std::vector<mesh::Triangle> triangles = o.triangles;
  for (mesh::Triangle& f : triangles)
    for (Index& p : f) p += first_point_[k];
  for (const mesh::Triangle& f : triangles) {
    const Corners other{x[f[0]], x[f[1]], x[f[2]]};
    if (box.within(box_of(other), apart) && distance(own, other) < apart) return false;
  }
  return !geometry::is_closed(triangles) || std::abs(geometry::winding_number(own[0], x, triangles)) < 0.5;
}

}  // namespace voile::contact
