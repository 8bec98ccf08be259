#include "potential.hpp"

#include <algorithm>
#include <cmath>

#include "attachments.hpp"
#include "bands.hpp"
#include "base/mpi.hpp"
#include "bending_energy.hpp"
#include "boundary_conditions.hpp"
#include "discretisation.hpp"
#include "energy/angle_bending.hpp"
#include "energy/coupling.hpp"
#include "energy/membrane.hpp"
#include "energy/mirror_fold.hpp"
#include "energy/yarn_friction.hpp"
#include "natural_states.hpp"
#include "sewing_springs.hpp"
#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

void Potential::set_time(double time) {
  time_ = time;
  attachments_->place();
  bands_->tighten(time);
  if (!sewing_) return;
  sewing_->tighten(time);
  drawn_in_ = sewing_->drawn_in(time);
  membrane_->kernel.gather(drawn_in_);
}

bool Potential::depends_on_time() const {
  return bending_->turns() || bands_->rise() || sewing_ || !attachments_->list().empty() || natural_states_change();
}

bool Potential::has_constant_folds() const {
  return natural_ && natural_->has_constant_folds();
}

void Potential::ease_folds(double fraction) {
  if (natural_) natural_->ease_folds(fraction);
}

bool Potential::natural_states_change() const {
  return natural_ && natural_->changes();
}

energy::Configuration Potential::configuration(Vec a) {
  bending_->turn(conditions_->rotations());
  folds_->turn(conditions_->rotations());
  attachments_->place();
  if (natural_)
    mpi::on_all(on_->comm(), [&] { natural_->set(time_, hold_natural_ ? 0.0 : conditions_->load_factor()); });
  if (coupling_) update_coupling();
  on_->dofs().update_points(a, u_, x_);
  return {x_.data(), u_.data(), nullptr, energy::Tangent::exact};
}

std::vector<Vec3>& Potential::point_forces(const energy::Configuration& c) {
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  for (const Counted& t : terms_) t.term->add_forces(c, force_);
  return force_;
}

void Potential::force(const energy::Configuration& c, Vec a, Vec f) {
  bending_->force(a, f);
  on_->dofs().add_forces(point_forces(c), f);
  add_body_lengths(f);
}

/// What holds the lengths of the quaternions of rigid bodies.
void Potential::add_body_lengths(Vec f) const {
  const std::vector<RigidMotion>& motions = on_->dofs().motions();
  if (motions.empty()) return;
  const petsc::WriteArray out(f);
  for (std::size_t b = 0; b < motions.size(); ++b) on_->dofs().add_turning_force(b, motions[b].length_force(), out);
}

Energies Potential::energies(const energy::Configuration& c, Vec a, bool viscous) {
  const std::vector<double> viscosity = membrane_->kernel.viscosity();
  if (!viscous) membrane_->kernel.set_viscosity({});
  Energies e;
  for (const Counted& t : terms_) e.*t.part += mpi::sum(on_->comm(), t.term->energy(c));
  if (!viscous) membrane_->kernel.set_viscosity(viscosity);
  if (!viscous && yarns_) e.bending -= mpi::sum(on_->comm(), yarns_->kernel.lost(c));
  if (!viscous && membrane_->kernel.rubs()) e.membrane -= mpi::sum(on_->comm(), membrane_->kernel.lost(c));
  const double ground = bending_->ground_energy(a);
  e.bending += bending_->energy(a) - ground;
  e.springs += ground;
  for (const RigidMotion& motion : on_->dofs().motions()) e.springs += motion.length_energy();
  return e;
}

double Potential::natural_force() const {
  return natural_ ? std::sqrt(mpi::sum(on_->comm(), natural_->squared_force())) : 0.0;
}

double Potential::unbalanced_membrane(Vec a) {
  const double scale = natural_force();
  if (!(scale > 0.0)) return 0.0;
  double size = 0.0;
  const energy::Configuration c = configuration(a);
  VOILE_PETSC(VecZeroEntries(work_));
  add_term_forces(*membrane_, c, work_);
  on_->dofs().clear_fixed(work_);
  VOILE_PETSC(VecNorm(work_, NORM_2, &size));
  return size / scale;
}

double Potential::natural_growth() const {
  return mpi::max(on_->comm(), natural_ ? natural_->growth() : 0.0);
}

void Potential::add_load_direction(Vec a, Vec f) {
  if (!natural_states_change()) return;
  // The metric of a natural state is a polynomial of second degree where temperatures are linear: the difference is exact then.
  constexpr double step = 1e-3;
  const energy::Configuration c = configuration(a);
  for (const double sign : {1.0, -1.0}) {
    natural_->set(time_, conditions_->load_factor() + sign * step);
    if (coupling_) update_coupling();
    VOILE_PETSC(VecZeroEntries(work_));
    for (const Counted& t : terms_) add_term_forces(*t.term, c, work_);
    VOILE_PETSC(VecAXPY(f, -sign * 0.5 / step, work_));
  }
  natural_->set(time_, conditions_->load_factor());
  if (coupling_) update_coupling();
}

void Potential::update_coupling() {
  if (coupled_version_ == membrane_->kernel.version()) return;
  coupled_version_ = membrane_->kernel.version();
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    Vec3 bent = coupled_[k].rest_curvature;
    if (natural_) bent += natural_->curvature_change(coupled_[k].triangle);
    coupling_->set_natural(static_cast<Index>(k), membrane_->kernel.natural_metric(coupled_[k].membrane), bent);
  }
}

void Potential::count_from(Vec a) {
  bending_->count_from(a);
}

void Potential::start_step(Vec a, double viscosity, double inverse_step) {
  membrane_->kernel.start_step(configuration(a), viscosity, inverse_step);
}

/// Adds the forces of a term on the local points to f.
void Potential::add_term_forces(const Term& term, const energy::Configuration& c, Vec f) {
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  term.add_forces(c, force_);
  on_->dofs().add_forces(force_, f);
}

Potential::Work Potential::work(const energy::Configuration& c, Vec a, Vec displacement, Vec f) {
  const auto along = [&](Vec force) {
    double product = 0.0;
    VOILE_PETSC(VecDot(force, displacement, &product));
    return product;
  };
  const auto membrane = [&](double sign) {
    VOILE_PETSC(VecZeroEntries(work_));
    add_term_forces(*membrane_, c, work_);
    VOILE_PETSC(VecAXPY(f, sign, work_));
    return along(work_);
  };
  Work w;
  bending_->force(a, f);
  const std::vector<double> viscosity = membrane_->kernel.viscosity();
  membrane_->kernel.set_viscosity({});
  for (const Counted& t : terms_) add_term_forces(*t.term, c, f);
  add_body_lengths(f);
  w.elastic = along(f);
  if (viscosity.empty()) return w;
  const double elastic = membrane(-1.0);
  membrane_->kernel.set_viscosity(viscosity);
  w.viscous = membrane(1.0) - elastic;
  return w;
}

void Potential::multiply_bending(Vec x, Vec y) const {
  bending_->multiply_sheet(x, y);
}

void Potential::write_tangent(const energy::Configuration& c, const BlockMatrix& tangent, int pattern,
                              const BlockMatrix::Values& values, double bending) {
  double* halves = halves_.open();
  for (const Counted& t : terms_) t.term->add_halves(c, halves);
  {
    const petsc::EventScope copy(petsc::events().bending_copy);
    halves_.write_to(tangent, values, constant_.bending(), bending);
  }
  if (bending != 1.0) bending_->take_springs_from(tangent, values, bending - 1.0);
  for (const Counted& t : terms_) t.term->add_blocks(c, on_->dofs(), tangent, pattern, values);
}

bool Potential::has_yarn_friction() const {
  return yarns_ != nullptr || membrane_->kernel.rubs();
}

double Potential::yarn_loss(Vec a) {
  if (!has_yarn_friction()) return 0.0;
  const energy::Configuration c = configuration(a);
  return mpi::sum(on_->comm(), (yarns_ ? yarns_->kernel.lost(c) : 0.0) + membrane_->kernel.lost(c));
}

void Potential::end_step(Vec a) {
  if (!has_yarn_friction()) return;
  yarn_losses_ += yarn_loss(a);
  const energy::Configuration c = configuration(a);
  if (yarns_) yarns_->kernel.end_step(c);
  membrane_->kernel.end_step(c);
}

/// Slips of a triangle: of all sliders in bending, then that in shear.
std::size_t Potential::slips_per_triangle() const {
  const int bending = yarns_ ? yarns_->kernel.numbers() : 0, shear = membrane_->kernel.rubs() ? 1 : 0;
  return static_cast<std::size_t>(bending) + static_cast<std::size_t>(shear);
}

std::vector<double> Potential::slips() const {
  if (!has_yarn_friction()) return {};
  const std::size_t each = slips_per_triangle();
  std::vector<double> all(each * static_cast<std::size_t>(on_->mesh().triangle_count()), 0.0);
  const auto of = [&](Index triangle) { return all.begin() + static_cast<std::ptrdiff_t>(each) * triangle; };
  for (Index e = 0; yarns_ && e < yarns_->kernel.size(); ++e) {
    if (!yarns_->kernel.owned(e)) continue;
    const std::vector<double> own = yarns_->kernel.slips(e);
    std::copy(own.begin(), own.end(), of(yarns_->kernel.triangle(e)));
  }
  if (membrane_->kernel.rubs())
    for (Index e = 0; e < membrane_->kernel.size(); ++e)
      if (membrane_->kernel.owned(e))
        of(on_->elements()[e].triangle)[static_cast<std::ptrdiff_t>(each) - 1] = membrane_->kernel.slip(e);
  mpi::sum_to_root(on_->comm(), all);
  if (mpi::rank(on_->comm()) != 0) return {};
  all.insert(all.begin(), yarn_losses_);
  return all;
}

void Potential::restore_slips(std::vector<double> slips) {
  mpi::broadcast(on_->comm(), slips);
  if (slips.empty() || !has_yarn_friction()) return;
  const std::size_t each = slips_per_triangle();
  if (slips.size() != 1 + each * static_cast<std::size_t>(on_->mesh().triangle_count()))
    throw UserError(
        "the state of the restart has another number of sliders of friction inside the fabric; give the same "
        "[[material]] bending_sliders and the same friction in shear as the run that wrote it");
  yarn_losses_ = slips[0];
  const auto of = [&](Index triangle) { return slips.data() + 1 + each * static_cast<std::size_t>(triangle); };
  for (Index e = 0; yarns_ && e < yarns_->kernel.size(); ++e)
    yarns_->kernel.set_slips(e, of(yarns_->kernel.triangle(e)));
  if (membrane_->kernel.rubs())
    for (Index e = 0; e < membrane_->kernel.size(); ++e)
      membrane_->kernel.set_slip(e, of(on_->elements()[e].triangle)[each - 1]);
}

TriangleFields Potential::triangle_fields(Vec a, const std::vector<energy::EdgeBend>& edge_bends) {
  const energy::Configuration c = configuration(a);
  return recovery_.fields(on_->comm(), on_->element_sheet(), on_->mesh().triangle_count(),
                          {membrane_->kernel, angles_->kernel, joints_, natural_.get(), edge_bends}, c);
}

long Potential::uncorrected_triangles() const {
  return mpi::sum(on_->comm(), membrane_->kernel.left_out());
}

}  // namespace voile::system
