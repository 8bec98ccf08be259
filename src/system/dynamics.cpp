#include "dynamics.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "base/mpi.hpp"
#include "contact.hpp"
#include "energy/drag.hpp"
#include "energy/sheet.hpp"
#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

void require_mass(const Model& model) {
  for (const energy::Material& m : model.discretisation().materials())
    if (!(m.areal_density > 0.0))
      throw UserError(
          "[[material]]: vibration and motion in time need the mass of every material: give density (or "
          "areal_density)");
}

void settle_contact(Model& model, Vec u, double time) {
  if (!model.contact()) return;
  // Whether something balances a barrier is asked of the whole one, not of what an earlier motion has let grow so far.
  ContactMemory memory = model.contact()->memory();
  memory.gaps.clear();
  model.contact()->restore(std::move(memory));
  const petsc::VecHandle residual = model.dofs().create_vector();
  model.residual(u, residual);
  model.dofs().clear_fixed(residual);
  model.contact()->begin_settling(u, residual, time);
}

Dynamics::Dynamics(Model& model, DynamicsOptions options)
    : model_(model),
      options_(std::move(options)),
      work_(model.dofs().create_vector()),
      sum_(model.dofs().create_vector()) {
  if (!options_.any_mass) require_mass(model);
  if (options_.mass == Mass::consistent) consistent_ = model.potential().constant().consistent_mass();
  build_drag();
}

/// Air acts on the triangles of the membrane.
Dynamics::~Dynamics() = default;

void Dynamics::build_drag() {
  drag_ = std::make_unique<ElementTerm<energy::DragTerm>>();
  drag_->kernel = energy::DragTerm(options_.drag);
  if (!options_.drag.active()) return;
  for (const Discretisation::Element& e : model_.discretisation().elements())
    drag_->kernel.add(e.points, model_.dofs().mesh().area(e.triangle), e.owned);
  const auto points = static_cast<std::size_t>(model_.dofs().local().count());
  for (auto* v : {&velocity_, &position_, &force_}) v->resize(points);
}

energy::Configuration Dynamics::moving(Vec v) const {
  model_.dofs().update_points(v, velocity_, force_);  // the sum with rest positions is not used
  return {velocity_.data(), velocity_.data(), nullptr, energy::Tangent::exact};
}

void Dynamics::set_time(double time) {
  time_ = time;
  model_.conditions().set_load_factor(options_.load_history ? options_.load_history(time) : 1.0);
  model_.set_time(time);
  if (options_.drag.wind_in_time) drag_->kernel.set_wind(options_.drag.wind_in_time(time));
}

void Dynamics::remember(Vec u, Vec v, double dt) {
  model_.potential().start_step(u, options_.viscous_time / dt, options_.material_damping ? 1.0 / dt : 0.0);
  if (!options_.drag.active()) return;
  model_.dofs().update_points(u, force_, position_);
  drag_->kernel.start_step(position_.data(), moving(v).x);
}

void Dynamics::resume_step(const StepStart& start) {
  const double now = time();
  const auto set_time = [&](double time) {
    model_.conditions().set_time(time);
    model_.potential().set_time(time);
    if (options_.drag.wind_in_time) drag_->kernel.set_wind(options_.drag.wind_in_time(time));
  };
  set_time(start.time);
  remember(start.u, start.v, start.size);
  set_time(now);
}

void Dynamics::start_step(Vec u, Vec v, double dt) {
  remember(u, v, dt);
  if (Contact* contact = model_.contact()) contact->start_step(u, contact->scene().input().options.slip_speed * dt);
}

void Dynamics::apply_mass(Vec x, Vec y) const {
  multiply_mass(x, y);
  model_.dofs().clear_fixed(y);
}

void Dynamics::multiply_mass(Vec x, Vec y) const {
  if (consistent_)
    VOILE_PETSC(MatMult(consistent_->mat(), x, y));
  else
    VOILE_PETSC(VecPointwiseMult(y, model_.potential().constant().mass(), x));
  apply_body_mass(x, y);
}

/// Rows of rigid bodies, at the state taken last.
void Dynamics::apply_body_mass(Vec x, Vec y) const {
  const Dofs& dofs = model_.dofs();
  if (dofs.motions().empty()) return;
  const std::vector<RigidMotion::Row> rows = dofs.body_rows(x), wrong = dofs.body_rows(y);
  const petsc::WriteArray out(y);
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const RigidMotion::Row f =
        dofs.motions()[b].mass(model_.potential().constant().body_mass()[b]) * rows[b] - wrong[b];
    dofs.add_body_row(b, f, out);
  }
}

/// What rigid bodies that turn push besides their mass times acceleration.
void Dynamics::add_gyration(Vec v, Vec f) const {
  const Dofs& dofs = model_.dofs();
  if (dofs.motions().empty()) return;
  const std::vector<RigidMotion::Row> rates = dofs.body_rows(v);
  const petsc::WriteArray out(f);
  for (std::size_t b = 0; b < rates.size(); ++b)
    dofs.add_body_row(b, dofs.motions()[b].gyration(model_.potential().constant().body_mass()[b], rates[b]), out);
}

void Dynamics::prescribe_rates(const MotionTime& at, bool from_here, Vec v, Vec a) const {
  if (model_.holds_still()) {
    for (Vec rates : {v, a})
      if (rates) model_.dofs().clear_fixed(rates);
    return;
  }
  const auto factor = [&](double t) { return options_.load_history ? options_.load_history(t) : 1.0; };
  if (v) model_.conditions().prescribe_velocity(at, from_here, factor, v);
  if (a) model_.conditions().prescribe_acceleration(at, factor, a);
}

void Dynamics::add_inertia(Vec a, Vec v, const MotionTime& at, Vec f) const {
  prescribe_rates(at, false, nullptr, a);
  multiply_mass(a, work_);
  add_gyration(v, work_);
  VOILE_PETSC(VecAXPY(f, 1.0, work_));
  add_coupled_inertia(a, v, f);
}

/// The consistent mass has no rows of what is held.
void Dynamics::add_coupled_inertia(Vec a, Vec v, Vec f) const {
  if (!consistent_) return;
  const Dofs& dofs = model_.dofs();
  const petsc::VecHandle x = dofs.create_vector(), held = dofs.create_vector();
  VOILE_PETSC(VecWAXPY(x, options_.mass_damping, v, a));
  dofs.clear_fixed(x);
  const std::vector<Vec3> of = dofs.point_changes(x);
  std::vector<Vec3> forces(of.size(), Vec3::Zero());
  for (const Discretisation::Element& e : model_.discretisation().elements()) {
    const double part =
        model_.discretisation().sheet().material(e.triangle).areal_density * dofs.mesh().area(e.triangle) / 12.0;
    for (const Index i : e.points)
      for (const Index j : e.points)
        forces[static_cast<std::size_t>(i)] += (i == j ? 2.0 : 1.0) * part * of[static_cast<std::size_t>(j)];
  }
  dofs.add_forces(forces, held);
  dofs.clear_free(held);
  VOILE_PETSC(VecAXPY(f, 1.0, held));
}

void Dynamics::add_drag(Vec v, Vec f) const {
  const energy::Configuration c = moving(v);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  drag_->add_forces(c, force_);
  model_.dofs().add_forces(force_, f);
}

void Dynamics::add_damping(Vec v, Vec f) const {
  if (options_.mass_damping > 0.0) {
    multiply_mass(v, work_);
    VOILE_PETSC(VecAXPY(f, options_.mass_damping, work_));
  }
  if (options_.bending_damping > 0.0) {
    model_.potential().multiply_bending(v, work_);
    VOILE_PETSC(VecAXPY(f, options_.bending_damping, work_));
  }
  if (material_damping()) {
    model_.potential().constant().multiply_damping(v, work_);
    VOILE_PETSC(VecAXPY(f, 1.0, work_));
  }
  if (options_.drag.active()) add_drag(v, f);
}

void Dynamics::residual(Vec u, Vec v, Vec a, Vec f) {
  model_.residual(u, f);
  apply_mass(a, sum_);
  add_gyration(v, sum_);
  model_.dofs().clear_fixed(sum_);
  double inertia = 0.0;
  VOILE_PETSC(VecNorm(sum_, NORM_2, &inertia));
  force_scale_ = std::max(model_.force_scale(), inertia);
  add_damping(v, sum_);
  model_.dofs().clear_fixed(sum_);
  VOILE_PETSC(VecAXPY(f, 1.0, sum_));
}

double Dynamics::energy(Vec u, Vec v, Vec a, double s_v, double s_a) {
  double sum = model_.energy(u), part = 0.0;
  apply_mass(a, work_);
  VOILE_PETSC(VecDot(work_, a, &part));
  sum += 0.5 * part / s_a;
  if (options_.mass_damping > 0.0) {
    apply_mass(v, work_);
    VOILE_PETSC(VecDot(work_, v, &part));
    sum += 0.5 * options_.mass_damping * part / s_v;
  }
  if (options_.bending_damping > 0.0) {
    model_.potential().multiply_bending(v, work_);
    VOILE_PETSC(VecDot(work_, v, &part));
    sum += 0.5 * options_.bending_damping * part / s_v;
  }
  if (material_damping()) {
    model_.potential().constant().multiply_damping(v, work_);
    VOILE_PETSC(VecDot(work_, v, &part));
    sum += 0.5 * part / s_v;
  }
  if (options_.drag.active()) sum += mpi::sum(model_.dofs().comm(), drag_->energy(moving(v))) / s_v;
  return sum;
}

void Dynamics::assemble_tangent(Vec u, energy::Tangent kind, double s_v, double s_a) {
  TangentRequest request;
  request.kind = kind;
  request.bending = 1.0 + options_.bending_damping * s_v;
  request.damping = options_.material_damping ? s_v : 0.0;
  request.mass = s_a + options_.mass_damping * s_v;
  request.mass_matrix = consistent_ ? &*consistent_ : nullptr;
  drag_->kernel.set_scale(s_v);
  if (options_.drag.active()) request.extra = drag_.get();
  model_.assemble_tangent(u, request);
}

double Dynamics::longest_viscous_time() const {
  double longest = 0.0;
  if (options_.material_damping)
    for (const energy::Material& m : model_.discretisation().materials()) longest = std::max(longest, m.viscous_time);
  return longest + options_.viscous_time;
}

Dynamics::Work Dynamics::work(Vec u, Vec v, Vec a, Vec displacement, Vec loads, Vec reactions) {
  Work w;
  w.model = work_of_forces(model_, u, displacement, sum_, work_);
  if (loads) VOILE_PETSC(VecCopy(work_, loads));
  const auto add = [&](double factor) {
    double product = 0.0;
    VOILE_PETSC(VecDot(work_, displacement, &product));
    VOILE_PETSC(VecAXPY(sum_, factor, work_));
    return factor * product;
  };
  apply_mass(a, work_);
  add_gyration(v, work_);
  model_.dofs().clear_fixed(work_);
  w.inertia = add(1.0);
  if (options_.mass_damping > 0.0) {
    multiply_mass(v, work_);
    w.damping += add(options_.mass_damping);
  }
  if (options_.bending_damping > 0.0) {
    model_.potential().multiply_bending(v, work_);
    w.damping += add(options_.bending_damping);
  }
  if (material_damping()) {
    model_.potential().constant().multiply_damping(v, work_);
    w.damping += add(1.0);
  }
  if (options_.drag.active()) {
    VOILE_PETSC(VecZeroEntries(work_));
    add_drag(v, work_);
    w.drag = add(1.0);
  }
  model_.dofs().clear_free(sum_);
  VOILE_PETSC(VecDot(sum_, displacement, &w.reactions));
  if (reactions) VOILE_PETSC(VecCopy(sum_, reactions));
  return w;
}

double Dynamics::kinetic_energy(Vec v) const {
  double twice = 0.0;
  apply_mass(v, work_);
  VOILE_PETSC(VecDot(work_, v, &twice));
  return 0.5 * twice;
}

double Dynamics::kinetic_energy_of_held(Vec v, double dt) const {
  BoundaryConditions& conditions = model_.conditions();
  if (!conditions.has_prescribed() || !time_) return 0.0;
  const auto at = [&](double time) {
    conditions.set_load_factor(options_.load_history ? options_.load_history(time) : 1.0);
    conditions.set_time(time);
  };
  const double begin = std::max(0.0, *time_ - dt);  // before the start a motion may not be defined
  const petsc::VecHandle all = model_.dofs().create_vector(), before = model_.dofs().create_vector();
  at(begin + dt);
  conditions.enforce(all);
  at(begin);
  conditions.enforce(before);
  at(*time_);
  VOILE_PETSC(VecAXPBY(all, -1.0 / dt, 1.0 / dt, before));  // zero where it is free
  VOILE_PETSC(VecCopy(v, before));
  model_.dofs().clear_fixed(before);
  VOILE_PETSC(VecAXPY(all, 1.0, before));
  double twice = 0.0;
  multiply_mass(all, work_);
  VOILE_PETSC(VecDot(work_, all, &twice));
  return 0.5 * twice - kinetic_energy(v);
}

namespace {

/// Sum over the vertices of f(position, momentum) in global axes, on every rank.
template <class F>
Vec3 sum_over_vertices(const Model& model, Vec u, Vec momentum, const F& f) {
  const bool tied = model.dofs().ties().any();
  const std::vector<double> p = tied ? model.dofs().gather_forces(momentum) : model.dofs().gather(momentum);
  const std::vector<double> x = u ? model.dofs().gather(u) : std::vector<double>(p.size(), 0.0);
  std::vector<double> sum(3, 0.0);
  for (std::size_t i = 0; i + 2 < p.size(); i += 3) {
    const Vec3 place = model.dofs().mesh().positions()[i / 3] + Vec3(x[i], x[i + 1], x[i + 2]);
    const Vec3 value = f(place, Vec3(p[i], p[i + 1], p[i + 2]));
    for (int k = 0; k < 3; ++k) sum[static_cast<std::size_t>(k)] += value[k];
  }
  mpi::broadcast(model.dofs().comm(), sum);
  return {sum[0], sum[1], sum[2]};
}

}  // namespace

Vec3 Dynamics::momentum(Vec v) const {
  apply_mass(v, work_);
  return sum_over_vertices(model_, nullptr, work_, [](const Vec3&, const Vec3& p) { return p; });
}

Vec3 Dynamics::angular_momentum(Vec u, Vec v) const {
  apply_mass(v, work_);
  return sum_over_vertices(model_, u, work_, [](const Vec3& x, const Vec3& p) { return Vec3(x.cross(p)); });
}

}  // namespace voile::system
