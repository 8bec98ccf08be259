// Decompositions of small dense matrices, by Eigen, compiled once: its templates take seconds of every file that names them.
#pragma once

#include <memory>

#include "types.hpp"

namespace voile {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// m = vectors diag(values) vectors^T, values in growing order.
struct Spectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
/// Of a symmetric matrix, n x n; its lower triangle is read.
[[nodiscard]] Spectrum spectrum(const Eigen::MatrixXd& m);
[[nodiscard]] Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& m);

/// m = u diag(values) v^T with values in falling order: m is r x c, u r x min(r, c), v c x c (columns beyond min(r, c) span
/// what m takes to zero).
struct SingularValues {
  Eigen::MatrixXd u;
  Eigen::VectorXd values;
  Eigen::MatrixXd v;

  /// How many are larger than `threshold` times the largest; at least that of a matrix of zeros, which is 0.
  [[nodiscard]] Eigen::Index rank(double threshold) const;
};
[[nodiscard]] SingularValues singular_value_decomposition(const Eigen::MatrixXd& m);
/// Without vectors.
[[nodiscard]] Eigen::VectorXd singular_values(const Eigen::MatrixXd& m);

[[nodiscard]] Eigen::MatrixXd inverse(const Eigen::MatrixXd& m);
/// m^-1 b of a positive definite m.
[[nodiscard]] Eigen::MatrixXd solve_positive(const Eigen::MatrixXd& m, const Eigen::MatrixXd& b);

/// Solves min |m x - b|, by a complete orthogonal decomposition; of several minimisers the shortest.
class LeastSquares {
 public:
  /// m is r x c. Pivots below `threshold` times the largest count as zero; by default those below round-off.
  explicit LeastSquares(const Eigen::MatrixXd& m, double threshold = 0.0);
  ~LeastSquares();
  LeastSquares(LeastSquares&&) noexcept;
  LeastSquares& operator=(LeastSquares&&) noexcept;

  [[nodiscard]] Eigen::Index rank() const;
  /// b is r x k; the result is c x k.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  struct Decomposition;
  std::unique_ptr<Decomposition> decomposition_;
};

/// The shortest turn that brings one direction to another; both not zero. Of opposite ones any half turn.
[[nodiscard]] Mat3 rotation_between(const Vec3& from, const Vec3& to);

}  // namespace voile
