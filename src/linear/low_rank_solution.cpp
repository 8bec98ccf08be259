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
  ready_ = true;
}

void LowRankSolution::correct(const system::LowRankChange& change, Vec x) const {
  const Eigen::Index n = g_.rows();
  const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(n, n) + change.weights * g_;
  const Eigen::VectorXd factors = LeastSquares(system).solve(change.weights * change.products(x));
  for (std::size_t k = 0; k < z_.size(); ++k) VOILE_PETSC(VecAXPY(x, -factors[static_cast<Eigen::Index>(k)], z_[k]));
}

long LowRankSolution::more_negative(const system::LowRankChange& change) const {
  const auto negative = [](const Eigen::MatrixXd& m) { return (eigenvalues(m).array() < 0.0).count(); };
  const Eigen::MatrixXd inverse =
      LeastSquares(change.weights).solve(Eigen::MatrixXd::Identity(change.weights.rows(), change.weights.cols()));
  return static_cast<long>(negative(-inverse - g_)) - static_cast<long>(negative(-inverse));
}

}  // namespace voile::linear
