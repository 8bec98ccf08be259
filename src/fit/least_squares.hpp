// Least squares by Levenberg and Marquardt, with what the data say of their unknowns.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace voile::fit {

/// Residuals over their standard deviations.
using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd& unknowns)>;

struct LeastSquares {
  Eigen::VectorXd unknowns, residuals;
  Eigen::MatrixXd jacobian;
  Eigen::MatrixXd gain;  ///< change of the unknowns by the data, in their standard deviations
  Eigen::MatrixXd null;  ///< combinations that the data do not see, a column each

  /// Of residuals with the standard deviation 1; empty directions are left out.
  [[nodiscard]] Eigen::MatrixXd covariance() const { return gain * gain.transpose(); }
  /// Sum of squares over the number of data beyond that of unknowns; 1 without any.
  [[nodiscard]] double misfit() const;
  /// For each unknown: mean square of the residuals of the data that determine it, over what their uncertainties let expect; weighed
  /// by how much each of them does. 1 where nothing is measured twice.
  [[nodiscard]] Eigen::VectorXd contradictions() const;
};

[[nodiscard]] LeastSquares least_squares(const Residuals& residuals, const Eigen::VectorXd& start);

}  // namespace voile::fit
