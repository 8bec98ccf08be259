#include "camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

/// Slope of the longer half side of a picture: a lens of 50 mm or so.
constexpr double half_angle_slope = 0.27;

/// Two horizontal unit vectors, to the right and to the back of who looks from the front.
std::pair<Vec3, Vec3> horizontal(const Vec3& up) {
  const Vec3 reference = std::abs(up.z()) > 0.9   ? Vec3(Vec3::UnitX())
                         : std::abs(up.y()) > 0.9 ? Vec3(Vec3::UnitX())
                                                  : Vec3(Vec3::UnitY());
  const Vec3 right = (reference - reference.dot(up) * up).normalized();
  return {right, up.cross(right)};
}

Vec3 direction(const Vec3& up, double azimuth, double elevation) {
  const auto [right, behind] = horizontal(up);
  const double a = azimuth * std::numbers::pi / 180.0, e = elevation * std::numbers::pi / 180.0;
  return std::cos(e) * (std::cos(a) * right + std::sin(a) * behind) + std::sin(e) * up;
}

/// Along one axis: where the eye is (first) and how far back it must be at least (second). `side`: the points' coordinate,
/// slopes of both sides of the frame.
struct Reach {
  double low_end = -std::numeric_limits<double>::infinity(), high_end = low_end;
  void add(double side, double back, double low_slope, double high_slope) {
    high_end = std::max(high_end, side + high_slope * back);
    low_end = std::max(low_end, -side + low_slope * back);
  }
};

}  // namespace

Vec3 Camera::project(const Vec3& point) const {
  const Vec3 d = point - eye;
  const double depth = -d.dot(back);
  return {0.5 + 0.5 * d.dot(right) / (depth * tan_x), 0.5 - 0.5 * d.dot(up) / (depth * tan_y), depth};
}

Vec3 Camera::ray(double column, double row) const {
  return (2.0 * column - 1.0) * tan_x * right + (1.0 - 2.0 * row) * tan_y * up - back;
}

View named_view(const std::string& name, const Vec3& up) {
  struct Named {
    const char* name;
    double azimuth, elevation;
  };
  static constexpr std::array views{Named{"three-quarter", -62, 24}, Named{"front", -90, 0}, Named{"back", 90, 0},
                                    Named{"left", 180, 0},           Named{"right", 0, 0},   Named{"top", -90, 90},
                                    Named{"bottom", -90, -90}};
  std::vector<std::string> names;
  for (const Named& v : views) {
    if (name == v.name) return {name, direction(up, v.azimuth, v.elevation), {}, {}};
    names.emplace_back(v.name);
  }
  double azimuth = 0.0, elevation = 0.0;
  char more = '\0';
  if (std::sscanf(name.c_str(), "%lf,%lf%c", &azimuth, &elevation, &more) == 2 && std::abs(elevation) <= 90.0)
    return {name, direction(up, azimuth, elevation), {}, {}};
  throw UserError(
      fmt::format("there is no view '{}': it is AZIMUTH,ELEVATION in degrees or one of {}", name, join(names, ", ")));
}

Camera fit_camera(const View& view, const Vec3& up, const std::vector<Vec3>& points, double aspect,
                  const Frame& frame) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec3 middle = points.empty() ? Vec3(Vec3::Zero()) : Vec3(0.5 * (low + high));
  const Vec3 target = view.target.value_or(middle);
  Camera c;
  if (view.eye && (*view.eye - target).norm() < 1e-12 * (1.0 + target.norm()))
    throw UserError("--eye: the camera is at the place of its target; move it, or give another --target");
  c.back = (view.eye ? Vec3(*view.eye - target) : view.back).normalized();
  Vec3 right = up.cross(c.back);
  if (right.norm() < 1e-6) right = horizontal(up).first;
  c.right = right.normalized();
  c.up = c.back.cross(c.right);
  c.tan_x = aspect >= 1.0 ? half_angle_slope : half_angle_slope * aspect;
  c.tan_y = c.tan_x / aspect;
  if (view.eye) {
    c.eye = *view.eye;
    return c;
  }
  // Slopes of the sides of the frame, seen from the axis of the camera.
  const double l = (1.0 - 2.0 * frame.left) * c.tan_x, r = (2.0 * frame.right - 1.0) * c.tan_x;
  const double t = (1.0 - 2.0 * frame.top) * c.tan_y, b = (2.0 * frame.bottom - 1.0) * c.tan_y;
  Reach x, y;
  double nearest = 0.0;
  for (const Vec3& p : points) {
    const Vec3 d = p - target;
    x.add(d.dot(c.right), d.dot(c.back), l, r);
    y.add(d.dot(c.up), d.dot(c.back), b, t);
    nearest = std::max(nearest, d.dot(c.back));
  }
  double distance = std::max((x.high_end + x.low_end) / (l + r), (y.high_end + y.low_end) / (b + t));
  if (!(distance > nearest)) distance = nearest + 1.0;
  // In the middle of what is left over.
  const double across = 0.5 * ((x.high_end - r * distance) + (l * distance - x.low_end));
  const double along = 0.5 * ((y.high_end - t * distance) + (b * distance - y.low_end));
  c.eye = target + across * c.right + along * c.up + distance * c.back;
  if (points.empty()) c.eye = target + c.back;
  return c;
}

}  // namespace voile::picture
