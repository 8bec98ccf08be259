// Where panels begin.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "outline.hpp"
#include "seams.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Sine of the angle between a plane and the axis up to which they count as parallel.
constexpr double parallel = 1e-6;
/// Of a cylinder or cone that something is bent onto [m].
constexpr double least_radius = 1e-6;

/// The plane of a panel as the axis of its wrap sees it.
struct Plane {
  Vec3 normal, along;  ///< away from the axis; the way round, axis cross normal
  double distance;     ///< from the axis [m], >= 0
};

Plane plane_of(const Panel& p, const Wrap& w) {
  Vec3 normal = p.turn * p.piece.rotation.col(2);
  const Vec3 foot = p.turn * p.piece.translation + p.shift - w.point;
  const bool contains_axis = std::abs(normal.dot(foot)) < least_radius;  // the right side is outside then
  if (contains_axis ? p.piece.turned : normal.dot(foot) < 0.0) normal = -normal;
  return {normal, w.axis.cross(normal), normal.dot(foot)};
}

/// `outwards` is across the surface, which leans on a cone.
double radius_of(const Panel& p, const Plane& plane) {
  const double inner = p.wrap->radius > 0.0 ? p.wrap->radius : plane.distance;
  return inner + (inner > least_radius ? p.outwards / std::cos(p.wrap->half_angle) : 0.0);
}

/// A cone, unrolled: polar coordinates about its apex in the plane of a panel. Angles shrink by the sine of the half angle
/// where the plane unrolls it.
struct Cone {
  double sense;      ///< +1 if it widens along the axis, else -1
  double sine;       ///< of the half angle, > 0
  double apex;       ///< height above the wrap's point where it lies on the axis [m]
  double to_radius;  ///< way along the surface from the apex to the wrap's radius [m]

  Cone(double radius, double half_angle)
      : sense(half_angle > 0.0 ? 1.0 : -1.0),
        sine(std::sin(std::abs(half_angle))),
        apex(-radius / std::tan(half_angle)),
        to_radius(radius / sine) {}
  /// Along the line nearest to the axis, away from the apex, and across it, of a point at (across, height) of the plane.
  [[nodiscard]] Vec2 from_apex(double across, double height) const { return {to_radius + sense * height, across}; }
};

bool is_cone(const Wrap& w) {
  return std::abs(w.half_angle) > 1e-9;
}

/// Across and height: round the axis and along it, from the wrap's point. [m]
Vec2 in_plane(const Panel& p, const Plane& plane, const Vec3& flat) {
  const Vec3 d = flat - p.wrap->point;
  return {d.dot(plane.along), d.dot(p.wrap->axis)};
}

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

/// Distance of the origin from a segment.
double from_origin(const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  return (a + std::clamp(-a.dot(d) / d.squaredNorm(), 0.0, 1.0) * d).norm();
}

/// `outline`: across and height of its points.
void check_cylinder(const std::string& where, const std::vector<Vec2>& outline, double radius) {
  const auto [low, high] =
      std::minmax_element(outline.begin(), outline.end(), [](const Vec2& a, const Vec2& b) { return a[0] < b[0]; });
  const double width = (*high)[0] - (*low)[0];
  if (width >= 2.0 * std::numbers::pi * radius)
    throw UserError(
        fmt::format("{}: wrap_radius: the piece is {:.4g} m wide and would overlap itself on a cylinder of "
                    "radius {:.4g} m; make the radius larger",
                    where, width, radius));
}

void check_cone(const std::string& where, const std::vector<Vec2>& outline, const Wrap& wrap, double radius) {
  const Cone cone(radius, wrap.half_angle);
  const auto from_apex = [&](std::size_t k) {
    const Vec2& x = outline[k % outline.size()];
    return cone.from_apex(x[0], x[1]);
  };
  // What goes round the apex, or lies on both sides of the line behind it, crosses that line.
  bool passes =
      std::all_of(outline.begin(), outline.end(), [&](const Vec2& x) { return cone.from_apex(x[0], x[1])[0] <= 0.0; });
  double low = std::numbers::pi, high = -std::numbers::pi;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vec2 a = from_apex(k), b = from_apex(k + 1);
    const double angle = std::atan2(a[1], a[0]), step = std::atan2(b[1], b[0]) - angle;
    passes = passes || from_origin(a, b) * cone.sine <= least_radius || std::abs(step) > std::numbers::pi;
    low = std::min(low, angle);
    high = std::max(high, angle);
  }
  if (passes) {
    const Vec3 apex = wrap.point + cone.apex * wrap.axis;
    throw UserError(
        fmt::format("{}: wrap_axis: it would pass the apex of the cone at ({:.4g}, {:.4g}, {:.4g}) m; move the piece "
                    "away from it, or make the radius larger or the half angle of {:.4g} degrees smaller",
                    where, apex[0], apex[1], apex[2], degrees(std::abs(wrap.half_angle))));
  }
  if (high - low >= 2.0 * std::numbers::pi * cone.sine)
    throw UserError(fmt::format(
        "{}: wrap_axis: seen from the apex the piece is {:.4g} degrees wide and would overlap itself on a cone, which "
        "unrolls to {:.4g} degrees; make its radius larger, or the piece narrower",
        where, degrees(high - low), 360.0 * cone.sine));
}

}  // namespace

Vec3 Panel::flat_place(const Vec2& x) const {
  return turn * (piece.bent ? piece.bent->at(x) : piece.rotation * Vec3(x[0], x[1], 0.0) + piece.translation) + shift;
}

Vec3 Panel::place(const Vec2& x) const {
  Vec3 flat = flat_place(x);
  if (!wrap) return flat + (piece.turned ? -outwards : outwards) * turn * piece.rotation.col(2);
  const Plane plane = plane_of(*this, *wrap);
  double radius = radius_of(*this, plane);
  const Vec2 at = in_plane(*this, plane, flat);
  double angle = at[0] / radius, height = at[1];
  if (is_cone(*wrap)) {
    const Cone cone(radius, wrap->half_angle);
    const Vec2 d = cone.from_apex(at[0], at[1]);
    const double way = d.norm();
    angle = std::atan2(d[1], d[0]) / cone.sine;
    radius = way * cone.sine;
    height = cone.apex + cone.sense * way * std::cos(wrap->half_angle);
  }
  return wrap->point + height * wrap->axis + radius * (std::cos(angle) * plane.normal + std::sin(angle) * plane.along);
}

void Panel::check_wrap() const {
  if (!wrap) return;
  const std::string where = fmt::format("{}: piece '{}'", file, piece.name);
  if (piece.bent)
    throw UserError(fmt::format("{}: wrap_axis: it is bent already where the file has it; remove the key", where));
  const Plane plane = plane_of(*this, *wrap);
  const double tilt = plane.normal.dot(wrap->axis);
  if (std::abs(tilt) > parallel)
    throw UserError(
        fmt::format("{}: wrap_axis: its plane leans by {:.3g} degrees against the axis; turn the piece or the "
                    "axis so that they are parallel",
                    where, degrees(std::asin(std::min(std::abs(tilt), 1.0)))));
  const double radius = radius_of(*this, plane);
  if (!(radius > least_radius))
    throw UserError(
        fmt::format("{}: wrap_axis: the axis lies in the plane of the piece; move the piece away from it, or "
                    "give wrap_radius",
                    where));
  std::vector<Vec2> outline;
  const Piece::Loop loop = piece.loops()[piece.outline()];
  for (std::size_t k = loop.begin; k < loop.end; ++k)
    for (const Vec2& x : polygon_of({piece.edges[k].curve})) outline.push_back(in_plane(*this, plane, flat_place(x)));
  if (is_cone(*wrap))
    check_cone(where, outline, *wrap, radius);
  else
    check_cylinder(where, outline, radius);
}

}  // namespace voile::pattern
