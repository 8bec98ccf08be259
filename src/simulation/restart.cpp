#include "restart.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/mpi.hpp"
#include "formats/mesh_file.hpp"
#include "input/case_differences.hpp"
#include "remesh/remesher.hpp"
#include "results/stored_step.hpp"
#include "setup/group_names.hpp"
#include "setup/mesh_transfer.hpp"
#include "system/rigid_places.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

/// Of results that lack something which a checkpoint has.
std::string what_helps(const record::RunOptions& options) {
  std::error_code ignored;
  return std::filesystem::exists(options.restart.parent_path() / "checkpoint.h5", ignored)
             ? "restart from the checkpoint.h5 beside them"
             : "their run has left no checkpoint.h5 (time.checkpoint_minutes), so begin anew";
}

/// A record that makes no sense, as of a damaged file, is left: the path then has its last two states.
void take_path(const std::vector<double>& record, results::Checkpoint& c) {
  const bool good = std::all_of(record.begin(), record.end(), [](double x) { return std::abs(x) < 1e12; });
  if (record.size() != system::path_record_numbers || !good || !(record.front() > 0.0)) return;
  c.next_step = record.front();
  if (record[2] != 0.0) c.path.assign(record.begin() + 1, record.end());  // the unit of its length
}

/// What --restart names. Rank 0 only.
results::Checkpoint read_any(const input::Case& wanted, const record::RunOptions& options,
                             const mesh::SurfaceMesh& mesh) {
  if (!results::is_results(options.restart)) return results::read_checkpoint(options.restart, mesh);
  if (std::any_of(wanted.materials.begin(), wanted.materials.end(),
                  [](const energy::Material& m) { return !m.friction.sliders.empty() || m.yarns.rubs(); }))
    throw UserError(fmt::format("--restart {}: results do not hold the slips of friction inside the fabric; {}",
                                options.restart.string(), what_helps(options)));
  if (std::any_of(wanted.loads.begin(), wanted.loads.end(), [](const auto& load) { return load.leak_area > 0.0; }))
    throw UserError(fmt::format("--restart {}: results do not hold what is left of a gas that leaks; {}",
                                options.restart.string(), what_helps(options)));
  if (!wanted.attachments.empty())
    throw UserError(
        fmt::format("--restart {}: results do not hold where the places of an [[attachment]] are on their obstacle; {}",
                    options.restart.string(), what_helps(options)));
  results::StoredStep stored = results::read_step(options.restart, options.restart_step, mesh);
  const bool shape_only = stored.in_motion && stored.velocity.empty();
  // A motion would begin anew at time 0, and what moves jump back to where it was then.
  if (shape_only && wanted.analysis == input::Analysis::dynamic)
    throw UserError(
        fmt::format("--restart {}: its step {} is of a motion, but `velocity` is not among the fields; use a "
                    "checkpoint.h5, or results of a run with `velocity` in [output] fields",
                    options.restart.string(), stored.step));
  results::Checkpoint c;
  c.step = shape_only ? 0 : stored.step;
  c.load_factor = stored.load_factor;
  take_path(stored.path, c);
  system::take_rigid_record(stored.bodies, c.bodies, c.places);
  c.displacement = std::move(stored.displacement);
  // A path under load control needs the very step before, one along an arc a direction.
  if (!shape_only && (stored.has_last || wanted.steps.control != solve::StaticOptions::Control::load))
    c.previous = std::move(stored.previous);
  c.in_equilibrium = !stored.in_motion;
  c.time = stored.time;
  c.velocity = std::move(stored.velocity);
  return c;
}

/// Throws UserError if a state cannot be one of this mesh: what overflows later would be blamed on the solver.
void check_size(const record::RunOptions& options, const results::Checkpoint& s, const mesh::SurfaceMesh& mesh) {
  constexpr double most = 1e6;          // displacements by the size of the mesh
  constexpr double most_per_s = 1e12;   // velocities
  constexpr double most_per_s2 = 1e18;  // accelerations
  const auto check = [&](const char* name, const char* unit, const std::vector<double>& values, double factor) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!(std::abs(values[i]) <= factor * mesh.extent()))
        throw UserError(
            fmt::format("--restart {}: the {} of vertex {} is {:.3g} {}, larger than any of a mesh of {:.3g} m can be; "
                        "use another step or checkpoint",
                        options.restart.string(), name, i / 3, values[i], unit, mesh.extent()));
  };
  check("displacement", "m", s.displacement, most);
  check("displacement", "m", s.previous, most);
  check("velocity", "m/s", s.previous_velocity, most_per_s);
  check("velocity", "m/s", s.velocity, most_per_s);
  check("acceleration", "m/s^2", s.acceleration, most_per_s2);
}

/// What of a state the analysis goes on with. Rank 0 only.
void begin_anew(const input::Case& c, results::Checkpoint& s) {
  const bool moves = !s.velocity.empty(), in_time = c.analysis == input::Analysis::dynamic;
  if (moves != in_time) {
    s.step = s.remeshing_wait = s.remeshing_step = 0;
    s.time = s.next_step = 0.0;
    s.positive_tangents = s.factors_left = s.wait = 0;
    s.acceleration.clear();
    results::forget_stability(s);
    s.velocity.clear();
    s.energy_balance.clear();
  }
  if (moves != in_time) s.step_start.clear();
  if (s.step_start.empty() && (moves || in_time || c.analysis == input::Analysis::drape)) s.previous.clear();
  if (s.previous.empty()) s.path.clear();
  if (!s.path.empty()) s.path.front() = 0.0;  // `max_steps` counts anew
  if (c.analysis != input::Analysis::drape) return;
  s.step = s.remeshing_wait = s.remeshing_step = 0;
  s.load_factor = 0.0;
}

/// What a restart, or a stage that begins a run, takes over silently otherwise. Rank 0 only.
void say_differences(const input::Case& c, const record::RunOptions& options) {
  const std::filesystem::path folder = options.restart.parent_path();
  const std::string from = options.from.empty() ? "--restart " + options.restart.string()
                                                : fmt::format("--from {}: {}", options.from, folder.string());
  for (const input::SectionDifference& d : input::different_sections(c, folder / "resolved_case.toml")) {
    if (d.section == "units")
      throw UserError(
          fmt::format("{}: its run had another {}; its numbers are in those units, so give the case the same [units]",
                      from, d.text));
    if (options.verbosity != record::Verbosity::quiet) fmt::print("note: {}: its run had another {}\n", from, d.text);
  }
}

/// What a restart does a little differently. Rank 0 only.
void say_doubts(const input::Case& c, const record::RunOptions& options, const results::Checkpoint& s) {
  if (options.verbosity == record::Verbosity::quiet) return;
  if (c.analysis == input::Analysis::drape && !s.in_equilibrium)
    fmt::print(
        "note: --restart {}: a drape searches anew from the shape it has come to; of several equilibria it may find "
        "another than the unbroken run\n",
        options.restart.string());
  if (c.analysis == input::Analysis::dynamic && results::is_results(options.restart) && !s.velocity.empty())
    fmt::print(
        "note: --restart {}: results have no accelerations, so that the motion goes on a little differently; "
        "checkpoint.h5 has "
        "them\n",
        options.restart.string());
}

/// A motion that has gone beyond its end would be taken for what the end asks for.
void require_time_left(const input::Case& c, const record::RunOptions& options, double time) {
  const double end = c.time.options.end_time;
  if (c.analysis == input::Analysis::dynamic && time > end * (1.0 + 1e-9))
    throw UserError(
        fmt::format("--restart {}: it is at t = {:.6g} s, after the end of the motion, time.end = {:.6g} s; give a "
                    "later end, or an earlier step of results by --restart-step",
                    options.restart.string(), time, end));
}

/// v + omega x (x - c) at the vertices of each group; where groups overlap the last one counts. Rank 0 only.
std::vector<double> initial_velocities(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<double> velocity;
  if (c.initial_velocities.empty()) return velocity;
  velocity.resize(3 * static_cast<std::size_t>(mesh.vertex_count()), 0.0);
  const auto set = [&](const input::InitialVelocity& given, Index v) {
    const Vec3 at = given.velocity + given.angular_velocity.cross(mesh.positions()[v] - given.centre);
    Eigen::Map<Vec3>(velocity.data() + 3 * static_cast<std::size_t>(v)) = at;
  };
  for (const input::InitialVelocity& given : c.initial_velocities) {
    if (given.group.empty())
      for (Index v = 0; v < mesh.vertex_count(); ++v) set(given, v);
    else
      for (const Index v : mesh.group(given.group).vertices) set(given, v);
  }
  return velocity;
}

/// The vertices of a triangle whichever way it goes round.
mesh::Triangle ascending(mesh::Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// Rank 0 only.
std::vector<double> read_shape(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  const mesh::MeshData start = formats::read_mesh(c.mesh.start.string(), c.mesh.options);
  const auto other = [&](const std::string& what) {
    return UserError(
        fmt::format("{}: [mesh] start: {}; a start has the same vertices and triangles, in the same order, "
                    "as {}",
                    c.mesh.start.string(), what, c.mesh.file.string()));
  };
  const auto& rest = mesh.positions();
  if (start.positions.size() != rest.size() || start.triangles.size() != mesh.triangles().size())
    throw other(fmt::format("{} vertices and {} triangles instead of {} and {}", start.positions.size(),
                            start.triangles.size(), rest.size(), mesh.triangles().size()));
  for (std::size_t t = 0; t < start.triangles.size(); ++t)
    if (ascending(start.triangles[t]) != ascending(mesh.triangles()[t]))
      throw other(fmt::format("its triangle {} joins other vertices", t + 1));
  std::vector<double> u;
  for (std::size_t v = 0; v < rest.size(); ++v)
    for (int k = 0; k < 3; ++k) u.push_back(start.positions[v][k] - rest[v][k]);
  return u;
}

/// The mesh of what --restart names; empty if it is `first` or has to be. Rank 0 only.
mesh::MeshData stored_mesh(const input::Case& c, const record::RunOptions& options, const mesh::SurfaceMesh& first) {
  if (!results::is_results(options.restart)) return results::read_checkpoint_mesh(options.restart);
  // Without remeshing another mesh is a mistake, unless it was remeshing that made it.
  if (!c.remesh.active && c.panels.empty() && !results::is_remeshed(options.restart, options.restart_step)) return {};
  mesh::MeshData stored = results::read_step_mesh(options.restart, options.restart_step);
  const bool is_first = stored.triangles == first.triangles() && stored.positions == first.positions();
  return is_first ? mesh::MeshData{} : stored;
}

/// Whether something moves the sheet at load factor 0.
bool acts_at_once(const input::Case& c) {
  const auto constant = [](const auto& acting) { return acting.constant; };
  const auto strained = [](const energy::Material& m) {
    return !m.prestress.isZero(0.0) || !m.initial_strain.isZero(0.0);
  };
  // A path finds them in its first step; modes are about what they leave.
  const auto taut = [](const system::Spring& s) { return !std::isnan(s.length) || s.force > 0.0; };
  return std::any_of(c.hinges.begin(), c.hinges.end(), constant) ||
         (c.finds_modes() && std::any_of(c.springs.begin(), c.springs.end(), taut)) ||
         std::any_of(c.loads.begin(), c.loads.end(), constant) ||
         std::any_of(c.temperatures.begin(), c.temperatures.end(), constant) ||
         std::any_of(c.materials.begin(), c.materials.end(), strained);
}

}  // namespace

std::vector<double> start_shape(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<double> u;
  if (!c.mesh.start.empty()) mpi::on_root(comm, [&] { u = read_shape(c, mesh); });
  return u;
}

std::shared_ptr<const mesh::SurfaceMesh> mesh_of_start(const input::Case& c, const record::RunOptions& options,
                                                       std::shared_ptr<const mesh::SurfaceMesh> first) {
  if (options.restart.empty()) return first;
  mesh::MeshData data;
  mpi::on_root(options.comm, [&] {
    data = stored_mesh(c, options, *first);
    if (!data.triangles.empty()) remesh::rename_probes(c, *first, data);
  });
  setup::broadcast_mesh(options.comm, data);
  if (data.triangles.empty()) return first;
  return std::make_shared<const mesh::SurfaceMesh>(setup::with_group_unions(c, mesh::SurfaceMesh(std::move(data))));
}

results::Checkpoint read_start(const input::Case& c, const record::RunOptions& options, const mesh::SurfaceMesh& mesh,
                               Origin origin) {
  results::Checkpoint start;
  if (!options.restart.empty() && c.analysis == input::Analysis::linear)
    throw UserError("--restart: analysis = \"linear\" starts from the unloaded state; leave the option out");
  if (options.restart.empty()) {
    start.displacement = start_shape(options.comm, c, mesh);
    start.in_equilibrium = c.mesh.start.empty() && !mesh.has_charts() && !c.form.active && !acts_at_once(c);
    return start;
  }
  std::vector<double> numbers(14);
  mpi::on_root(options.comm, [&] {
    start = read_any(c, options, mesh);
    check_size(options, start, mesh);
    say_differences(c, options);
    if (origin == Origin::restart) say_doubts(c, options, start);
    if (origin == Origin::restart) begin_anew(c, start);
    numbers = {static_cast<double>(start.step),
               start.time,
               start.next_step,
               start.load_factor,
               start.in_equilibrium ? 1.0 : 0.0,
               start.contact_start,
               static_cast<double>(start.remeshings),
               start.too_long,
               start.too_short,
               static_cast<double>(start.remeshing_wait),
               static_cast<double>(start.remeshing_step),
               static_cast<double>(start.positive_tangents),
               static_cast<double>(start.factors_left),
               static_cast<double>(start.wait)};
  });
  mpi::broadcast(options.comm, numbers);
  start.step = static_cast<int>(numbers[0]);
  start.time = numbers[1];
  if (origin == Origin::restart) require_time_left(c, options, start.time);
  start.next_step = numbers[2];
  start.load_factor = numbers[3];
  start.in_equilibrium = numbers[4] > 0.0;
  start.contact_start = numbers[5];
  start.remeshings = static_cast<int>(numbers[6]);
  start.too_long = numbers[7];
  start.too_short = numbers[8];
  start.remeshing_wait = static_cast<int>(numbers[9]);
  start.remeshing_step = static_cast<int>(numbers[10]);
  start.positive_tangents = static_cast<int>(numbers[11]);
  start.factors_left = static_cast<int>(numbers[12]);
  start.wait = static_cast<int>(numbers[13]);
  mpi::broadcast(options.comm, start.contact_gaps);
  mpi::broadcast(options.comm, start.contact_push);
  mpi::broadcast(options.comm, start.passing);
  mpi::broadcast(options.comm, start.anchors);
  mpi::broadcast(options.comm, start.energy_balance);
  mpi::broadcast(options.comm, start.path);
  mpi::broadcast(options.comm, start.stability);
  mpi::broadcast(options.comm, start.step_start);
  return start;
}

void enter_stage(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh, Origin origin,
                 results::Checkpoint& state) {
  if (origin == Origin::stage) {
    state.step = state.remeshing_wait = state.remeshing_step = 0;
    state.positive_tangents = state.factors_left = state.wait = 0;
    state.next_step = 0.0;
    state.acceleration.clear();  // other supports and loads act
    results::forget_stability(state);
    state.previous.clear();
    state.previous_velocity.clear();
    state.step_start.clear();
    state.path.clear();
    state.energy_balance.clear();
    state.bodies.clear();
    system::begin_stage_at(state.time, state.places);
    if (c.analysis != input::Analysis::dynamic && c.analysis != input::Analysis::drape) {
      state.load_factor = 0.0;
      state.in_equilibrium = false;
    }
  }
  mpi::on_root(comm, [&] {
    if (c.analysis == input::Analysis::dynamic && state.velocity.empty()) state.velocity = initial_velocities(c, mesh);
  });
}

}  // namespace voile::simulation
