#include "stored_run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "stored_results.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace fs = std::filesystem;

namespace {

fs::path results_in(const fs::path& place) {
  std::error_code ignored;
  fs::path file = fs::is_directory(place, ignored) ? place / results_name : place;
  require_plain_file(file);
  if (!fs::is_regular_file(file, ignored))
    throw UserError(fmt::format("{}: there are no results: give the output folder of a run, with {} in it",
                                place.string(), results_name));
  return file;
}

}  // namespace

void leave_hdf5_at_exit() {
  (void)H5dont_atexit();
}

StoredRun::StoredRun(const fs::path& place) : file_(results_in(place)) {
  guarded(file_, [&](const StoredResults& results) {
    complete_ = results.complete();
    steps_ = results.steps();
    obstacles_ = results.obstacles();
  });
}

StoredMesh StoredRun::mesh(std::size_t epoch) const {
  return guarded(file_, [&](const StoredResults& results) { return results.mesh(epoch); });
}

std::vector<FieldInfo> StoredRun::fields(std::size_t step) const {
  return guarded(file_, [&](const StoredResults& results) { return results.fields(step); });
}

bool StoredRun::has_field(std::size_t step, const std::string& name) const {
  const std::vector<FieldInfo> all = fields(step);
  return std::any_of(all.begin(), all.end(), [&](const FieldInfo& f) { return f.name == name; });
}

Field StoredRun::field(std::size_t step, const std::string& name, const mesh::MeshData& mesh) const {
  const std::vector<FieldInfo> all = fields(step);
  const auto info = std::find_if(all.begin(), all.end(), [&](const FieldInfo& f) { return f.name == name; });
  if (info == all.end()) {
    std::vector<std::string> names;
    for (const FieldInfo& f : all) names.push_back(f.name);
    throw UserError(fmt::format("{}: step {} has no field '{}':{}", file_.string(), steps_[step].number, name,
                                suggestion(name, names)));
  }
  const std::size_t rows = info->centre == Centre::vertex ? mesh.positions.size() : mesh.triangles.size();
  return {info->name, info->unit, info->centre, info->components,
          guarded(file_, [&](const StoredResults& results) { return results.values(step, *info, rows); })};
}

std::vector<Vec3> StoredRun::obstacle_positions(std::size_t step) const {
  if (!obstacles_.moves) return obstacles_.positions;
  std::vector<Vec3> moved = guarded(file_, [&](const StoredResults& results) {
    return results.obstacle_positions(step, obstacles_.positions.size());
  });
  return moved.empty() ? obstacles_.positions : moved;
}

}  // namespace voile::results
