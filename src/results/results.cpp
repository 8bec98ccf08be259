#include "results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <fstream>
#include <utility>

#include "hdf5_file.hpp"
#include "mesh_record.hpp"
#include "results_catalogue.hpp"
#include "results_index.hpp"
#include "results_xdmf.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace fs = std::filesystem;

namespace {

/// Between renewals of the index lies so many times what the last one took: they cost a twentieth of the time.
constexpr int least_pause = 20;

template <class Real>
std::vector<Real> flat(const std::vector<Vec3>& points) {
  std::vector<Real> values;
  values.reserve(3 * points.size());
  for (const Vec3& x : points)
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<Real>(x[k]));
  return values;
}

/// Replaces `file` in one step.
void write_text(const fs::path& file, const std::string& text) {
  const fs::path temporary = file.string() + ".part";
  std::ofstream out(temporary, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (out) fs::rename(temporary, file, error);
  if (out && !error) return;
  fs::remove(temporary, error);
  fail_writing(file);
}

/// Files of steps and epochs, and nothing else. The folder goes if it is empty then.
void remove_steps(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_symlink(folder, ignored)) return;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    std::string name = entry.path().filename().string();
    if (name.ends_with(".part")) name.resize(name.size() - 5);
    if (name.starts_with("epoch_")) name.erase(0, 6);
    const bool ours = name == "obstacles.h5" ||
                      (name.size() > 3 && name.ends_with(".h5") &&
                       std::all_of(name.begin(), name.end() - 3, [](unsigned char c) { return std::isdigit(c); }));
    if (ours) fs::remove(entry.path(), ignored);
  }
  fs::remove(folder, ignored);
}

/// Removes the results of an earlier run, and nothing else. What names comes first.
void remove_old(const fs::path& folder) {
  std::error_code ignored;
  for (const char* name : {"results.xdmf", "obstacles.xdmf", results_name})
    for (const char* ending : {"", ".part"}) fs::remove(folder / (std::string(name) + ending), ignored);
  remove_steps(folder / "steps");
}

void write_obstacles(const fs::path& folder, const ObstacleTriangles& obstacles, const std::string& length) {
  const std::size_t triangles = obstacles.triangles.size();
  if (obstacles.obstacle.size() != triangles)
    throw InternalError(fmt::format("{} of {} triangles have an obstacle", obstacles.obstacle.size(), triangles));
  NewFile file(folder / obstacle_file);
  file.texts("obstacles/names", obstacles.names);
  file.dataset("obstacles/positions", H5T_NATIVE_FLOAT, obstacles.positions.size(), 3,
               flat<float>(obstacles.positions).data());
  file.text("obstacles/positions", "unit", length);
  file.dataset("obstacles/triangles", H5T_NATIVE_INT32, triangles, 3, obstacles.triangles.data());
  file.dataset("obstacles/obstacle", H5T_NATIVE_INT, triangles, 1, obstacles.obstacle.data());
  file.finish();
}

/// What VTK wants to know of the mesh.
void write_vtk_mesh(NewFile& file, const mesh::SurfaceMesh& mesh, Catalogue& catalogue) {
  constexpr std::uint8_t vtk_triangle = 5;
  const auto triangles = static_cast<std::size_t>(mesh.triangle_count());
  const std::vector<float> points = flat<float>(mesh.positions());
  std::vector<std::int64_t> connectivity, offsets{0};
  for (const mesh::Triangle& t : mesh.triangles()) {
    connectivity.insert(connectivity.end(), t.begin(), t.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  file.dataset("points", H5T_NATIVE_FLOAT, mesh.positions().size(), 3, points.data());
  file.dataset("connectivity", H5T_NATIVE_INT64, connectivity.size(), 1, connectivity.data());
  file.dataset("offsets", H5T_NATIVE_INT64, offsets.size(), 1, offsets.data());
  const std::vector<std::uint8_t> types(triangles, vtk_triangle);
  file.dataset("types", H5T_NATIVE_UINT8, triangles, 1, types.data());
  for (const mesh::Group& group : mesh.groups()) {
    const bool on_triangles = group.dimension == 2;
    std::vector<std::uint8_t> mask(on_triangles ? triangles : mesh.positions().size(), 0);
    for (const Index i : on_triangles ? group.triangles : group.vertices) mask[static_cast<std::size_t>(i)] = 1;
    file.dataset("masks/" + catalogue.group_name(group), H5T_NATIVE_UINT8, mask.size(), 1, mask.data());
  }
}

}  // namespace

struct ResultsWriter::Impl {
  fs::path folder;
  ObstacleTriangles obstacles;
  Catalogue catalogue;
  std::vector<Vec3> rest{};  ///< of the last epoch
  std::size_t triangles = 0;
  std::vector<std::string> grids{}, obstacle_grids{};  ///< XDMF of each step
  std::size_t named = 0;                               ///< steps that results.vtkhdf names
  Clock now{};
  std::chrono::steady_clock::time_point last_index{};
  std::chrono::steady_clock::duration index_cost{};
  bool finished = false;

  [[nodiscard]] bool index_is_due() const;
  void write_names();
  void write_xdmf() const;
  void write_field(NewFile& file, const Field& field) const;
  [[nodiscard]] bool write_points(NewFile& file, const StepFields& step) const;
};

void ResultsWriter::Impl::write_field(NewFile& file, const Field& field) const {
  const std::size_t rows = field.centre == Centre::vertex ? rest.size() : triangles;
  const auto columns = static_cast<std::size_t>(field.components);
  if (field.values.size() != rows * columns)
    throw InternalError(
        fmt::format("field '{}' has {} values instead of {} x {}", field.name, field.values.size(), rows, columns));
  const std::string path = "fields/" + field.name;
  file.dataset(path, H5T_NATIVE_DOUBLE, rows, columns, field.values.data());
  file.text(path, "unit", field.unit);
  file.text(path, "centre", field.centre == Centre::vertex ? "vertex" : "triangle");
}

/// Where the vertices are. False: where they are at rest, for all that is known.
bool ResultsWriter::Impl::write_points(NewFile& file, const StepFields& step) const {
  const auto u = std::find_if(step.fields.begin(), step.fields.end(), [](const Field& f) {
    return f.name == "displacement" && f.centre == Centre::vertex && f.components == 3;
  });
  if (u == step.fields.end()) return false;
  std::vector<float> points(u->values.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = static_cast<float>(rest[i / 3][static_cast<Index>(i % 3)] + u->values[i]);
  file.dataset("points", H5T_NATIVE_FLOAT, rest.size(), 3, points.data());
  return true;
}

void ResultsWriter::Impl::write_xdmf() const {
  // Without steps the mesh alone is shown, so that the file opens from the start.
  if (grids.empty())
    write_text(folder / "results.xdmf", xdmf_file("mesh", {xdmf_mesh(catalogue)}, false));
  else
    write_text(folder / "results.xdmf", xdmf_file("steps", grids, true));
  if (obstacles.triangles.empty() || (!obstacles.moves && !grids.empty())) return;
  // What never moves is one grid without a time, which ParaView shows at all times.
  write_text(folder / "obstacles.xdmf", obstacle_grids.empty()
                                            ? xdmf_file("obstacles", {xdmf_obstacles(catalogue, obstacles, -1)}, false)
                                            : xdmf_file("obstacles", obstacle_grids, true));
}

/// Naming steps costs as much as there are steps: those that follow each other quickly wait.
bool ResultsWriter::Impl::index_is_due() const {
  return now() - last_index >= least_pause * index_cost;
}

/// What names goes last: it then names what is there.
void ResultsWriter::Impl::write_names() {
  const auto begin = now();
  write_index(folder, catalogue);
  write_xdmf();
  named = grids.size();
  last_index = now();
  index_cost = last_index - begin;
}

ResultsWriter::ResultsWriter(const fs::path& folder, ObstacleTriangles obstacles, std::string length, Clock clock)
    : impl_(std::make_unique<Impl>(Impl{.folder = folder,
                                        .obstacles = std::move(obstacles),
                                        .catalogue = Catalogue(std::move(length)),
                                        .now = std::move(clock)})) {
  const Silence silence;
  remove_old(folder);
  std::error_code error;
  fs::create_directories(folder / "steps", error);
  if (error)
    throw UserError(fmt::format("{}: the folder for results cannot be created: {}", folder.string(), error.message()));
  if (impl_->obstacles.names.empty()) return;
  write_obstacles(folder, impl_->obstacles, impl_->catalogue.length());
  if (impl_->obstacles.moves) impl_->catalogue.let_obstacles_move(impl_->obstacles.positions.size());
}

ResultsWriter::~ResultsWriter() {
  if (!impl_) return;
  try {
    finish();
  } catch (const std::exception&) {  // the steps themselves are on disk
  }
}
ResultsWriter::ResultsWriter(ResultsWriter&&) noexcept = default;
ResultsWriter& ResultsWriter::operator=(ResultsWriter&&) noexcept = default;

void ResultsWriter::begin_epoch(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                                const std::vector<int>& triangle_rank) {
  const Silence silence;
  if (vertex_rank.size() != mesh.positions().size() || triangle_rank.size() != mesh.triangles().size())
    throw InternalError("the partition does not fit the mesh");
  NewFile file(impl_->folder / epoch_file(impl_->catalogue.epochs().size()));
  write_mesh_record(file, mesh.data(), impl_->catalogue.length());
  file.dataset("mesh/partition/vertices", H5T_NATIVE_INT, vertex_rank.size(), 1, vertex_rank.data());
  file.dataset("mesh/partition/triangles", H5T_NATIVE_INT, triangle_rank.size(), 1, triangle_rank.data());
  write_vtk_mesh(file, mesh, impl_->catalogue);
  file.finish();
  impl_->catalogue.begin_epoch(mesh);
  impl_->rest = mesh.positions();
  impl_->triangles = mesh.triangles().size();
  if (impl_->grids.empty()) impl_->write_names();
}

void ResultsWriter::write(const StepFields& step) {
  const Silence silence;
  if (impl_->finished || impl_->catalogue.epochs().empty())
    throw InternalError("a step of results without a mesh, or after the end");
  NewFile file(impl_->folder / step_file(impl_->grids.size()));
  file.number("/", "step", step.step);
  file.number("/", "time", step.time);
  file.number("/", "load_factor", step.load_factor);
  for (const auto& [name, values] : {std::pair{"path", &step.path}, std::pair{"bodies", &step.bodies}})
    if (!values->empty()) file.dataset(name, H5T_NATIVE_DOUBLE, values->size(), 1, values->data());
  file.number("/", "epoch", static_cast<int>(impl_->catalogue.epochs().size()) - 1);
  file.group("fields");
  for (const Field& field : step.fields) impl_->write_field(file, field);
  const bool moved = impl_->write_points(file, step);
  if (impl_->obstacles.moves) {
    if (step.obstacles.size() != impl_->obstacles.positions.size())
      throw InternalError(fmt::format("{} positions for {} vertices of obstacles", step.obstacles.size(),
                                      impl_->obstacles.positions.size()));
    file.dataset("obstacles", H5T_NATIVE_FLOAT, step.obstacles.size(), 3, flat<float>(step.obstacles).data());
  }
  file.finish();
  impl_->catalogue.add_step(step, moved);
  const std::size_t number = impl_->grids.size();
  impl_->grids.push_back(xdmf_step(impl_->catalogue, number));
  if (impl_->obstacles.moves)
    impl_->obstacle_grids.push_back(xdmf_obstacles(impl_->catalogue, impl_->obstacles, static_cast<int>(number)));
  if (impl_->index_is_due()) impl_->write_names();
}

const std::vector<std::string>& ResultsWriter::renamed_groups() const {
  return impl_->catalogue.renamed();
}

void ResultsWriter::flush() {
  const Silence silence;
  if (impl_->named < impl_->grids.size()) impl_->write_names();
}

void ResultsWriter::finish() {
  if (impl_->finished || impl_->catalogue.epochs().empty()) return;
  const Silence silence;
  flush();
  consolidate(impl_->folder, impl_->catalogue);
  impl_->finished = true;
  remove_steps(impl_->folder / "steps");
}

}  // namespace voile::results
