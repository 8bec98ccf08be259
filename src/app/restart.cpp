#include "restart.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/io/mesh_file.hpp"
#include "voile/io/stored_step.hpp"

namespace voile::app {

namespace {

/// Rank 0 only.
io::StoredStep read_any_step(const RunOptions& options, const mesh::SurfaceMesh& mesh) {
  if (io::is_results(options.restart)) return io::read_step(options.restart, options.restart_step, mesh);
  io::Checkpoint c = io::read_checkpoint(options.restart, mesh);
  io::StoredStep stored;
  stored.step = c.step;
  stored.time = c.time;
  stored.load_factor = 1.0;
  stored.displacement = std::move(c.displacement);
  stored.velocity = std::move(c.velocity);
  return stored;
}

/// Rank 0 only.
io::Checkpoint read_motion(const RunOptions& options, const mesh::SurfaceMesh& mesh) {
  if (!io::is_results(options.restart)) return io::read_checkpoint(options.restart, mesh);
  io::StoredStep stored = io::read_step(options.restart, options.restart_step, mesh);
  io::Checkpoint c;
  c.displacement = std::move(stored.displacement);
  if (stored.velocity.empty()) return c;
  c.step = stored.step;
  c.time = stored.time;
  c.velocity = std::move(stored.velocity);
  return c;
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
  const mesh::MeshData start = io::read_mesh(c.mesh.start.string(), c.mesh.options);
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

}  // namespace

std::vector<double> start_shape(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<double> u;
  if (!c.mesh.start.empty()) mpi::on_root(PETSC_COMM_WORLD, [&] { u = read_shape(c, mesh); });
  return u;
}

Restart read_restart(const input::Case& c, const RunOptions& options, const system::Model& model, Vec a) {
  Restart r;
  if (options.restart.empty() && c.mesh.start.empty()) return r;
  if (options.restart.empty()) {
    model.dofs().scatter(start_shape(c, model.mesh()), a);
    r.from_motion = true;
    return r;
  }
  if (c.analysis == "linear")
    throw UserError("--restart: analysis = \"linear\" starts from the unloaded state; leave the option out");
  io::StoredStep stored;
  std::vector<double> numbers(4);
  mpi::on_root(model.comm(), [&] {
    stored = read_any_step(options, model.mesh());
    numbers = {static_cast<double>(stored.step), stored.load_factor, stored.previous.empty() ? 0.0 : 1.0,
               stored.velocity.empty() ? 0.0 : 1.0};
  });
  mpi::broadcast(model.comm(), numbers);
  r.given = true;
  r.from_motion = numbers[3] > 0.0;
  r.start.step = r.from_motion ? 0 : static_cast<int>(numbers[0]);
  r.start.load_factor = numbers[1];
  model.dofs().scatter(stored.displacement, a);
  if (numbers[2] > 0.0 && !r.from_motion) {
    r.previous = model.dofs().create_vector();
    model.dofs().scatter(stored.previous, r.previous);
    r.start.previous = r.previous;
  }
  return r;
}

io::Checkpoint read_start(const input::Case& c, const RunOptions& options, const system::Model& model) {
  io::Checkpoint start;
  std::vector<double> numbers(5, 0.0);
  if (options.restart.empty()) start.displacement = start_shape(c, model.mesh());
  mpi::on_root(model.comm(), [&] {
    if (!options.restart.empty()) start = read_motion(options, model.mesh());
    if (start.velocity.empty()) start.velocity = initial_velocities(c, model.mesh());
    numbers = {static_cast<double>(start.step), start.time, start.next_step, start.acceleration.empty() ? 0.0 : 1.0,
               start.contact_start};
  });
  mpi::broadcast(model.comm(), numbers);
  start.step = static_cast<int>(numbers[0]);
  start.time = numbers[1];
  start.next_step = numbers[2];
  start.contact_start = numbers[4];
  mpi::broadcast(model.comm(), start.contact_gaps);
  mpi::broadcast(model.comm(), start.yielding);
  // Known to rank 0: marks that there is one.
  if (numbers[3] > 0.0 && start.acceleration.empty()) start.acceleration.resize(1);
  return start;
}

}  // namespace voile::app
