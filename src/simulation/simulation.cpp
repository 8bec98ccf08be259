#include "voile/simulation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "base/mpi.hpp"
#include "simulation_impl.hpp"
#include "system/dynamics.hpp"
#include "voile/errors.hpp"

namespace voile {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

record::RunOptions run_options(MPI_Comm comm, const Options& options) {
  record::RunOptions o;
  o.comm = comm;
  o.output = options.output;
  o.overwrite = options.overwrite;
  o.verbosity = options.verbose ? record::Verbosity::normal : record::Verbosity::quiet;
  o.keep_history = true;
  o.obstacles = std::make_shared<setup::DrivenObstacles>();
  return o;
}

void require_petsc() {
  PetscBool begun = PETSC_FALSE;
  (void)PetscInitialized(&begun);
  if (!begun || petsc_has_ended())
    throw UserError(
        "PETSc is not running; create a voile::Session first, and keep it as long as there are simulations");
}

}  // namespace

Simulation::Impl::Impl(MPI_Comm on, const Case& given, Options o)
    : comm(on),
      options(std::move(o)),
      input(input::parse_case(given.source(), given.file(), given.settings())),
      petsc(input.petsc_options, options.petsc) {
  const Call call(*this);
  run = std::make_unique<simulation::CaseRun>(input, run_options(comm, options));
  if (run->finished() && !input.finds_modes()) close();  // forces from outside may come before modes are found
}

Simulation::Impl::~Impl() {
  if (petsc_has_ended()) (void)run.release();  // its objects cannot be destroyed any longer
}

/// What is written is completed as soon as there is nothing more to come.
void Simulation::Impl::close() {
  if (options.output.empty() || closed) return;
  closed = true;
  (void)run->finish();
}

Step Simulation::Impl::step(double until) {
  (void)run->stage();
  if (run->finished())
    throw UserError(fmt::format(
        "the simulation has come to its end at {}{}; build another one, or restore a saved state",
        moves() ? fmt::format("t = {:g} s", state().time) : fmt::format("load factor {:g}", state().load_factor),
        reason().empty() ? "" : ": " + reason()));
  const auto before = run->stage().mesh();
  const solve::StepResult r = run->advance(until);
  if (run->finished()) close();
  Step s;
  s.accepted = r.outcome == solve::Outcome::accepted;
  s.number = state().step;
  s.time = state().time;
  s.load_factor = state().load_factor;
  s.size = r.taken;
  s.iterations = r.newton_iterations;
  s.rejections = r.rejections;
  s.new_mesh = run->stage().mesh() != before;
  if (s.accepted)
    for (const auto& look : observers) look(s);
  return s;
}

std::string Simulation::Impl::reason() const {
  const auto& ended = run->summaries();
  if (!ended.empty() && !ended.back().second.converged) return ended.back().second.reason;
  if (!run->finished()) return "";
  if (run->outcome() == Exit::unstable) return "the last state is an unstable equilibrium";
  return run->stage().all().reason;
}

std::vector<double> Simulation::Impl::gathered(Vec v, bool is_change) const {
  std::vector<double> values = v ? (is_change ? dofs().gather_change(v) : dofs().gather(v))
                                 : std::vector<double>(3 * static_cast<std::size_t>(dofs().mesh().vertex_count()), 0.0);
  mpi::broadcast(comm, values);
  return values;
}

Simulation::Simulation(MPI_Comm comm, const Case& c, Options options) {
  require_petsc();
  impl_ = std::make_unique<Impl>(comm, c, std::move(options));
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

// ---- steps -----------------------------------------------------------------------------------------------------------

Step Simulation::advance() {
  const Call call(*impl_);
  return impl_->take_steps([&] { return impl_->step(no_limit); });
}

bool Simulation::advance_to(double t) {
  const Call call(*impl_);
  if (!impl_->moves()) throw UserError("advance_to() is for analysis = \"dynamic\"; use advance()");
  if (std::isnan(t)) throw UserError("advance_to(): t is not a number");
  if (t < time())
    throw UserError(
        fmt::format("advance_to({:g} s): that is before the present, t = {:g} s; restore() goes back", t, time()));
  return impl_->take_steps([&] {
    while (time() < t && !finished()) (void)impl_->step(t);
    return time() >= t;
  });
}

bool Simulation::run() {
  const Call call(*impl_);
  (void)impl_->run->stage();
  return impl_->take_steps([&] {
    while (!finished()) (void)impl_->step(no_limit);
    if (!std::exchange(impl_->closed, true)) (void)impl_->run->finish();
    return converged();
  });
}

bool Simulation::finished() const {
  return impl_->run->finished();
}

bool Simulation::converged() const {
  (void)impl_->run->stage();
  return finished() && impl_->run->outcome() == Exit::done;
}

std::string Simulation::reason() const {
  return impl_->reason();
}

bool Simulation::interrupted() const {
  return impl_->stopped;
}

void Simulation::observe(std::function<void(const Step&)> look) {
  impl_->observers.push_back(std::move(look));
}

// ---- the present state -------------------------------------------------------------------------------------------------

double Simulation::time() const {
  return impl_->state().time;
}

double Simulation::load_factor() const {
  return impl_->state().load_factor;
}

int Simulation::step() const {
  return impl_->state().step;
}

int Simulation::vertex_count() const {
  return impl_->dofs().mesh().vertex_count();
}

int Simulation::triangle_count() const {
  return impl_->dofs().mesh().triangle_count();
}

std::vector<int> Simulation::triangles() const {
  std::vector<int> all;
  for (const mesh::Triangle& t : impl_->dofs().mesh().triangles()) all.insert(all.end(), t.begin(), t.end());
  return all;
}

std::vector<int> Simulation::group(const std::string& name) const {
  const auto& vertices = impl_->dofs().mesh().group(name).vertices;
  return {vertices.begin(), vertices.end()};
}

std::vector<double> Simulation::displacements() const {
  const Call call(*impl_);
  return impl_->gathered(impl_->state().u);
}

std::vector<double> Simulation::positions() const {
  std::vector<double> x = displacements();
  const std::vector<Vec3>& start = impl_->dofs().mesh().positions();
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += start[i / 3][static_cast<Eigen::Index>(i % 3)];
  return x;
}

std::vector<double> Simulation::velocities() const {
  const Call call(*impl_);
  return impl_->gathered(impl_->state().v, true);
}

}  // namespace voile
