#include "relaxation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/decompositions.hpp"
#include "linear/inexact_pc.hpp"
#include "linear/linear_solver.hpp"
#include "step_bound.hpp"

namespace voile::solve {

namespace {

/// tau in times of a signal over a cell.
constexpr double signal_times = 10.0;
/// Halvings of an iteration that does not lower the energy.
constexpr int most_halvings = 12;
/// Of systems in a motion: so small that numbers of ranks hardly differ.
constexpr double tolerance = 1e-8;
/// On the mass of vertices that stay: they move by a millionth of what they would.
constexpr double mass_factor = 1e6;

class Minimiser {
 public:
  Minimiser(system::Model& model, Vec a, const RelaxationOptions& options)
      : model_(model), linear_(model), force_(options.force), inverse_(1.0 / (options.tau * options.tau)) {
    for (petsc::VecHandle* v : {&start_, &gradient_, &increment_, &trial_, &scratch_, &mass_})
      *v = model.dofs().create_vector();
    set_masses(options.stays);
    VOILE_PETSC(VecCopy(a, start_));
    VOILE_PETSC(KSPCreate(model.dofs().comm(), ksp_.out()));
    VOILE_PETSC(KSPSetOptionsPrefix(ksp_, "relax_"));
    linear_.set_defaults(ksp_, force_ ? linear::LinearSolver::Method::inexact : linear::LinearSolver::Method::direct);
    VOILE_PETSC(KSPSetFromOptions(ksp_));
    linear_.prepare();
    if (PC pc = linear_.inexact()) linear::set_inexact_tolerance(pc, tolerance);
    model.potential().count_from(a);
  }

  /// False if nothing better was found.
  bool iterate(Vec a) {
    model_.residual(a, gradient_);
    damp(a);
    VOILE_PETSC(VecAXPY(gradient_, inverse_, scratch_));
    if (force_) VOILE_PETSC(VecAXPY(gradient_, -1.0, force_));
    model_.dofs().clear_fixed(gradient_);
    model_.assemble_tangent(a, {.kind = energy::Tangent::positive, .mass = inverse_, .masses = mass_});
    VOILE_PETSC(KSPSetOperators(ksp_, model_.tangent().matrix(), model_.tangent().matrix()));
    linear_.tangent_changed();
    if (!linear_.solve(gradient_, increment_)) return false;
    double fraction = allowed_fraction(model_, a, increment_, trial_);
    if (!model_.conditions().symmetric()) {
      VOILE_PETSC(VecAXPY(a, -fraction, increment_));
      return true;
    }
    const double before = energy(a);
    VOILE_PETSC(VecCopy(a, trial_));
    for (int k = 0; k < most_halvings; ++k, fraction *= 0.5) {
      VOILE_PETSC(VecWAXPY(a, -fraction, increment_, trial_));
      if (energy(a) <= before) return true;
    }
    VOILE_PETSC(VecCopy(trial_, a));
    return false;
  }

  [[nodiscard]] int factorisations() const { return linear_.factorisations(); }
  [[nodiscard]] double moved(Vec a) {
    double largest = 0.0;
    VOILE_PETSC(VecWAXPY(scratch_, -1.0, start_, a));
    VOILE_PETSC(VecNorm(scratch_, NORM_INFINITY, &largest));
    return largest;
  }

 private:
  /// M (a - a_0), into scratch_.
  void damp(Vec a) {
    VOILE_PETSC(VecWAXPY(scratch_, -1.0, start_, a));
    VOILE_PETSC(VecPointwiseMult(scratch_, scratch_, mass_));
  }
  void set_masses(const std::vector<char>& stays) {
    std::vector<double> factors(3 * static_cast<std::size_t>(model_.dofs().mesh().vertex_count()), 1.0);
    for (std::size_t i = 0; i < factors.size() && !stays.empty(); ++i)
      if (stays[i / 3]) factors[i] = mass_factor;
    model_.dofs().scatter(factors, scratch_);
    VOILE_PETSC(VecPointwiseMult(mass_, model_.potential().constant().mass(), scratch_));
  }
  double energy(Vec a) {
    double damping = 0.0, with_start = 0.0, work = 0.0;
    damp(a);
    VOILE_PETSC(VecDot(scratch_, a, &damping));
    VOILE_PETSC(VecDot(scratch_, start_, &with_start));
    if (force_) {
      VOILE_PETSC(VecWAXPY(scratch_, -1.0, start_, a));
      VOILE_PETSC(VecDot(force_, scratch_, &work));
    }
    return model_.energy(a) - work + 0.5 * inverse_ * (damping - with_start);
  }

  system::Model& model_;
  petsc::KspHandle ksp_;
  linear::LinearSolver linear_;
  Vec force_;
  double inverse_;
  petsc::VecHandle start_, gradient_, increment_, trial_, scratch_, mass_;
};

}  // namespace

Relaxation relax(system::Model& model, Vec a, const RelaxationOptions& options) {
  model.conditions().enforce(a);
  Minimiser minimiser(model, a, options);
  Relaxation r;
  while (r.steps < options.steps && minimiser.iterate(a)) ++r.steps;
  r.factorisations = minimiser.factorisations();
  r.moved = minimiser.moved(a);
  return r;
}

double relaxation_time(const system::Model& model) {
  double longest = 0.0;
  for (const energy::Material& m : model.discretisation().materials()) {
    const double stiffness = eigenvalues(Eigen::MatrixXd(m.membrane)).maxCoeff();
    const double density = m.areal_density > 0.0 ? m.areal_density : 1.0;  // as in the lumped mass
    longest = std::max(longest, std::sqrt(density / stiffness));
  }
  return signal_times * longest * std::sqrt(model.discretisation().mean_area());
}

}  // namespace voile::solve
