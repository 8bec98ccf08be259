#include "remesher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "adapt/transfer.hpp"
#include "base/mpi.hpp"
#include "carry.hpp"
#include "input/expression.hpp"
#include "new_mesh.hpp"
#include "setup/mesh_transfer.hpp"
#include "setup/obstacles.hpp"
#include "system/contact.hpp"
#include "transfer.hpp"
#include "voile/errors.hpp"

namespace voile::remesh {

namespace {

using adapt::Interpolation;

/// Looks that a run at most lets pass after a refusal, before it tries again.
constexpr int most_wait = 32;

bool is_zero(Vec v) {
  double largest = 0.0;
  VOILE_PETSC(VecNorm(v, NORM_INFINITY, &largest));
  return largest == 0.0;
}

}  // namespace

double cpu_clock() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Remesher::Remesher(const Stage& stage, std::shared_ptr<const mesh::SurfaceMesh> first)
    : stage_(stage), keys_(stage.c.remesh), first_(std::move(first)) {
  if (!first_->joints().empty())
    throw UserError(
        fmt::format("{}: [remesh]: the mesh joins sheets ({} edges of three or more triangles, of two that "
                    "cannot be oriented alike, or hinges), and a new mesh would lose them; remove the section",
                    stage_.c.file.string(), first_->joints().size()));
  std::vector<Index> curved{0};
  mpi::on_root(stage_.options.comm, [&] {
    rest_.emplace(*first_);
    curved[0] = rest_->curved();
    if (!keys_.size.empty()) bound_ = input::size_expression(keys_.size);
    if (!keys_.background.empty()) background_.emplace(stage_.c);
  });
  mpi::broadcast(stage_.options.comm, curved);
  curved_ = curved[0] != 0;
}

Remesher::NewMesh Remesher::make_mesh(Epoch& epoch, const std::vector<double>& size, bool only_splits) {
  const system::Dofs& dofs = epoch.model().dofs();
  const adapt::Limits limits = this->limits(epoch);
  const std::vector<double> u = dofs.gather(epoch.state().u);
  NewMesh made;
  mesh::MeshData data;
  mpi::on_root(dofs.comm(), [&] {
    made.places = dofs.mesh().positions();
    for (std::size_t v = 0; v < made.places.size(); ++v) made.places[v] += Eigen::Map<const Vec3>(&u[3 * v]);
    adapt::Options options;
    options.only_splits = only_splits;
    made.from = adapt::remesh(dofs.mesh(), *rest_, made.places, size, limits, options);
    data = made.from.mesh;
  });
  setup::broadcast_mesh(dofs.comm(), data);
  made.mesh = std::make_shared<const mesh::SurfaceMesh>(std::move(data));
  mpi::on_root(dofs.comm(), [&] {
    std::vector<double> new_size;
    for (const adapt::Remeshed::Source& s : made.from.source) {
      double h = 0.0;
      for (int i = 0; i < 3; ++i) h += s.weights[i] * size[dofs.mesh().triangles()[s.triangle][i]];
      new_size.push_back(h);
    }
    made.match = adapt::match(*made.mesh, new_size, changeable(*made.mesh, {}));
  });
  return made;
}

/// The state on the new mesh, on rank 0: smooth where contact lets it be, otherwise on the old surface. Displacements are
/// interpolated, not places: what is at rest stays at rest, whatever the shape there.
results::Checkpoint Remesher::carry_over(Epoch& epoch, const NewMesh& made) const {
  const system::Dofs& dofs = epoch.model().dofs();
  const mesh::SurfaceMesh& old_mesh = dofs.mesh();
  results::Checkpoint c = gather(epoch.state(), epoch.model());
  results::forget_stability(c);
  mpi::on_root(dofs.comm(), [&] {
    const adapt::Remeshed& from = made.from;
    const auto carry = [&](std::vector<double>& field, Interpolation kind) {
      if (!field.empty()) field = as_values(adapt::transfer(old_mesh, from, as_points(field), kind));
    };
    carry(c.displacement, Interpolation::smooth);
    carry(c.previous, Interpolation::smooth);
    carry(c.velocity, Interpolation::smoother);
    carry(c.acceleration, Interpolation::smoother);
    for (std::size_t v = 0; v < from.clearance.size(); ++v) {
      Eigen::Map<Vec3> u(&c.displacement[3 * v]);
      const Vec3& rest = from.mesh.positions[v];
      if ((rest + u - from.places[v]).norm() > from.clearance[v]) u = from.places[v] - rest;
    }
  });
  return c;
}

/// What intersects, by exact predicates, and where; empty if nothing does. The same on every rank. Collective.
std::string Remesher::intersections(Epoch& epoch) {
  const system::Contact& contact = *epoch.model().contact();
  const std::vector<Vec3> positions = contact.scene().positions(epoch.state().u);
  const setup::IntersectionCheck check(contact);
  const std::vector<geometry::TrianglePair> pairs = check.find_by_ranks(positions);
  std::string text;
  mpi::on_root(epoch.model().dofs().comm(), [&] {
    if (!pairs.empty()) text = check.report(positions, pairs, {});
  });
  mpi::broadcast(epoch.model().dofs().comm(), text);
  return text;
}

void Remesher::write(const Epoch& epoch, const NewMesh& made, const Ledger& before, const Ledger& after, bool accepted,
                     double seconds) {
  if (stage_.options.output.empty()) return;
  const system::State& s = epoch.state();
  const adapt::Remeshed& m = made.from;
  const auto number = [](auto value) { return static_cast<double>(value); };
  const std::vector<std::pair<std::string, double>> columns{
      {"step", number(s.step)},
      {"time", s.time},
      {"load_factor", s.load_factor},
      {"accepted", accepted ? 1.0 : 0.0},
      {"vertices_before", number(epoch.model().dofs().mesh().vertex_count())},
      {"vertices", number(made.mesh->vertex_count())},
      {"kept", number(std::count_if(m.kept.begin(), m.kept.end(), [](Index v) { return v != no_index; }))},
      {"splits", number(m.counts.splits)},
      {"collapses", number(m.counts.collapses)},
      {"flips", number(m.counts.flips)},
      {"smoothed", number(m.counts.smoothed)},
      {"refused_by_clearance", number(m.counts.refused_by_clearance)},
      {"smallest_angle", m.quality.smallest_angle * 180.0 / std::numbers::pi},
      {"ill_conditioned", number(m.quality.ill_conditioned)},
      {"wanted_smallest", made.match.smallest},
      {"wanted_largest", made.match.largest},
      {"ratio_1", made.match.p1},
      {"ratio_50", made.match.p50},
      {"ratio_99", made.match.p99},
      {"membrane_before", before.energies.membrane},
      {"membrane", after.energies.membrane},
      {"bending_before", before.energies.bending},
      {"bending", after.energies.bending},
      {"contact_before", before.energies.contact},
      {"contact", after.energies.contact},
      {"kinetic_before", before.kinetic},
      {"kinetic", after.kinetic},
      {"mass_before", before.mass},
      {"mass", after.mass},
      {"momentum_change", (after.momentum - before.momentum).norm()},
      {"angular_change", (after.angular - before.angular).norm()},
      {"velocity_factor", velocity_factor_},
      {"cpu_seconds", seconds},
  };
  std::vector<std::string> names;
  std::vector<double> values;
  for (const auto& [name, value] : columns) {
    names.push_back(name);
    values.push_back(value);
  }
  if (!table_) table_.emplace(stage_.options.output / "remeshing.csv", names);
  table_->write(values);
}

record::RemeshingEffort Remesher::effort() const {
  const double all = cpu_clock() - begin_;
  return {count_, refused_, attempts_, seconds_, all > 0.0 ? seconds_ / all : 0.0};
}

std::string text_of(const record::RemeshingEffort& e) {
  if (e.count + e.refused == 0) return "";
  return fmt::format("{} remeshings, {} refused, {:.1f} CPU s of rank 0, {:.2g} % of its time", e.count, e.refused,
                     e.seconds, 100.0 * e.fraction);
}

namespace {

std::string text_of(const adapt::SizeMatch& m, Index before, Index after, std::ptrdiff_t kept, double energy_change) {
  return fmt::format(
      "remeshed: {} vertices became {}, {:.0f} % of them kept; edges {:.2f}, {:.2f}, {:.2f} of {:.3g} to {:.3g} m (1, "
      "50, 99 %); energy {:+.2g} %",
      before, after, 100.0 * static_cast<double>(kept) / after, m.p1, m.p50, m.p99, m.smallest, m.largest,
      100.0 * energy_change);
}

/// Of a path, to the step before; else none. Collective.
petsc::VecHandle direction_of(const system::State& state) {
  if (!state.previous) return {};
  petsc::VecHandle direction;
  VOILE_PETSC(VecDuplicate(state.u, direction.out()));
  VOILE_PETSC(VecWAXPY(direction, -1.0, state.u, state.previous));
  return direction;
}

std::string text_of_change(double change, const Ledger& before, const Ledger& after) {
  return fmt::format(
      "the energy would change by {:+.2g} % of {:.2g} J, more than remesh.energy_change; if the present mesh is too "
      "coarse for its shape, begin with a finer one or raise that key",
      100.0 * change, std::max(std::abs(before.total()), std::abs(after.total())));
}

}  // namespace

/// One new mesh with its state; `what` says what it came to.
std::optional<RemeshResult> Remesher::attempt(Epoch& epoch, const std::vector<double>& size, bool only_splits,
                                              std::string& what) {
  const MPI_Comm comm = epoch.model().dofs().comm();
  const double begin = cpu_clock();
  ++attempts_;
  NewMesh made = make_mesh(epoch, size, only_splits);
  // An epoch needs a vertex on every rank.
  if (made.mesh->vertex_count() < mpi::size(comm)) return what = "it has fewer vertices than ranks", std::nullopt;
  results::Checkpoint carried = carry_over(epoch, made);
  const Origins origins = origins_of(comm, made.from);
  carry_contact(epoch.model().dofs().mesh(), origins, carried);
  carry_anchors(epoch.model(), *made.mesh, origins, carried);
  mpi::on_root(comm, [&] { carry_slips(epoch.model().dofs().mesh(), *made.mesh, made.from, carried); });
  const Ledger before = ledger(epoch);

  RemeshResult next{made.mesh,
                    std::make_unique<Epoch>(comm, stage_.c, *made.mesh, stage_.input, stage_.frozen, carried)};
  Epoch& fresh = *next.epoch;
  std::vector<double> left{made.match.too_long, made.match.too_short};
  mpi::broadcast(comm, left);
  fresh.state().remeshings = {epoch.state().remeshings.count + 1, left[0], left[1]};
  fresh.prepare(Origin::mesh);
  // Nothing has moved yet: Newton's method would be asked to improve on round-off.
  const bool at_rest = epoch.state().in_equilibrium && is_zero(epoch.state().u);
  const petsc::VecHandle direction = direction_of(fresh.state());
  double change = 0.0;
  const bool found = !at_rest && find_equilibrium_nearby(fresh);
  if (!at_rest && !found) {
    change = settle(epoch, fresh, before, made);
  } else if (fresh.state().v) {
    keep_momentum(epoch, fresh, before);
    change = energy_change(before, ledger(fresh), fresh);
  }
  bool accepted = true;
  if (fresh.model().contact() && stage_.c.contact.check) {
    const std::string pairs = intersections(fresh);
    accepted = pairs.empty();
    if (!accepted) what = fmt::format("the new surface would intersect: {}", pairs);
  }
  const bool is_path = stage_.c.analysis == input::Analysis::statics;
  if (is_path && !at_rest && !found) accepted = accepted && find_equilibrium(epoch, fresh, what);
  // Potentials are compared under the same loads.
  if (is_path) fresh.model().conditions().set_load_factor(epoch.state().load_factor);
  if (direction) VOILE_PETSC(VecWAXPY(fresh.state().previous, 1.0, direction, fresh.state().u));
  fresh.model().potential().end_step(fresh.state().u);  // what slips on the way there is part of the remeshing
  const Ledger after = ledger(fresh);
  if (is_path) fresh.model().conditions().set_load_factor(fresh.state().load_factor);
  if (is_path) change = energy_change(before, after, fresh);
  // Paths and draping go on to an equilibrium: less energy is what a finer mesh is for. A motion must neither gain nor
  // lose any.
  if (accepted && (stage_.c.analysis == input::Analysis::dynamic ? std::abs(change) : change) > keys_.energy_change) {
    what = text_of_change(change, before, after);
    accepted = false;
  }
  mpi::on_root(comm, [&] { write(epoch, made, before, after, accepted, cpu_clock() - begin); });
  if (!accepted) return std::nullopt;
  const auto same = std::count_if(origins.kept.begin(), origins.kept.end(), [](Index v) { return v != no_index; });
  what = text_of(made.match, epoch.model().dofs().mesh().vertex_count(), made.mesh->vertex_count(), same, change);
  if (velocity_factor_ != 1.0) what += fmt::format(", velocities {:+.2g} %", 100.0 * (velocity_factor_ - 1.0));
  return next;
}

std::optional<RemeshResult> Remesher::adapt(Epoch& epoch, const std::function<void(const std::string&)>& remark) {
  const petsc::EventScope scope(petsc::events().remesh);
  const double begin = cpu_clock();
  std::string what;
  std::optional<RemeshResult> next = attempt(epoch, size_, false, what);
  // Splits leave the surface as it is.
  if (!next && epoch.model().contact()) {
    remark(fmt::format("{}; trying splits only", what));
    next = attempt(epoch, size_, true, what);
  }
  seconds_ += cpu_clock() - begin;
  if (next) {
    ++count_;
    remark(what);
    return next;
  }
  ++refused_;
  system::Remeshings& asked = epoch.state().remeshings;
  asked.wait = std::min(std::max(2 * asked.wait, 1), most_wait);
  asked.next_step = epoch.state().step + asked.wait * every();
  remark(fmt::format("remeshing refused: {}; the run continues with its present mesh", what));
  return std::nullopt;
}

}  // namespace voile::remesh
