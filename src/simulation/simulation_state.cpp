// Fields, energies, saved states, what comes from outside, and PETSc's objects.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/mpi.hpp"
#include "base/text.hpp"
#include "record/linear_values.hpp"
#include "simulation_impl.hpp"
#include "system/contact.hpp"
#include "system/dynamics.hpp"
#include "voile/errors.hpp"

namespace voile {

namespace {

/// From rank 0 to all. Collective.
Field shared(MPI_Comm comm, const results::Field& own) {
  Field f{own.name, own.unit, own.centre == results::Centre::vertex, own.components, own.values};
  std::vector<double> numbers{f.on_vertices ? 1.0 : 0.0, static_cast<double>(f.components)};
  mpi::broadcast(comm, f.unit);
  mpi::broadcast(comm, numbers);
  mpi::broadcast(comm, f.values);
  f.on_vertices = numbers[0] > 0.0;
  f.components = static_cast<int>(numbers[1]);
  return f;
}

/// A vector that outlives its handle.
Vec given_away(const petsc::VecHandle& v) {
  VOILE_PETSC(PetscObjectReference(reinterpret_cast<PetscObject>(static_cast<Vec>(v))));
  return v;
}

}  // namespace

Field Simulation::field(const std::string& name) const {
  const Call call(*impl_);
  record::Recorder& recorder = impl_->run->stage().recorder();
  const std::vector<results::Field> found =
      recorder.fields(impl_->state(), [&](const std::string& one) { return one == name; });
  const auto at = std::find_if(found.begin(), found.end(), [&](const results::Field& f) { return f.name == name; });
  const bool is_root = mpi::rank(impl_->comm) == 0;
  if (mpi::max(impl_->comm, is_root && at == found.end() ? 1.0 : 0.0) > 0.0) {
    std::string text;
    const std::vector<results::Field> all = recorder.fields(impl_->state(), [](const std::string&) { return true; });
    mpi::on_root(impl_->comm, [&] {
      std::vector<std::string> names;
      for (const results::Field& f : all) names.push_back(f.name);
      throw UserError(fmt::format("there is no field '{}' in this analysis:{}", name, suggestion(name, names)));
    });
  }
  Field f = shared(impl_->comm, is_root ? *at : results::Field{});
  f.name = name;
  return f;
}

History Simulation::history() const {
  const Call call(*impl_);
  const record::Recorder::History& own = impl_->run->stage().recorder().history();
  std::string names = join(own.columns, "\n");
  std::vector<double> values;
  for (const std::vector<double>& row : own.rows) values.insert(values.end(), row.begin(), row.end());
  mpi::broadcast(impl_->comm, names);
  mpi::broadcast(impl_->comm, values);
  History all;
  for (std::size_t at = 0; at < names.size();) {
    const std::size_t end = std::min(names.find('\n', at), names.size());
    all.columns.push_back(names.substr(at, end - at));
    at = end + 1;
  }
  for (std::size_t at = 0; at < values.size(); at += all.columns.size())
    all.rows.emplace_back(values.begin() + static_cast<std::ptrdiff_t>(at),
                          values.begin() + static_cast<std::ptrdiff_t>(at + all.columns.size()));
  return all;
}

Energy Simulation::energy() const {
  const Call call(*impl_);
  system::Model& model = impl_->model();
  const system::State& state = impl_->state();
  const bool linear = impl_->run->stage().stage().c.analysis == input::Analysis::linear;
  const system::Energies e =
      linear ? record::LinearValues(model, state.u).energies() : system::energies(model, state.u);
  Energy all{e.membrane, e.bending, e.contact, e.springs, e.external};
  if (!impl_->epoch().dynamics()) all.bending += model.edge_energy();
  const double moment = system::short_moment * impl_->run->stage().stage().c.time.options.step;
  if (const system::Dynamics* dynamics = impl_->epoch().dynamics())
    all.kinetic = dynamics->kinetic_energy(state.v) + dynamics->kinetic_energy_of_held(state.v, moment);
  const system::EnergyBalance& b = state.balance;
  all.initial = b.initial;
  all.loads = b.loads;
  all.supports = b.supports;
  all.obstacles = b.obstacles;
  all.damping = b.damping;
  all.drag = b.drag;
  all.friction = b.friction;
  all.fabric = b.fabric;
  all.numerical = b.numerical;
  all.unaccounted = b.unaccounted;
  return all;
}

std::vector<double> Simulation::eigenvalues() const {
  const auto& ended = impl_->run->summaries();
  if (ended.empty() || ended.back().second.eigen.empty())
    throw UserError("there are no eigenvalues: call run(), of a case with analysis = \"modal\" or \"buckling\"");
  return ended.back().second.eigen;
}

// ---- coupling ----------------------------------------------------------------------------------------------------------

State Simulation::save() const {
  const Call call(*impl_);
  State s;
  s.time_ = time();
  s.data_ = std::make_shared<const State::Data>(State::Data{impl_->run->save(), impl_->identity});
  return s;
}

void Simulation::restore(const State& state) {
  const Call call(*impl_);
  if (!state.data_ || state.data_->identity != impl_->identity)
    throw UserError("the state was not saved by this simulation; save() and restore() belong to one and the same");
  impl_->run->restore(state.data_->saved);
  impl_->closed = impl_->stopped = false;
}

void Simulation::set_forces(const std::vector<double>& forces) {
  const Call call(*impl_);
  const std::size_t wanted = 3 * static_cast<std::size_t>(vertex_count());
  mpi::on_root(impl_->comm, [&] {
    if (!forces.empty() && forces.size() != wanted)
      throw UserError(fmt::format("set_forces: {} numbers are given; there are {} vertices, and each needs 3",
                                  forces.size(), vertex_count()));
    for (std::size_t i = 0; i < forces.size(); ++i)
      if (!std::isfinite(forces[i]))
        throw UserError(fmt::format("set_forces: the force on vertex {} is no number", i / 3));
  });
  impl_->run->stage().set_forces(mpi::rank(impl_->comm) == 0 ? forces : std::vector<double>{});
}

void Simulation::set_obstacle(const std::string& name, const std::vector<double>& positions, double t) {
  const Call call(*impl_);
  if (!impl_->moves()) throw UserError("set_obstacle() is for analysis = \"dynamic\": only there obstacles move");
  std::vector<double> values = positions;
  mpi::broadcast(impl_->comm, values);
  if (!std::isfinite(t)) throw UserError(fmt::format("obstacle '{}': the time is no number", name));
  if (values.size() % 3 != 0) throw UserError(fmt::format("obstacle '{}': each position needs 3 numbers", name));
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < values.size(); i += 3) points.emplace_back(values[i], values[i + 1], values[i + 2]);
  for (const Vec3& x : points)
    if (!x.allFinite()) throw UserError(fmt::format("obstacle '{}': a position is no number", name));
  impl_->run->obstacles()->set(name, std::move(points), time(), t);
}

std::vector<double> Simulation::obstacle(const std::string& name) const {
  std::vector<double> values;
  for (const Vec3& x : impl_->run->obstacles()->points(name, time())) values.insert(values.end(), x.begin(), x.end());
  return values;
}

// ---- PETSc's objects ---------------------------------------------------------------------------------------------------

void Simulation::Impl::require_unknowns(Vec x) const {
  PetscInt own = 0, wanted = 0;
  VOILE_PETSC(VecGetLocalSize(x, &own));
  VOILE_PETSC(VecGetLocalSize(state().u, &wanted));
  mpi::on_all(comm, [&] {
    if (own != wanted)
      throw UserError(
          fmt::format("the vector has {} entries on this rank, {} are needed; begin with unknowns()", own, wanted));
  });
}

Vec Simulation::unknowns() const {
  const Call call(*impl_);
  Vec x = nullptr;
  VOILE_PETSC(VecDuplicate(impl_->state().u, &x));
  VOILE_PETSC(VecCopy(impl_->state().u, x));
  return x;
}

Vec Simulation::residual(Vec x) const {
  const Call call(*impl_);
  impl_->require_unknowns(x);
  petsc::VecHandle r;
  VOILE_PETSC(VecDuplicate(impl_->state().u, r.out()));
  impl_->model().residual(x, r);
  return given_away(r);
}

Mat Simulation::tangent(Vec x) const {
  const Call call(*impl_);
  impl_->require_unknowns(x);
  system::TangentRequest request;
  request.exact_contact = true;
  if (impl_->model().conditions().has_gas())
    throw UserError(
        "Simulation::tangent: [[load]] type 'gas' couples all vertices, and its tangent is no sparse matrix; "
        "use residual()");
  impl_->model().assemble_tangent(x, request);
  Mat k = nullptr;
  VOILE_PETSC(MatDuplicate(impl_->model().tangent().matrix(), MAT_COPY_VALUES, &k));
  return k;
}

std::vector<double> Simulation::to_array(Vec x) const {
  const Call call(*impl_);
  impl_->require_unknowns(x);
  return impl_->gathered(x);
}

Vec Simulation::to_unknowns(const std::vector<double>& values) const {
  const Call call(*impl_);
  mpi::on_root(impl_->comm, [&] {
    if (values.size() != 3 * static_cast<std::size_t>(vertex_count()))
      throw UserError(
          fmt::format("{} numbers are given; there are {} vertices, and each needs 3", values.size(), vertex_count()));
  });
  if (!impl_->dofs().motions().empty())
    throw UserError("the unknowns of [[rigid]] groups do not follow from the displacements of their vertices");
  petsc::VecHandle x;
  VOILE_PETSC(VecDuplicate(impl_->state().u, x.out()));
  impl_->dofs().scatter(mpi::rank(impl_->comm) == 0 ? values : std::vector<double>{}, x);
  return given_away(x);
}

}  // namespace voile
