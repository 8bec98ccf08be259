#include "energy_account.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "contact.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

template <class Balance>
auto members_of(Balance& b) {
  return std::array{&b.initial, &b.kinetic, &b.stored,     &b.loads,     &b.supports,  &b.obstacles,
                    &b.damping, &b.drag,    &b.friction,   &b.numerical, &b.remeshing, &b.unaccounted,
                    &b.inflow,  &b.fabric,  &b.most_taken, &b.created,   &b.internal,  &b.barriers};
}

double internal_of(const Energies& e) {
  return e.membrane + e.bending + e.springs;
}

/// a - b, or 0 where that is the round-off of energies that are counted from another state.
double difference(double a, double b) {
  constexpr double round_off = 1e-12;
  return std::abs(a - b) <= round_off * std::max(std::abs(a), std::abs(b)) ? 0.0 : a - b;
}

}  // namespace

double EnergyBalance::turnover() const {
  return std::abs(initial) + inflow;
}

std::vector<double> numbers_of(const EnergyBalance& balance) {
  std::vector<double> numbers;
  if (balance.kept)
    for (const double* value : members_of(balance)) numbers.push_back(*value);
  return numbers;
}

EnergyBalance balance_of(const std::vector<double>& numbers) {
  EnergyBalance balance;
  if (numbers.empty()) return balance;
  if (numbers.size() < fewest_balance_numbers || numbers.size() > balance_numbers)
    throw InternalError("an energy balance of another size");
  balance.kept = true;
  std::size_t i = 0;
  for (double* value : members_of(balance)) *value = i < numbers.size() ? numbers[i++] : 0.0;
  return balance;
}

EnergyAccount::EnergyAccount(Dynamics& dynamics, double moment)
    : dynamics_(dynamics),
      moment_(moment),
      start_(dynamics.model().dofs().create_vector()),
      displacement_(dynamics.model().dofs().create_vector()) {
  for (Stage* stage : {&last_, &now_})
    for (petsc::VecHandle* v : {&stage->loads, &stage->reactions, &stage->external})
      *v = dynamics.model().dofs().create_vector();
}

EnergyAccount::Levels EnergyAccount::levels(Vec u, Vec v) {
  const Energies e = energies(dynamics_.model(), u);
  const double held = dynamics_.kinetic_energy_of_held(v, moment_);
  return {dynamics_.kinetic_energy(v) + held, internal_of(e), e.contact, held};
}

void EnergyAccount::begin(Vec u, Vec v, Vec a, const EnergyBalance& before, bool other_case) {
  before_ = levels(u, v);
  const petsc::VecHandle none = dynamics_.model().dofs().create_vector();
  // Velocities that jump at the start of a motion may have damping forces that are over long before the end of a step.
  take_stage(u, a ? v : none, a ? a : none, none);
  // Last digits of stored energies depend on the way there: the same motion continues with those of the unbroken run.
  if (before.kept && before_.kinetic == before.kinetic && before.internal + before.barriers == before.stored &&
      difference(before_.sum(), before.kinetic + before.stored) == 0.0) {
    before_.internal = before.internal;
    before_.contact = before.barriers;
  }
  balance_ = before;
  if (before.kept)
    (other_case ? balance_.initial : balance_.remeshing) += difference(before_.sum(), before.kinetic + before.stored);
  else
    balance_.initial = before_.sum();
  balance_.kept = true;
  balance_.kinetic = before_.kinetic;
  balance_.stored = before_.internal + before_.contact;
  balance_.internal = before_.internal;
  balance_.barriers = before_.contact;
}

void EnergyAccount::take_stage(Vec u, Vec v, Vec a, Vec displacement) {
  work_ = dynamics_.work(u, v, a, displacement, now_.loads, now_.reactions);
  now_.time = dynamics_.time();
  now_.forced = dynamics_.model().conditions().has_external();
  VOILE_PETSC(VecZeroEntries(now_.external));
  dynamics_.model().conditions().add_external(1.0, now_.external);
}

void EnergyAccount::renew(Vec u, Vec v, Vec a) {
  VOILE_PETSC(VecZeroEntries(displacement_));
  take_stage(u, v, a, displacement_);
}

void EnergyAccount::take_forces(Vec u_0, Vec u_1, Vec u, Vec v, Vec a) {
  VOILE_PETSC(VecCopy(u_0, start_));
  VOILE_PETSC(VecWAXPY(displacement_, -1.0, u_0, u_1));
  std::swap(last_, now_);
  take_stage(u, v, a, displacement_);
  // Forces from outside that come or go do so at the start of the step; between two that are given they change evenly.
  if (last_.forced != now_.forced)
    VOILE_PETSC(VecAXPY(last_.loads, now_.forced ? 1.0 : -1.0, now_.forced ? now_.external : last_.external));
  for (Stage* stage : {&last_, &now_}) {
    VOILE_PETSC(VecDot(stage->loads, displacement_, &stage->load_work));
    VOILE_PETSC(VecDot(stage->reactions, displacement_, &stage->reaction_work));
  }
  if (Contact* contact = dynamics_.model().contact()) {
    friction_ = contact->friction_work(u);
    obstacles_ = contact->obstacle_work(u);
  }
}

double EnergyAccount::driven(Vec u_1, double t_0, double t_1, double internal_now) {
  Model& model = dynamics_.model();
  if (!model.potential().depends_on_time()) return 0.0;
  // Where the fabric rubs, its loss within the step resists too, and turns its sign with the way: forces at both ends count then,
  // as energies over the whole step would go a way that is not taken.
  const bool rubs = model.potential().has_yarn_friction();
  const double fraction = rubs ? 1e-3 : 1.0, part = fraction * (t_1 - t_0);
  const auto resisting = [&](Vec u) {
    return internal_of(energies(model, u, false)) + (rubs ? model.potential().yarn_loss(u) : 0.0);
  };
  if (rubs) dynamics_.set_time(t_0 + part);
  const double with_start = resisting(start_) - before_.internal;
  if (rubs) dynamics_.set_time(t_1);
  const double now = internal_now + (rubs ? model.potential().yarn_loss(u_1) : 0.0);
  dynamics_.set_time(rubs ? t_1 - part : t_0);
  const double with_end = now - resisting(u_1);
  dynamics_.set_time(t_1);
  return 0.5 * (with_start + with_end) / fraction;
}

void EnergyAccount::end_step(Vec u_1, Vec v_1, double t_0, double t_1) {
  dynamics_.set_time(t_1);
  const Levels now = levels(u_1, v_1);
  const double prescribed = driven(u_1, t_0, t_1, now.internal);
  const double held = now.held - before_.held;
  const ForceWork& w = work_.model;
  const double part =
      now_.time > last_.time ? std::clamp((now_.time - 0.5 * (t_0 + t_1)) / (now_.time - last_.time), 0.0, 1.0) : 0.0;
  const double by_loads = part * (last_.load_work - now_.load_work),
               by_supports = part * (last_.reaction_work - now_.reaction_work);
  EnergyBalance step;
  step.loads = w.loads + by_loads;
  step.supports = work_.reactions + by_supports + prescribed + held;
  step.friction = friction_;
  step.obstacles = obstacles_ + friction_ - w.friction;
  step.damping = work_.damping + w.viscous;
  step.drag = work_.drag;
  step.fabric = dynamics_.model().potential().yarn_loss(u_1);
  step.numerical = by_loads + by_supports + work_.inertia + held - (now.kinetic - before_.kinetic) + w.internal +
                   prescribed - step.fabric - (now.internal - before_.internal) + w.contact + obstacles_ -
                   (now.contact - before_.contact);
  step.unaccounted = now.sum() - before_.sum() - (step.loads + step.supports + step.obstacles) + step.damping +
                     step.drag + step.friction + step.fabric + step.numerical;
  step.inflow = std::max(0.0, step.loads + step.supports + step.obstacles + std::max(0.0, -step.drag));
  const auto sums = members_of(balance_);
  const auto more = members_of(step);
  for (std::size_t i = 0; i < sums.size(); ++i) *sums[i] += *more[i];
  // Barriers that grow while a start settles are no fault of the scheme; along the step by no more than at one of its ends.
  if (Contact* contact = dynamics_.model().contact())
    balance_.most_taken -= std::max(contact->grown_since(start_, t_0), contact->grown_since(u_1, t_0));
  balance_.most_taken = std::max(balance_.most_taken, balance_.numerical);
  balance_.created = std::max(balance_.created, balance_.most_taken - balance_.numerical);
  balance_.kinetic = now.kinetic;
  balance_.stored = now.internal + now.contact;
  balance_.internal = now.internal;
  balance_.barriers = now.contact;
  before_ = now;
}

}  // namespace voile::system
