// Where panels begin.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "voile/base/error.hpp"
#include "voile/pattern/outline.hpp"
#include "voile/pattern/seams.hpp"

namespace voile::pattern {

namespace {

/// Sine of the angle between a plane and the axis up to which they count as parallel.
constexpr double parallel = 1e-6;

/// The plane of a panel as a cylinder's axis sees it.
struct Plane {
  Vec3 normal, along;  ///< away from the axis; the way round, axis cross normal
  double distance;     ///< from the axis [m], >= 0
};

Plane plane_of(const Panel& p, const Wrap& w) {
  Vec3 normal = p.turn * p.piece.rotation.col(2);
  const Vec3 foot = p.turn * p.piece.translation + p.shift - w.point;
  if (normal.dot(foot) < 0.0) normal = -normal;
  return {normal, w.axis.cross(normal), normal.dot(foot)};
}

}  // namespace

Vec3 Panel::place(const Vec2& x) const {
  const Vec3 flat = turn * (piece.rotation * Vec3(x[0], x[1], 0.0) + piece.translation) + shift;
  if (!wrap) return flat;
  const Plane plane = plane_of(*this, *wrap);
  const double radius = wrap->radius > 0.0 ? wrap->radius : plane.distance;
  const Vec3 d = flat - wrap->point;
  const double angle = d.dot(plane.along) / radius;
  return wrap->point + d.dot(wrap->axis) * wrap->axis +
         radius * (std::cos(angle) * plane.normal + std::sin(angle) * plane.along);
}

void Panel::check_wrap() const {
  if (!wrap) return;
  const std::string where = fmt::format("{}: piece '{}'", file, piece.name);
  const Plane plane = plane_of(*this, *wrap);
  const double tilt = plane.normal.dot(wrap->axis);
  if (std::abs(tilt) > parallel)
    throw UserError(
        fmt::format("{}: wrap_axis: its plane leans by {:.3g} degrees against the axis; turn the piece or the "
                    "axis so that they are parallel",
                    where, std::asin(std::abs(tilt)) * 180.0 / std::numbers::pi));
  const double radius = wrap->radius > 0.0 ? wrap->radius : plane.distance;
  const Extent e = extent_of(piece);
  double low = 0.0, high = 0.0;
  bool first = true;
  for (const double x : {e.low[0], e.high[0]})
    for (const double y : {e.low[1], e.high[1]}) {
      const Vec3 flat = turn * (piece.rotation * Vec3(x, y, 0.0) + piece.translation) + shift;
      const double s = (flat - wrap->point).dot(plane.along);
      low = first ? s : std::min(low, s);
      high = first ? s : std::max(high, s);
      first = false;
    }
  if (!(radius > 1e-6))
    throw UserError(
        fmt::format("{}: wrap_axis: the axis lies in the plane of the piece; move the piece away from it, or "
                    "give wrap_radius",
                    where));
  if (high - low >= 2.0 * std::numbers::pi * radius)
    throw UserError(
        fmt::format("{}: wrap_radius: the piece is {:.4g} m wide and would overlap itself on a cylinder of "
                    "radius {:.4g} m; make the radius larger",
                    where, high - low, radius));
}

}  // namespace voile::pattern
