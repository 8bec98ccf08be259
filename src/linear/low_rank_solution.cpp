#include "low_rank_solution.hpp"

#include <cmath>

#include "base/decompositions.hpp"

namespace voile::linear {

void LowRankSolution::prepare(PC factor, const system::LowRankChange& change) {
  if (ready_) return;
  const auto n = static_cast<Eigen::Index>(change.columns.size());
  z_.resize(change.columns.size());
  g_.resize(n, n);
  for (std::size_t k = 0; k < z_.size(); ++k) {
    if (!z_[k]) VOILE_PETSC(VecDuplicate(change.columns[k], z_[k].out()));
    VOILE_PETSC(PCApply(factor, change.columns[k], z_[k]));
    g_.col(static_cast<Eigen::Index>(k)) = change.products(z_[k]);
  }
  g_ = 0.5 * (g_ + g_.transpose()).eval();
  // Columns have units of their own, and weights span many orders: in those of G nothing is lost beside something larger.
  unit_ = g_.diagonal().cwiseAbs().cwiseSqrt();
  for (double& unit : unit_)
    if (!(unit > 0.0)) unit = 1.0;
  for (Eigen::Index r = 0; r < n; ++r)
    for (Eigen::Index c = 0; c < n; ++c) g_(r, c) /= unit_[r] * unit_[c];
  ready_ = true;
}

Eigen::MatrixXd LowRankSolution::weights_of(const system::LowRankChange& change) const {
  return unit_.asDiagonal() * change.weights * unit_.asDiagonal();
}

void LowRankSolution::correct(const system::LowRankChange& change, Vec x) const {
  const Eigen::Index n = g_.rows();
  const Eigen::MatrixXd weights = weights_of(change);
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(n, n) + weights * g_;
  Eigen::VectorXd wanted = weights * change.products(x).cwiseQuotient(unit_);
  for (Eigen::Index r = 0; r < n; ++r) {
    const double largest = system.row(r).cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) continue;
    system.row(r) /= largest;
    wanted[r] /= largest;
  }
  const Eigen::VectorXd factors = LeastSquares(system).solve(wanted).cwiseQuotient(unit_);
  for (std::size_t k = 0; k < z_.size(); ++k) VOILE_PETSC(VecAXPY(x, -factors[static_cast<Eigen::Index>(k)], z_[k]));
}

long LowRankSolution::more_negative(const system::LowRankChange& change) const {
  const auto negative = [](const Eigen::MatrixXd& m) { return (eigenvalues(m).array() < 0.0).count(); };
  // Alike in size before it is inverted: those of the rim are small beside that of the gas.
  const Eigen::MatrixXd weights = weights_of(change);
  Eigen::VectorXd size = weights.cwiseAbs().rowwise().maxCoeff().cwiseSqrt();
  for (double& each : size)
    if (!(each > 0.0)) each = 1.0;
  const Eigen::VectorXd back = size.cwiseInverse();
  const Eigen::MatrixXd alike = back.asDiagonal() * weights * back.asDiagonal();
  const Eigen::MatrixXd inverse = back.asDiagonal() *
                                  LeastSquares(alike).solve(Eigen::MatrixXd::Identity(alike.rows(), alike.cols())) *
                                  back.asDiagonal();
  return static_cast<long>(negative(-inverse - g_)) - static_cast<long>(negative(-inverse));
}

}  // namespace voile::linear
