#include "barrier.hpp"

#include <Eigen/Geometry>

namespace voile::contact {

double cross_squared(const std::array<Vec3, 4>& x, Vec12* gradient, Mat12* hessian) {
  const Vec3 u = x[1] - x[0], v = x[3] - x[2];
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  constexpr double sign[4] = {-1.0, 1.0, -1.0, 1.0};
  if (gradient) {
    const Vec3 du = 2.0 * (vv * u - uv * v), dv = 2.0 * (uu * v - uv * u);
    for (int i = 0; i < 4; ++i) gradient->segment<3>(3 * i) = sign[i] * (i < 2 ? du : dv);
  }
  if (hessian) {
    const Mat3 one = Mat3::Identity();
    const Mat3 duu = 2.0 * (vv * one - v * v.transpose()), dvv = 2.0 * (uu * one - u * u.transpose());
    const Mat3 duv = 2.0 * (2.0 * u * v.transpose() - uv * one - v * u.transpose());
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const double s = sign[i] * sign[j];
        if (i < 2 && j < 2)
          hessian->block<3, 3>(3 * i, 3 * j) = s * duu;
        else if (i >= 2 && j >= 2)
          hessian->block<3, 3>(3 * i, 3 * j) = s * dvv;
        else if (i < 2)
          hessian->block<3, 3>(3 * i, 3 * j) = s * duv;
        else
          hessian->block<3, 3>(3 * i, 3 * j) = s * duv.transpose();
      }
  }
  return u.cross(v).squaredNorm();
}

}  // namespace voile::contact
