#include "least_squares.hpp"

#include <Eigen/SVD>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

namespace voile::fit {

namespace {

constexpr double rank_tolerance = 1e-6;  // of the largest singular value; differences are good to 1e-9

/// What Eigen's solver wants.
struct Functor {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Residuals* function;
  int input_count, value_count;

  [[nodiscard]] int inputs() const { return input_count; }
  [[nodiscard]] int values() const { return value_count; }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& r) const {
    r.head(r.size()).setZero();
    const Eigen::VectorXd found = (*function)(x);
    r.head(found.size()) = found;
    return 0;
  }
};

}  // namespace

double LeastSquares::misfit() const {
  const Eigen::Index beyond = residuals.size() - (unknowns.size() - null.cols());
  return beyond > 0 ? residuals.squaredNorm() / static_cast<double>(beyond) : 1.0;
}

LeastSquares least_squares(const Residuals& function, const Eigen::VectorXd& start) {
  const Eigen::Index count = function(start).size();
  // The solver wants as many residuals as unknowns: empty ones do no harm.
  const Functor plain{&function, static_cast<int>(start.size()),
                      static_cast<int>(std::max<Eigen::Index>(count, start.size()))};
  Eigen::NumericalDiff<Functor, Eigen::Central> functor(plain);
  Eigen::LevenbergMarquardt<decltype(functor)> solver(functor);
  solver.parameters.xtol = solver.parameters.ftol = 1e-12;
  LeastSquares out;
  out.unknowns = start;
  if (start.size() > 0) solver.minimize(out.unknowns);
  out.residuals = function(out.unknowns);
  Eigen::MatrixXd all(plain.value_count, start.size());
  functor.df(out.unknowns, all);
  out.jacobian = all.topRows(count);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(out.jacobian, Eigen::ComputeThinU | Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > rank_tolerance * svd.singularValues()[0])
    ++rank;
  const Eigen::MatrixXd seen = svd.matrixV().leftCols(rank);
  out.null = svd.matrixV().rightCols(start.size() - rank);
  out.gain =
      seen * svd.singularValues().head(rank).cwiseInverse().asDiagonal() * svd.matrixU().leftCols(rank).transpose();
  return out;
}

}  // namespace voile::fit
