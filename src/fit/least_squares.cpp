#include "least_squares.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <unsupported/Eigen/LevenbergMarquardt>
#include <unsupported/Eigen/NumericalDiff>

namespace voile::fit {

namespace {

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

LeastSquares least_squares(const Residuals& function, const Eigen::VectorXd& start) {
  const Eigen::Index count = function(start).size();
  Eigen::NumericalDiff<Functor, Eigen::Central> functor(Functor(function, start.size(), count));
  Eigen::LevenbergMarquardt<decltype(functor)> solver(functor);
  solver.setXtol(1e-12);
  solver.setFtol(1e-12);
  LeastSquares out;
  out.unknowns = start;
  if (start.size() > 0) solver.minimize(out.unknowns);
  out.residuals = function(out.unknowns);
  Eigen::MatrixXd all(functor.values(), start.size());
  functor.df(out.unknowns, all);
  out.jacobian = all.topRows(count);
  if (!out.jacobian.allFinite() || !out.unknowns.allFinite()) {  // nothing is known
    out.null = Eigen::MatrixXd::Identity(start.size(), start.size());
    out.gain = Eigen::MatrixXd::Zero(start.size(), count);
    return out;
  }
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
