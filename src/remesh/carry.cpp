#include "carry.hpp"

#include <array>

#include "base/mpi.hpp"
#include "system/contact.hpp"
#include "system/rigid_places.hpp"
#include "voile/errors.hpp"

namespace voile::remesh {

namespace {

void take_bodies(const results::Checkpoint& c, const system::Dofs& dofs, const system::State& s) {
  const std::size_t each = dofs.body_unknowns();
  if (each == 0) return;
  const double found = mpi::max(dofs.comm(), static_cast<double>(c.bodies.size()));
  const bool begins = mpi::max(dofs.comm(), c.displacement.empty() ? 0.0 : 1.0) == 0.0;
  const double places = mpi::max(dofs.comm(), static_cast<double>(c.places.size()));
  if (!begins && found == 0.0 && places == static_cast<double>(system::rigid_place_numbers * dofs.bodies().size())) {
    // The next stage
    if (s.v) dofs.scatter_bodies(system::rates_at(c.places, dofs.bodies()), s.v);
    return;
  }
  // Older files have no velocities one step before.
  if (!begins && found != static_cast<double>(4 * each) && found != static_cast<double>(5 * each))
    throw UserError("the state to continue from has other [[rigid]] groups than the case, or none; give the same ones");
  if (begins) {  // with the velocities that the case gives
    std::vector<double> rates;
    if (!c.velocity.empty()) rates = dofs.body_rates(c.velocity);
    if (s.v) dofs.scatter_bodies(rates, s.v);
    return;
  }
  const std::array<Vec, 5> vectors = system::rigid_vectors(s);
  for (std::size_t k = 0; static_cast<double>((k + 1) * each) <= found; ++k) {
    std::vector<double> own;
    if (!c.bodies.empty()) own.assign(&c.bodies[k * each], &c.bodies[k * each] + each);
    if (vectors[k]) dofs.scatter_bodies(own, vectors[k]);
  }
}

}  // namespace

results::Checkpoint gather(const system::State& s, const system::Model& model) {
  const auto values = [&](Vec v) { return v ? model.dofs().gather(v) : std::vector<double>{}; };
  const auto changes = [&](Vec v) { return v ? model.dofs().gather_change(v) : std::vector<double>{}; };
  results::Checkpoint c;
  c.step = s.step;
  c.time = s.time;
  c.next_step = s.next_step;
  c.load_factor = s.load_factor;
  c.in_equilibrium = s.in_equilibrium;
  c.displacement = values(s.u);
  c.velocity = changes(s.v);
  c.acceleration = changes(s.a);
  c.previous = values(s.previous);
  c.stiffest = changes(s.stiffest);
  c.stability = system::numbers_of(s.stability);
  if (!model.dofs().motions().empty()) {
    c.bodies = system::rigid_unknowns(model.dofs(), s);
    c.places = system::rigid_places(model.discretisation(), s.u, s.v);
  }
  c.contact_gaps = s.contact.gaps;
  c.contact_start = s.contact.start;
  c.passing = s.contact.passing;
  c.anchors = system::numbers_of(s.anchors);
  c.energy_balance = system::numbers_of(s.balance);
  c.path = system::numbers_of(s.path);
  c.remeshings = s.remeshings.count;
  c.too_long = s.remeshings.too_long;
  c.too_short = s.remeshings.too_short;
  c.remeshing_wait = s.remeshings.wait;
  c.remeshing_step = s.remeshings.next_step;
  c.positive_tangents = s.solver.positive_tangents;
  c.factors_left = s.solver.factors_left;
  c.wait = s.solver.wait;
  c.slips = model.potential().slips();
  c.leaks = model.conditions().leaks();
  return c;
}

results::Checkpoint gather_end(const system::State& s, const system::Model& model) {
  results::Checkpoint c = gather(s, model);
  if (system::Contact* contact = model.contact()) c.contact_push = contact->push(s.u);
  return c;
}

results::Checkpoint gather_whole(const system::State& s, const system::Model& model) {
  results::Checkpoint c = gather(s, model);
  c.couplings = model.couplings();
  if (!s.last.u) return c;
  c.previous = model.dofs().gather(s.last.u);
  c.previous_velocity = model.dofs().gather_change(s.last.v);
  c.step_start = {s.last.time, s.last.size};
  return c;
}

system::State scatter(const results::Checkpoint& c, const system::Dofs& dofs) {
  system::State s;
  s.step = c.step;
  s.time = c.time;
  s.next_step = c.next_step;
  s.load_factor = c.load_factor;
  s.in_equilibrium = c.in_equilibrium;
  s.contact = {c.contact_gaps, c.contact_start, c.contact_push, c.passing};
  s.anchors = system::anchors_of(c.anchors);
  s.balance = system::balance_of(c.energy_balance);
  s.path = system::path_of(c.path);
  s.stability = system::stability_of(c.stability);
  s.remeshings = {c.remeshings, c.too_long, c.too_short, c.remeshing_wait, c.remeshing_step};
  s.solver = {c.positive_tangents, c.factors_left, c.wait};
  s.u = dofs.create_vector();
  const auto take = [&](const std::vector<double>& values, petsc::VecHandle& to) {
    if (mpi::max(dofs.comm(), values.empty() ? 0.0 : 1.0) == 0.0) return;
    if (!to) to = dofs.create_vector();
    dofs.scatter(values, to);
  };
  take(c.displacement, s.u);
  take(c.velocity, s.v);
  take(c.acceleration, s.a);
  const bool in_motion = c.step_start.size() == 2;
  take(c.previous, in_motion ? s.last.u : s.previous);
  if (in_motion) {
    take(c.previous_velocity, s.last.v);
    s.last.time = c.step_start[0];
    s.last.size = c.step_start[1];
    if (!s.last.u || !s.last.v) s.last = {};
  }
  take(c.stiffest, s.stiffest);
  take_bodies(c, dofs, s);
  return s;
}

Checkpoints::Checkpoints(const input::Case& c, const std::filesystem::path& folder)
    : every_(c.analysis == input::Analysis::dynamic ? c.time.checkpoint_steps : 0),
      minutes_(c.time.checkpoint_minutes),
      file_(folder.empty() ? folder : folder / "checkpoint.h5") {}

void Checkpoints::after_step(const system::State& s, const system::Model& model, bool asked) {
  if (file_.empty()) return;
  const double minutes = std::chrono::duration<double>(Clock::now() - last_).count() / 60.0;
  const bool by_time = minutes_ > 0.0 && minutes >= minutes_;
  const bool by_step = every_ > 0 && s.step % every_ == 0;
  const bool due = mpi::max(model.dofs().comm(), by_time ? 1.0 : 0.0) > 0.0;  // clocks differ between ranks
  if (due || by_step || asked) write(s, model);
}

void Checkpoints::write(const system::State& s, const system::Model& model, bool at_end) {
  if (file_.empty()) return;
  results::Checkpoint c = gather_whole(s, model);
  if (at_end && model.contact()) c.contact_push = model.contact()->push(s.u);
  mpi::on_root(model.dofs().comm(), [&] { results::write_checkpoint(file_, c, model.dofs().mesh()); });
  last_ = Clock::now();
}

}  // namespace voile::remesh
