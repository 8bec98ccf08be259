#include "stored_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "stored_results.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace {

namespace fs = std::filesystem;

/// Paths and drapes record the load factor or the step as time.
bool is_motion(const StoredResults& results) {
  return std::any_of(results.steps().begin(), results.steps().end(),
                     [](const StoredStepInfo& s) { return s.time != s.load_factor && s.time != s.number; });
}

StoredStep step_of(const StoredResults& results, const fs::path& path, int number, const mesh::SurfaceMesh& mesh) {
  const std::size_t at = results.find(number);
  const StoredStepInfo& record = results.steps()[at];
  results.check_mesh(at, mesh);
  const auto vertices = static_cast<std::size_t>(mesh.vertex_count());
  std::optional<std::vector<double>> u = results.vectors(at, "displacement", vertices);
  if (!u) fail_reading(path, fmt::format("its step {} has no 'displacement'", record.number));
  StoredStep stored;
  stored.step = record.number;
  stored.load_factor = record.load_factor;
  stored.path = record.path;
  stored.bodies = record.bodies;
  stored.displacement = std::move(*u);
  stored.velocity = results.vectors(at, "velocity", vertices).value_or(std::vector<double>());
  if (!stored.velocity.empty()) stored.time = record.time;
  stored.in_motion = !stored.velocity.empty() || is_motion(results);
  stored.has_last = at > 0 && results.steps()[at - 1].number == record.number - 1;
  if (at > 0 && results.steps()[at - 1].epoch == record.epoch)
    stored.previous = results.vectors(at - 1, "displacement", vertices).value_or(std::vector<double>());
  return stored;
}

/// What is read here is read for --restart.
template <class Work>
auto for_restart(const fs::path& path, const Work& work) {
  try {
    return guarded(path, work);
  } catch (const UserError& e) {
    rethrow_for_restart(e);
  }
}

}  // namespace

StoredStep read_step(const fs::path& path, int step, const mesh::SurfaceMesh& mesh) {
  return for_restart(path, [&](const StoredResults& results) { return step_of(results, path, step, mesh); });
}

std::vector<double> read_mode(const fs::path& path, int number, const mesh::SurfaceMesh& mesh) {
  return guarded(path, [&](const StoredResults& results) {
    const std::size_t at = results.find(number);
    results.check_mesh(at, mesh);
    std::optional<std::vector<double>> shape =
        results.vectors(at, "mode", static_cast<std::size_t>(mesh.vertex_count()));
    if (!shape) fail_reading(path, "it has no modes");
    return std::move(*shape);
  });
}

mesh::MeshData read_step_mesh(const fs::path& path, int step) {
  return for_restart(
      path, [&](const StoredResults& results) { return results.mesh(results.steps()[results.find(step)].epoch).data; });
}

bool is_remeshed(const fs::path& path, int step) {
  return for_restart(path, [&](const StoredResults& results) {
    return results.steps()[results.find(step)].epoch != results.steps().front().epoch;
  });
}

bool is_results(const fs::path& path) {
  const Silence silence;
  const Hdf5Handle file = open_to_read(path);
  return file.valid() && has(file, "voile");
}

}  // namespace voile::results
