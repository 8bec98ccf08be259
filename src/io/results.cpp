#include "voile/io/results.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <utility>

#include "hdf5_file.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"

namespace voile::io {

namespace fs = std::filesystem;

namespace {

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string safe_name(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-' && c != '.') c = '_';
  return name.find_first_not_of('.') == std::string::npos ? "_" + name : name;
}

/// A <DataItem> that points into an HDF5 file beside the XDMF.
std::string data_item(const std::string& where, const char* number, int bytes, std::size_t rows, std::size_t columns) {
  const std::string size = columns == 1 ? fmt::format("{}", rows) : fmt::format("{} {}", rows, columns);
  return fmt::format("<DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">{}</DataItem>",
                     size, number, bytes, where);
}

std::string attribute(const std::string& name, const char* type, Centre centre, const std::string& item) {
  return fmt::format("        <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n",
                     xml_text(name), type, centre == Centre::vertex ? "Node" : "Cell", item);
}

const char* attribute_type(const Field& field) {
  if (field.components == 1) return "Scalar";
  if (field.components == 9) return "Tensor";
  return field.components == 3 && field.centre == Centre::vertex ? "Vector" : "Matrix";
}

/// An XDMF file of one grid, or of one per step.
std::string xdmf(const char* name, const std::string& grids, bool steps) {
  const std::string body =
      steps ? fmt::format("    <Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}    </Grid>\n",
                          name, grids)
            : grids;
  return fmt::format("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n{}  </Domain>\n</Xdmf>\n", body);
}

/// `time`: empty, or a <Time> element.
std::string grid(const std::string& name, const std::string& time, const std::string& content) {
  return fmt::format("      <Grid Name=\"{}\">\n{}{}      </Grid>\n", name, time, content);
}

std::string topology_and_geometry(const std::string& triangles, std::size_t triangle_count,
                                  const std::string& positions, int bytes, std::size_t vertex_count) {
  return fmt::format(
      "        <Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n"
      "        <Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
      triangle_count, data_item(triangles, "Int", 4, triangle_count, 3),
      data_item(positions, "Float", bytes, vertex_count, 3));
}

std::vector<float> single(const std::vector<Vec3>& points) {
  std::vector<float> values;
  values.reserve(3 * points.size());
  for (const Vec3& x : points)
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(x[k]));
  return values;
}

/// So many steps are named at once each.
constexpr std::size_t always_named = 64;
/// The index names every step after so long at the latest.
constexpr std::chrono::seconds longest_wait{2};

std::string step_file(const std::string& number) {
  return fmt::format("steps/{}.h5", number);
}

/// Replaces `file` in one step.
void write_text(const fs::path& file, const std::string& text) {
  const fs::path temporary = file.string() + ".part";
  std::ofstream out(temporary, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (out) fs::rename(temporary, file, error);
  if (!out || error) fail_writing(file);
}

/// Removes the results of an earlier run, and nothing else.
void remove_old(const fs::path& folder) {
  std::error_code ignored;
  for (const char* name : {"results.xdmf", "results.h5", "obstacles.xdmf"}) fs::remove(folder / name, ignored);
  for (const auto& entry : fs::directory_iterator(folder / "steps", ignored)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() == ".h5" &&
        std::all_of(stem.begin(), stem.end(), [](unsigned char c) { return std::isdigit(c); }))
      fs::remove(entry.path(), ignored);
  }
}

}  // namespace

struct ResultsWriter::Impl {
  fs::path folder;
  std::size_t vertices = 0, triangles = 0;
  std::string constant_part;         ///< XDMF of mesh, groups and partition, the same in each step
  std::vector<std::string> grids{};  ///< XDMF of each step
  std::size_t obstacle_vertices = 0, obstacle_triangles = 0;
  bool obstacles_move = false;
  std::vector<std::string> obstacle_grids{};  ///< XDMF of each step if they move
  std::vector<std::string> renamed{};         ///< groups with another name in the file
  std::vector<std::string> unlinked{};        ///< numbers of steps that results.h5 does not name yet
  std::size_t unlinked_bytes = 0;             ///< of their files
  std::chrono::steady_clock::time_point last_index{};

  [[nodiscard]] bool index_is_due() const;
  void write_index();
  void write_constant(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                      const std::vector<int>& triangle_rank, const ObstacleTriangles& obstacles);
  void write_mesh(NewFile& file, const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                  const std::vector<int>& triangle_rank);
  void write_groups(NewFile& file, const mesh::SurfaceMesh& mesh);
  void write_obstacles(NewFile& file, const ObstacleTriangles& obstacles);
  void move_obstacles(NewFile& file, const StepFields& step, const std::string& where, const std::string& time);
  [[nodiscard]] std::string obstacle_content(const std::string& positions) const;
  void write_xdmf() const;
  [[nodiscard]] std::string write_field(NewFile& file, const Field& field, const std::string& where) const;
  [[nodiscard]] std::size_t count(Centre centre) const { return centre == Centre::vertex ? vertices : triangles; }
};

void ResultsWriter::Impl::write_constant(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                                         const std::vector<int>& triangle_rank, const ObstacleTriangles& obstacles) {
  NewFile file(folder / "results.h5", false);
  write_mesh(file, mesh, vertex_rank, triangle_rank);
  write_groups(file, mesh);
  if (!obstacles.names.empty()) write_obstacles(file, obstacles);
  file.group("steps");
  file.finish();
}

void ResultsWriter::Impl::write_mesh(NewFile& file, const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                                     const std::vector<int>& triangle_rank) {
  std::vector<double> positions;
  for (const Vec3& x : mesh.positions()) positions.insert(positions.end(), {x[0], x[1], x[2]});
  file.group("mesh");
  file.dataset("mesh/positions", H5T_NATIVE_DOUBLE, vertices, 3, positions.data());
  file.text("mesh/positions", "unit", "m");
  file.dataset("mesh/triangles", H5T_NATIVE_INT32, triangles, 3, mesh.triangles().data());
  constant_part =
      topology_and_geometry("results.h5:/mesh/triangles", triangles, "results.h5:/mesh/positions", 8, vertices);
  file.group("mesh/partition");
  file.dataset("mesh/partition/vertices", H5T_NATIVE_INT, vertices, 1, vertex_rank.data());
  file.dataset("mesh/partition/triangles", H5T_NATIVE_INT, triangles, 1, triangle_rank.data());
  constant_part += attribute("partition", "Scalar", Centre::vertex,
                             data_item("results.h5:/mesh/partition/vertices", "Int", 4, vertices, 1));
  constant_part += attribute("partition", "Scalar", Centre::triangle,
                             data_item("results.h5:/mesh/partition/triangles", "Int", 4, triangles, 1));
}

void ResultsWriter::Impl::write_groups(NewFile& file, const mesh::SurfaceMesh& mesh) {
  file.group("mesh/groups");
  std::vector<std::string> taken;
  for (const mesh::Group& group : mesh.groups()) {
    const Centre centre = group.dimension == 2 ? Centre::triangle : Centre::vertex;
    std::vector<std::uint8_t> mask(count(centre), 0);
    for (const Index i : group.dimension == 2 ? group.triangles : group.vertices) mask[static_cast<std::size_t>(i)] = 1;
    std::string name = safe_name(group.name);
    while (std::find(taken.begin(), taken.end(), name) != taken.end()) name += "_";
    taken.push_back(name);
    const std::string path = "mesh/groups/" + name;
    if (name != group.name) renamed.push_back(fmt::format("'{}' is /{}", group.name, path));
    file.dataset(path, H5T_NATIVE_UINT8, mask.size(), 1, mask.data());
    file.text(path, "name", group.name);
    file.number(path, "dimension", group.dimension);
    constant_part += attribute("group:" + group.name, "Scalar", centre,
                               data_item("results.h5:/" + path, "UChar", 1, mask.size(), 1));
  }
}

std::string ResultsWriter::Impl::write_field(NewFile& file, const Field& field, const std::string& where) const {
  const std::size_t rows = count(field.centre), columns = static_cast<std::size_t>(field.components);
  if (field.values.size() != rows * columns)
    throw InternalError(
        fmt::format("field '{}' has {} values instead of {} x {}", field.name, field.values.size(), rows, columns));
  file.dataset(field.name, H5T_NATIVE_DOUBLE, rows, columns, field.values.data());
  file.text(field.name, "unit", field.unit);
  file.text(field.name, "centre", field.centre == Centre::vertex ? "vertex" : "triangle");
  const bool voigt = field.components == 3 && field.centre == Centre::triangle;
  return attribute(voigt ? field.name + "_11_22_12" : field.name, attribute_type(field), field.centre,
                   data_item(fmt::format("{}:/{}", where, field.name), "Float", 8, rows, columns));
}

void ResultsWriter::Impl::write_obstacles(NewFile& file, const ObstacleTriangles& obstacles) {
  obstacle_vertices = obstacles.positions.size();
  obstacle_triangles = obstacles.triangles.size();
  obstacles_move = obstacles.moves;
  if (obstacles.obstacle.size() != obstacle_triangles)
    throw InternalError(
        fmt::format("{} of {} triangles have an obstacle", obstacles.obstacle.size(), obstacle_triangles));
  file.group("obstacles");
  file.texts("obstacles/names", obstacles.names);
  file.dataset("obstacles/positions", H5T_NATIVE_FLOAT, obstacle_vertices, 3, single(obstacles.positions).data());
  file.text("obstacles/positions", "unit", "m");
  file.dataset("obstacles/triangles", H5T_NATIVE_INT32, obstacle_triangles, 3, obstacles.triangles.data());
  file.dataset("obstacles/obstacle", H5T_NATIVE_INT, obstacle_triangles, 1, obstacles.obstacle.data());
}

/// Adds the positions of obstacles to the file of a step.
void ResultsWriter::Impl::move_obstacles(NewFile& file, const StepFields& step, const std::string& where,
                                         const std::string& time) {
  const char* name = "obstacle_positions";
  if (step.obstacles.size() != obstacle_vertices)
    throw InternalError(
        fmt::format("{} positions for {} vertices of obstacles", step.obstacles.size(), obstacle_vertices));
  file.dataset(name, H5T_NATIVE_FLOAT, obstacle_vertices, 3, single(step.obstacles).data());
  file.text(name, "unit", "m");
  obstacle_grids.push_back(
      grid(fmt::format("step {}", step.step), time, obstacle_content(fmt::format("{}:/{}", where, name))));
}

std::string ResultsWriter::Impl::obstacle_content(const std::string& positions) const {
  return topology_and_geometry("results.h5:/obstacles/triangles", obstacle_triangles, positions, 4, obstacle_vertices) +
         attribute("obstacle", "Scalar", Centre::triangle,
                   data_item("results.h5:/obstacles/obstacle", "Int", 4, obstacle_triangles, 1));
}

void ResultsWriter::Impl::write_xdmf() const {
  // Without steps the mesh alone is shown, so that the file opens from the start.
  write_text(folder / "results.xdmf",
             xdmf("steps", grids.empty() ? grid("mesh", "", constant_part) : join(grids, ""), true));
  if (obstacle_triangles == 0 || (!obstacles_move && !grids.empty())) return;
  // What never moves is one grid without a time, which ParaView shows at all times.
  write_text(folder / "obstacles.xdmf",
             obstacle_grids.empty()
                 ? xdmf("obstacles", grid("obstacles", "", obstacle_content("results.h5:/obstacles/positions")), false)
                 : xdmf("obstacles", join(obstacle_grids, ""), true));
}

ResultsWriter::ResultsWriter(const fs::path& folder, const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                             const std::vector<int>& triangle_rank, const ObstacleTriangles& obstacles)
    : impl_(std::make_unique<Impl>()) {
  const Silence silence;
  impl_->folder = folder;
  impl_->vertices = static_cast<std::size_t>(mesh.vertex_count());
  impl_->triangles = static_cast<std::size_t>(mesh.triangle_count());
  if (vertex_rank.size() != impl_->vertices || triangle_rank.size() != impl_->triangles)
    throw InternalError("the partition does not fit the mesh");
  std::error_code error;
  fs::create_directories(folder / "steps", error);
  if (error)
    throw UserError(fmt::format("{}: the folder for results cannot be created: {}", folder.string(), error.message()));
  remove_old(folder);
  impl_->write_constant(mesh, vertex_rank, triangle_rank, obstacles);
  impl_->write_xdmf();
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

/// Rewriting what names the steps costs as much as there are steps: it waits until the steps that it does not name hold
/// as many bytes, or a while has passed.
bool ResultsWriter::Impl::index_is_due() const {
  std::error_code ignored;
  const std::uintmax_t size = fs::file_size(folder / "results.h5", ignored) + grids.size() * grids.front().size();
  return grids.size() <= always_named || unlinked_bytes >= size ||
         std::chrono::steady_clock::now() - last_index >= longest_wait;
}

void ResultsWriter::Impl::write_index() {
  if (!unlinked.empty()) {
    NewFile index(folder / "results.h5", true);
    for (const std::string& number : unlinked) index.link("steps/" + number, step_file(number));
    index.finish();
    unlinked.clear();
    unlinked_bytes = 0;
  }
  write_xdmf();
  last_index = std::chrono::steady_clock::now();
}

void ResultsWriter::write(const StepFields& step) {
  const Silence silence;
  const std::string number = fmt::format("{:06d}", step.step), where = step_file(number);
  const std::string time = fmt::format("        <Time Value=\"{}\"/>\n", step.time);
  NewFile data(impl_->folder / where, false);
  data.number("/", "step", step.step);
  data.number("/", "time", step.time);
  data.number("/", "load_factor", step.load_factor);
  std::string content = impl_->constant_part;
  for (const Field& field : step.fields) content += impl_->write_field(data, field, where);
  if (impl_->obstacles_move) impl_->move_obstacles(data, step, where, time);
  data.finish();
  impl_->grids.push_back(grid(fmt::format("step {}", step.step), time, content));
  std::error_code ignored;
  impl_->unlinked.push_back(number);
  impl_->unlinked_bytes += fs::file_size(impl_->folder / where, ignored);
  if (impl_->index_is_due()) impl_->write_index();
}

std::vector<std::string> ResultsWriter::renamed_groups() const {
  return impl_->renamed;
}

void ResultsWriter::finish() {
  const Silence silence;
  if (!impl_->unlinked.empty()) impl_->write_index();
}

struct HistoryWriter::Impl {
  fs::path file;
  std::ofstream out;
  std::size_t columns;

  void line(const std::string& text) {
    out << text << '\n' << std::flush;
    if (!out) fail_writing(file);
  }
};

HistoryWriter::HistoryWriter(const fs::path& file, const std::vector<std::string>& columns)
    : impl_(std::make_unique<Impl>(Impl{file, std::ofstream(file), columns.size()})) {
  impl_->line(join(columns, ","));
}

HistoryWriter::~HistoryWriter() = default;
HistoryWriter::HistoryWriter(HistoryWriter&&) noexcept = default;
HistoryWriter& HistoryWriter::operator=(HistoryWriter&&) noexcept = default;

void HistoryWriter::write(const std::vector<double>& values) {
  if (values.size() != impl_->columns)
    throw InternalError(
        fmt::format("{}: {} values for {} columns", impl_->file.string(), values.size(), impl_->columns));
  std::vector<std::string> texts;  // a value that does not exist stays empty
  for (const double x : values)
    texts.push_back(std::isfinite(x) ? fmt::format("{}", x) : "");  // the shortest text that reads back the same
  impl_->line(join(texts, ","));
}

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

}  // namespace voile::io
