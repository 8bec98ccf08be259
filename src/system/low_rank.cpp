#include "low_rank.hpp"

#include <utility>

namespace voile::system {

void LowRankChange::clear() {
  columns.clear();
  weights.resize(0, 0);
}

void LowRankChange::add(petsc::VecHandle column, double weight) {
  const Eigen::Index n = weights.rows();
  columns.push_back(std::move(column));
  weights.conservativeResize(n + 1, n + 1);
  weights.row(n).setZero();
  weights.col(n).setZero();
  weights(n, n) = weight;
}

Eigen::VectorXd LowRankChange::products(Vec x) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k)
    VOILE_PETSC(VecDot(columns[k], x, &values[static_cast<Eigen::Index>(k)]));
  return values;
}

void LowRankChange::multiply_add(Vec x, Vec y) const {
  if (empty()) return;
  const Eigen::VectorXd factors = weights * products(x);
  for (std::size_t k = 0; k < columns.size(); ++k)
    VOILE_PETSC(VecAXPY(y, factors[static_cast<Eigen::Index>(k)], columns[k]));
}

}  // namespace voile::system
