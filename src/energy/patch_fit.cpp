#include "patch_fit.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "base/decompositions.hpp"

namespace voile::energy {

namespace {

/// Values of 1, x, y, x^2/2, y^2/2, xy.
Row6 monomials(const Vec2& p) {
  Row6 row;
  row << 1.0, p.x(), p.y(), 0.5 * p.x() * p.x(), 0.5 * p.y() * p.y(), p.x() * p.y();
  return row;
}

/// Undoes the scaling x = scale * xi of coefficients found in xi.
void unscale(Fit& fit, double scale) {
  const std::array<double, 6> power{1.0, scale, scale, scale * scale, scale * scale, scale * scale};
  for (int r = 0; r < 6; ++r) fit.coefficients.row(r) /= power[r];
}

/// Weights of the columns under which the condition number does not depend on the direction of the axes:
/// |H|^2 = H11^2 + H22^2 + 2 H12^2 is the norm of a Hessian.
Eigen::Matrix<double, 6, 1> invariant_columns() {
  Eigen::Matrix<double, 6, 1> w;
  w << 1.0, 1.0, 1.0, 1.0, 1.0, std::sqrt(0.5);
  return w;
}

double condition_of(const Eigen::VectorXd& singular_values) {
  const double smallest = singular_values.minCoeff();
  return smallest > 0.0 ? singular_values.maxCoeff() / smallest : std::numeric_limits<double>::infinity();
}

/// (n1^2, n2^2, 2 n1 n2): M_nn = nn.M.
Vec3 normal_moment(const Vec2& n) {
  return {n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y()};
}

/// m.k of the quadratic's curvature k as a row of its coefficients.
Row6 of_curvature(const Vec3& m) {
  Row6 row;
  row << 0.0, 0.0, 0.0, m.x(), m.y(), 2.0 * m.z();
  return row;
}

/// Changes the row of the point across side s to that of a quadratic whose normal curvature jumps there, and returns the
/// factor of the point's value: 2 D_O,nn / (D_nn + D_O,nn), with which equal stiffness leaves the row as it is and none
/// beyond makes it that of a free edge.
double balance_moments(Row6& row, const mesh::Patch& patch, int s, const Mat3& here, const Mat3& there) {
  const Side side = side_of(patch, s);
  const Vec3 nn = normal_moment(side.normal);
  const double own = nn.dot(here * nn), other = nn.dot(there * nn), sum = own + other;
  const double d = (patch.coordinates[3 + s] - side.middle).dot(side.normal) / std::sqrt(patch.area);
  const double factor = 2.0 * other / sum;
  row = factor * row + d * d / sum * of_curvature((here - there) * nn);
  return factor;
}

}  // namespace

Side side_of(const mesh::Patch& p, int s) {
  const Vec2 a = p.coordinates[(s + 1) % 3], b = p.coordinates[(s + 2) % 3];
  const double length = (b - a).norm();
  const Vec2 t = (b - a) / length;
  return {length, 0.5 * (a + b), t, {t.y(), -t.x()}};
}

double normal_stiffness(const Mat3& bending, const Vec2& n) {
  const Vec3 nn = normal_moment(n);
  return nn.dot(bending * nn);
}

Fit fit_patch(const mesh::Patch& patch, const Vec3& centroid, const Mat3& bending, const Beyond& beyond) {
  Fit fit;
  fit.complete = patch.complete();
  const double scale = std::sqrt(patch.area);
  Mat6 v;
  std::array<int, 6> column{};
  std::array<double, 6> factor{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  for (int i = 0; i < 6; ++i) {
    if (patch.points[i] == no_index) {
      v.row(i) = of_curvature(bending * normal_moment(side_of(patch, i - 3).normal) / bending.norm());
      column[i] = -1;
    } else {
      Row6 row = monomials(patch.coordinates[i] / scale);
      if (i >= 3 && beyond[i - 3]) factor[i] = balance_moments(row, patch, i - 3, bending, *beyond[i - 3]);
      v.row(i) = row;
      column[i] = static_cast<int>(fit.points.size());
      fit.points.push_back(patch.points[i]);
      fit.rest.push_back(patch.rest[i] - centroid);
    }
  }
  fit.condition = condition_of(singular_values(v * invariant_columns().asDiagonal()));
  fit.coefficients.setZero(6, static_cast<Eigen::Index>(fit.points.size()));
  if (!(fit.condition < 1e12)) return fit;
  const Mat6 inverse = v.fullPivLu().inverse();
  for (int i = 0; i < 6; ++i)
    if (column[i] >= 0) fit.coefficients.col(column[i]) = factor[i] * inverse.col(i);
  unscale(fit, scale);
  return fit;
}

Fit fit_rings(const std::vector<mesh::PatchMesh::UnfoldedPoint>& points, const Vec3& centroid, const Vec2& origin,
              double scale) {
  Fit fit;
  const auto n = static_cast<Eigen::Index>(points.size());
  if (n < 6) return fit;
  Eigen::Matrix<double, Eigen::Dynamic, 6> v(n, 6);
  Eigen::VectorXd weight(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec2 p = (points[i].coordinates - origin) / scale;
    weight[i] = 1.0 / (1.0 + p.squaredNorm());
    v.row(i) = weight[i] * monomials(p);
    fit.points.push_back(points[i].point);
    fit.rest.push_back(points[i].rest - centroid);
  }
  const SingularValues svd = singular_value_decomposition(v * invariant_columns().asDiagonal());
  fit.condition = condition_of(svd.values);
  if (!(fit.condition < 1e12)) return fit;
  fit.coefficients = invariant_columns().asDiagonal() * svd.v * svd.values.cwiseInverse().asDiagonal() *
                     svd.u.transpose() * weight.asDiagonal();
  unscale(fit, scale);
  return fit;
}

}  // namespace voile::energy
