#include "placement.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace voile::formats {

namespace {

/// Right-handed turn about a global axis.
Mat3 turn(int axis, double degrees) {
  const double quarters = degrees / 90.0;
  double c = std::cos(degrees * (std::numbers::pi / 180.0)), s = std::sin(degrees * (std::numbers::pi / 180.0));
  if (quarters == std::round(quarters)) {  // a sheet turned upright shall lie in its plane exactly
    c = std::round(c);
    s = std::round(s);
  }
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  Mat3 r = Mat3::Identity();
  r(i, i) = r(j, j) = c;
  r(j, i) = s;
  r(i, j) = -s;
  return r;
}

}  // namespace

bool Placement::is_identity() const {
  return up_axis == UpAxis::z && rotate.isZero(0.0) && translate.isZero(0.0);
}

Mat3 Placement::rotation() const {
  const Mat3 up = up_axis == UpAxis::y ? turn(0, 90.0) : Mat3(Mat3::Identity());
  return turn(2, rotate[2]) * turn(1, rotate[1]) * turn(0, rotate[0]) * up;
}

void Placement::apply(std::vector<Vec3>& points) const {
  if (is_identity()) return;
  const Mat3 r = rotation();
  for (Vec3& x : points) x = r * x + translate;
}

}  // namespace voile::formats
