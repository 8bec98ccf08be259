#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "base/decompositions.hpp"

namespace test_decompositions {

using namespace voile;
using Eigen::MatrixXd;

namespace {

/// Of rank two: the third column is the sum of the others.
MatrixXd deficient() {
  MatrixXd m(4, 3);
  m << 1, 2, 3, 4, 5, 9, 7, -8, -1, 2, 1, 3;
  return m;
}

}  // namespace

TEST_CASE("a spectrum gives its matrix back, in growing order") {
  MatrixXd m(3, 3);
  m << 4, 1, -2, 1, 3, 0.5, -2, 0.5, -1;
  const Spectrum s = spectrum(m);
  CHECK((s.vectors * s.values.asDiagonal() * s.vectors.transpose() - m).norm() < 1e-13);
  CHECK(s.values[0] < s.values[1]);
  CHECK(s.values[1] < s.values[2]);
  CHECK((eigenvalues(m) - s.values).norm() < 1e-13);
  Mat6 six = Mat6::Identity();
  six.topLeftCorner<3, 3>() = m;
  CHECK((eigenvalues(six) - Vec6(eigenvalues(MatrixXd(six)))).norm() < 1e-13);
}

TEST_CASE("singular values: tall, wide and deficient matrices come back, v spans what is lost") {
  for (const MatrixXd& m : {deficient(), MatrixXd(deficient().transpose()), MatrixXd(deficient().topRows(1))}) {
    const SingularValues s = singular_value_decomposition(m);
    const Eigen::Index n = s.values.size(), rank = s.rank(1e-12);
    CHECK((s.u * s.values.asDiagonal() * s.v.leftCols(n).transpose() - m).norm() < 1e-13);
    CHECK(s.v.cols() == m.cols());
    CHECK((m * s.v.rightCols(m.cols() - rank)).norm() < 1e-13);
    CHECK(rank == std::min<Eigen::Index>(2, m.rows()));
    CHECK((singular_values(m) - s.values).norm() < 1e-13);
  }
  CHECK(singular_value_decomposition(MatrixXd::Zero(2, 3)).rank(1e-8) == 0);
}

TEST_CASE("least squares: the shortest of the best") {
  const MatrixXd m = deficient(), b = MatrixXd::Identity(4, 2);
  const LeastSquares fit(m, 1e-12);
  CHECK(fit.rank() == 2);
  const MatrixXd x = fit.solve(b);
  CHECK((m.transpose() * (m * x - b)).norm() < 1e-12);
  CHECK((x.transpose() * Vec3(1, 1, -1)).norm() < 1e-13);  // orthogonal to what m takes to zero
  CHECK(LeastSquares(m.leftCols(2)).rank() == 2);
}

TEST_CASE("the shortest turn from one direction to another") {
  const Vec3 from(0.3, -2.0, 1.0), to(1.0, 0.2, -0.5);
  const Mat3 r = rotation_between(from, to);
  CHECK((r * from.normalized() - to.normalized()).norm() < 1e-14);
  CHECK((r * r.transpose() - Mat3::Identity()).norm() < 1e-14);
  CHECK((r * from.cross(to) - from.cross(to)).norm() < 1e-14);  // about what is normal to both
  CHECK((rotation_between(from, -from) * from + from).norm() < 1e-7);
}

}  // namespace test_decompositions
