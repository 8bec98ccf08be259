#include "decompositions.hpp"

#include <Eigen/Dense>

namespace voile {

Spectrum spectrum(const Eigen::MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(m);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::Index SingularValues::rank(double threshold) const {
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > threshold * values[0]) ++rank;
  return rank;
}

SingularValues singular_value_decomposition(const Eigen::MatrixXd& m) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(m, Eigen::ComputeThinU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& m) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(m).singularValues();
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& m) {
  return m.inverse();
}

Eigen::MatrixXd solve_positive(const Eigen::MatrixXd& m, const Eigen::MatrixXd& b) {
  return Eigen::LLT<Eigen::MatrixXd>(m).solve(b);
}

struct LeastSquares::Decomposition {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> of;
};

LeastSquares::LeastSquares(const Eigen::MatrixXd& m, double threshold)
    : decomposition_(std::make_unique<Decomposition>()) {
  if (threshold > 0.0) decomposition_->of.setThreshold(threshold);
  decomposition_->of.compute(m);
}

LeastSquares::~LeastSquares() = default;
LeastSquares::LeastSquares(LeastSquares&&) noexcept = default;
LeastSquares& LeastSquares::operator=(LeastSquares&&) noexcept = default;

Eigen::Index LeastSquares::rank() const {
  return decomposition_->of.rank();
}

Eigen::MatrixXd LeastSquares::solve(const Eigen::MatrixXd& b) const {
  return decomposition_->of.solve(b);
}

Mat3 rotation_between(const Vec3& from, const Vec3& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace voile
