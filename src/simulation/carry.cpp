#include "carry.hpp"

#include "base/mpi.hpp"
#include "system/contact.hpp"

namespace voile::simulation {

io::Checkpoint gather(const system::State& s, const system::Model& model) {
  const auto values = [&](Vec v) { return v ? model.dofs().gather(v) : std::vector<double>{}; };
  io::Checkpoint c;
  c.step = s.step;
  c.time = s.time;
  c.next_step = s.next_step;
  c.load_factor = s.load_factor;
  c.in_equilibrium = s.in_equilibrium;
  c.displacement = values(s.u);
  c.velocity = values(s.v);
  c.acceleration = values(s.a);
  c.previous = values(s.previous);
  c.contact_gaps = s.contact.gaps;
  c.contact_start = s.contact.start;
  c.yielding = s.contact.yielding;
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
  return c;
}

system::State scatter(const io::Checkpoint& c, const system::Dofs& dofs) {
  system::State s;
  s.step = c.step;
  s.time = c.time;
  s.next_step = c.next_step;
  s.load_factor = c.load_factor;
  s.in_equilibrium = c.in_equilibrium;
  s.contact = {c.contact_gaps, c.contact_start, c.yielding};
  s.anchors = system::anchors_of(c.anchors);
  s.balance = system::balance_of(c.energy_balance);
  s.path = system::path_of(c.path);
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
  take(c.previous, s.previous);
  return s;
}

Checkpoints::Checkpoints(const input::Case& c, const std::filesystem::path& folder)
    : every_(c.analysis == "dynamic" ? c.time.checkpoint_steps : 0),
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

void Checkpoints::write(const system::State& s, const system::Model& model) {
  if (file_.empty()) return;
  io::Checkpoint c = gather(s, model);
  c.couplings = model.couplings();
  mpi::on_root(model.dofs().comm(), [&] { io::write_checkpoint(file_, c, model.dofs().mesh()); });
  last_ = Clock::now();
}

}  // namespace voile::simulation
