#include "modal_basis.hpp"

#include <algorithm>
#include <cmath>

#include "voile/errors.hpp"

namespace voile::solve {

namespace {

/// Vectors that complete the modes.
constexpr int corrections = 3;
/// Most vectors for damping that couples the modes with what is left out; rounds of them.
constexpr std::size_t most_damped = 60;
constexpr int damped_rounds = 2;

/// Appends a vector to a basis, M-orthonormal to it, unless next to nothing of it is new: `negligible` is the size below which
/// what is left is round-off.
class Basis {
 public:
  Basis(std::vector<petsc::VecHandle>& vectors, Mat mass) : vectors_(vectors), mass_(mass) {}

  bool add(Vec x, double round_off = 1e-9) {
    const double before = size(x);
    for (int pass = 0; pass < 2; ++pass) remove(x);
    const double left = size(x);
    if (!(left > round_off * before)) return false;
    petsc::VecHandle copy;
    VOILE_PETSC(VecDuplicate(x, copy.out()));
    VOILE_PETSC(VecCopy(x, copy));
    VOILE_PETSC(VecScale(copy, 1.0 / left));
    vectors_.push_back(std::move(copy));
    return true;
  }
  /// y = M x.
  Vec times_mass(Vec x) {
    if (!work_) VOILE_PETSC(VecDuplicate(x, work_.out()));
    VOILE_PETSC(MatMult(mass_, x, work_));
    return work_;
  }

 private:
  double size(Vec x) {
    double square = 0.0;
    VOILE_PETSC(VecDot(x, times_mass(x), &square));
    return std::sqrt(std::max(0.0, square));
  }
  void remove(Vec x) {
    const Vec weighted = times_mass(x);
    std::vector<double> parts;
    for (const petsc::VecHandle& v : vectors_) {
      parts.push_back(0.0);
      VOILE_PETSC(VecDot(v, weighted, &parts.back()));
    }
    for (std::size_t i = 0; i < parts.size(); ++i) VOILE_PETSC(VecAXPY(x, -parts[i], vectors_[i]));
  }

  std::vector<petsc::VecHandle>& vectors_;
  Mat mass_;
  petsc::VecHandle work_;
};

Eigen::MatrixXd projected(const std::vector<petsc::VecHandle>& v, Mat a) {
  const auto n = static_cast<Eigen::Index>(v.size());
  Eigen::MatrixXd all(n, n);
  petsc::VecHandle work;
  VOILE_PETSC(VecDuplicate(v.front(), work.out()));
  for (Eigen::Index j = 0; j < n; ++j) {
    VOILE_PETSC(MatMult(a, v[static_cast<std::size_t>(j)], work));
    for (Eigen::Index i = 0; i < n; ++i) VOILE_PETSC(VecDot(v[static_cast<std::size_t>(i)], work, &all(i, j)));
  }
  return 0.5 * (all + all.transpose());
}

/// f less what the modes take of it.
petsc::VecHandle remainder(const std::vector<petsc::VecHandle>& v, Basis& basis, Vec force) {
  petsc::VecHandle left;
  VOILE_PETSC(VecDuplicate(force, left.out()));
  VOILE_PETSC(VecCopy(force, left));
  for (const petsc::VecHandle& x : v) {
    double part = 0.0;
    VOILE_PETSC(VecDot(x, force, &part));
    VOILE_PETSC(VecAXPY(left, -part, basis.times_mass(x)));
  }
  return left;
}

/// Solves with the tangent assembled last. Throws UserError.
void solve(linear::LinearSolver& linear, Vec rhs, Vec x) {
  VOILE_PETSC(VecZeroEntries(x));
  for (int attempt = 0; !linear.solve_to(linear::well_solved, rhs, x); ++attempt)
    if (!linear.repair(attempt))
      throw UserError("analysis = \"harmonic\": the static correction could not be solved (" + linear.take_failure() +
                      "); check that supports or springs stop every motion without stiffness, and leave out -ksp_ and "
                      "-pc_ options");
}

}  // namespace

petsc::MatHandle damping_matrix(system::Model& model, Vec a, const system::DynamicsOptions& options,
                                const MassMatrix& mass) {
  system::DynamicsOptions own = options;
  own.mass = mass.blocks() ? system::Mass::consistent : system::Mass::lumped;
  own.drag = {};
  system::Dynamics dynamics(model, own);
  petsc::MatHandle damping;
  dynamics.start_step(a, a, 1.0);  // of one second: rates are what a step adds
  dynamics.assemble_tangent(a, energy::Tangent::exact, 1.0, 0.0);
  VOILE_PETSC(MatDuplicate(model.tangent().matrix(), MAT_COPY_VALUES, damping.out()));
  model.potential().start_step(a, 0.0, 0.0);
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatAXPY(damping, -1.0, model.tangent().matrix(), SAME_NONZERO_PATTERN));
  double size = 0.0;
  VOILE_PETSC(MatNorm(damping, NORM_FROBENIUS, &size));
  if (size == 0.0) damping.reset();
  return damping;
}

namespace {

/// Appends (K + s M)^-1 C v of the vectors `from`, no more than make `most` in all.
void add_damped(Basis& basis, std::vector<petsc::VecHandle>& vectors, const std::vector<std::size_t>& from,
                std::size_t most, system::Model& model, linear::LinearSolver& linear, Mat damping) {
  constexpr double is_new = 1e-4;  // of its size: damping in proportion to K and M leaves what solutions are inexact by
  const petsc::VecHandle rhs = model.dofs().create_vector(), x = model.dofs().create_vector();
  for (const std::size_t i : from) {
    if (vectors.size() >= most) return;
    VOILE_PETSC(MatMult(damping, vectors[i], rhs));
    model.dofs().clear_fixed(rhs);
    double size = 0.0;
    VOILE_PETSC(VecNorm(rhs, NORM_2, &size));
    if (size == 0.0) continue;
    solve(linear, rhs, x);
    model.dofs().clear_fixed(x);
    basis.add(x, is_new);
  }
}

}  // namespace

ModalBasis modal_basis(system::Model& model, Vec a, const std::vector<Mode>& modes, const MassMatrix& mass, Mat damping,
                       Vec force) {
  ModalBasis all;
  Basis basis(all.vectors, mass.mat());
  petsc::VecHandle x = model.dofs().create_vector();
  for (const Mode& mode : modes) {
    VOILE_PETSC(VecCopy(mode.shape, x));
    if (!basis.add(x)) throw InternalError("two modes of vibration are the same");
  }
  const std::size_t count = all.vectors.size();
  petsc::VecHandle rhs = remainder(all.vectors, basis, force);
  const double shift = small_shift(model);
  Newton newton(model);
  linear::LinearSolver& linear = newton.linear_solver();
  system::TangentRequest shifted{.kind = energy::Tangent::exact};
  shifted.mass = shift;
  shifted.mass_matrix = mass.blocks();
  model.assemble_tangent(a, shifted);
  linear.tangent_changed();
  double size = 0.0, left = 0.0;
  VOILE_PETSC(VecNorm(force, NORM_2, &size));
  VOILE_PETSC(VecNorm(rhs, NORM_2, &left));
  for (int k = 0; k < corrections && left > 1e-9 * size; ++k) {
    solve(linear, rhs, x);
    model.dofs().clear_fixed(x);
    if (!basis.add(x)) break;
    VOILE_PETSC(VecCopy(basis.times_mass(all.vectors.back()), rhs));
  }
  all.fewer = all.vectors.size() > count ? all.vectors.size() - 1 : count;
  if (damping) {
    std::vector<std::size_t> from;
    for (std::size_t i = count; i < all.vectors.size(); ++i) from.push_back(i);
    for (std::size_t i = 0; i < count; ++i) from.push_back(i);
    const std::size_t most = all.vectors.size() + most_damped;
    for (int round = 0; round < damped_rounds; ++round) {
      const std::size_t before = all.vectors.size();
      add_damped(basis, all.vectors, from, most, model, linear, damping);
      if (all.vectors.size() == before) break;
      all.fewer = before;
      from.clear();
      for (std::size_t i = before; i < all.vectors.size(); ++i) from.push_back(i);
    }
  }
  all.system.stiffness = projected(all.vectors, model.tangent().matrix());
  all.system.stiffness.diagonal().array() -= shift;
  // The modes have their own values, without the round-off of the product.
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    all.system.stiffness.row(at).setZero();
    all.system.stiffness.col(at).setZero();
    all.system.stiffness(at, at) = modes[i].eigenvalue;
  }
  if (damping) all.system.damping = projected(all.vectors, damping);
  all.system.force.resize(static_cast<Eigen::Index>(all.vectors.size()));
  for (std::size_t i = 0; i < all.vectors.size(); ++i)
    VOILE_PETSC(VecDot(all.vectors[i], force, &all.system.force[static_cast<Eigen::Index>(i)]));
  return all;
}

}  // namespace voile::solve
