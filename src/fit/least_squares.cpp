#include "least_squares.hpp"

#include <algorithm>
#include <unsupported/Eigen/LevenbergMarquardt>
#include <unsupported/Eigen/NumericalDiff>

#include "base/decompositions.hpp"

namespace voile::fit {

namespace {

constexpr double least_freedom = 1e-6;   // below which a datum alone determines what it measures
constexpr double rank_tolerance = 1e-6;  // of the largest singular value; differences are good to 1e-9

/// The residuals, and empty ones so that there are as many as unknowns, which the solver wants.
struct Functor : Eigen::DenseFunctor<double> {
  const Residuals* function;

  Functor(const Residuals& f, Eigen::Index unknowns, Eigen::Index count)
      : Eigen::DenseFunctor<double>(static_cast<int>(unknowns), static_cast<int>(std::max(count, unknowns))),
        function(&f) {}
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& r) const {
    r.setZero();
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

Eigen::VectorXd LeastSquares::contradictions() const {
  Eigen::VectorXd squares = Eigen::VectorXd::Ones(residuals.size());
  for (Eigen::Index j = 0; j < residuals.size(); ++j)
    if (const double free = 1.0 - jacobian.row(j).dot(gain.col(j)); free > least_freedom)
      squares[j] = residuals[j] * residuals[j] / free;
  const Eigen::MatrixXd weights = gain.cwiseAbs2();
  return (weights * squares).cwiseQuotient(weights.rowwise().sum().cwiseMax(1e-300));
}

LeastSquares least_squares(const Residuals& function, const Eigen::VectorXd& start) {
  const Eigen::Index count = function(start).size();
  Eigen::NumericalDiff<Functor, Eigen::Central> functor(Functor(function, start.size(), count));
  Eigen::LevenbergMarquardt<decltype(functor)> solver(functor);
  solver.setXtol(1e-12);
  solver.setFtol(1e-12);
  LeastSquares out;
  out.unknowns = start;
  if (start.size() == 0) {
    out.residuals = function(start);
    out.jacobian = Eigen::MatrixXd(count, 0);
    out.null = Eigen::MatrixXd(0, 0);
    out.gain = Eigen::MatrixXd(0, count);
    return out;
  }
  solver.minimize(out.unknowns);
  out.residuals = function(out.unknowns);
  Eigen::MatrixXd all(functor.values(), start.size());
  functor.df(out.unknowns, all);
  out.jacobian = all.topRows(count);
  if (!out.jacobian.allFinite() || !out.unknowns.allFinite()) {  // nothing is known
    out.null = Eigen::MatrixXd::Identity(start.size(), start.size());
    out.gain = Eigen::MatrixXd::Zero(start.size(), count);
    return out;
  }
  const SingularValues svd = singular_value_decomposition(out.jacobian);
  const Eigen::Index rank = svd.rank(rank_tolerance);
  out.null = svd.v.rightCols(start.size() - rank);
  out.gain =
      svd.v.leftCols(rank) * svd.values.head(rank).cwiseInverse().asDiagonal() * svd.u.leftCols(rank).transpose();
  return out;
}

}  // namespace voile::fit
