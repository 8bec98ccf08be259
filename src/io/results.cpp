#include "voile/io/results.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cctype>
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
  for (const char* name : {"results.xdmf", "results.h5"}) fs::remove(folder / name, ignored);
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

  void write_mesh(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                  const std::vector<int>& triangle_rank);
  void write_groups(NewFile& file, const mesh::SurfaceMesh& mesh);
  void write_xdmf() const;
  [[nodiscard]] std::string write_field(NewFile& file, const Field& field, const std::string& where) const;
  [[nodiscard]] std::size_t count(Centre centre) const { return centre == Centre::vertex ? vertices : triangles; }
};

void ResultsWriter::Impl::write_mesh(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                                     const std::vector<int>& triangle_rank) {
  NewFile file(folder / "results.h5", false);
  std::vector<double> positions;
  for (const Vec3& x : mesh.positions()) positions.insert(positions.end(), {x[0], x[1], x[2]});
  file.group("mesh");
  file.dataset("mesh/positions", H5T_NATIVE_DOUBLE, vertices, 3, positions.data());
  file.text("mesh/positions", "unit", "m");
  file.dataset("mesh/triangles", H5T_NATIVE_INT32, triangles, 3, mesh.triangles().data());
  constant_part = fmt::format(
      "        <Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n"
      "        <Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
      triangles, data_item("results.h5:/mesh/triangles", "Int", 4, triangles, 3),
      data_item("results.h5:/mesh/positions", "Float", 8, vertices, 3));
  file.group("mesh/partition");
  file.dataset("mesh/partition/vertices", H5T_NATIVE_INT, vertices, 1, vertex_rank.data());
  file.dataset("mesh/partition/triangles", H5T_NATIVE_INT, triangles, 1, triangle_rank.data());
  constant_part += attribute("partition", "Scalar", Centre::vertex,
                             data_item("results.h5:/mesh/partition/vertices", "Int", 4, vertices, 1));
  constant_part += attribute("partition", "Scalar", Centre::triangle,
                             data_item("results.h5:/mesh/partition/triangles", "Int", 4, triangles, 1));
  write_groups(file, mesh);
  file.group("steps");
  file.finish();
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

void ResultsWriter::Impl::write_xdmf() const {
  // Without steps the mesh alone is shown, so that the file opens from the start.
  const std::string body =
      grids.empty() ? fmt::format("      <Grid Name=\"mesh\">\n{}      </Grid>\n", constant_part) : join(grids, "");
  write_text(folder / "results.xdmf",
             fmt::format("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
                         "    <Grid Name=\"steps\" GridType=\"Collection\" CollectionType=\"Temporal\">\n"
                         "{}    </Grid>\n  </Domain>\n</Xdmf>\n",
                         body));
}

ResultsWriter::ResultsWriter(const fs::path& folder, const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                             const std::vector<int>& triangle_rank)
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
  impl_->write_mesh(mesh, vertex_rank, triangle_rank);
  impl_->write_xdmf();
}

ResultsWriter::~ResultsWriter() = default;
ResultsWriter::ResultsWriter(ResultsWriter&&) noexcept = default;
ResultsWriter& ResultsWriter::operator=(ResultsWriter&&) noexcept = default;

void ResultsWriter::write(const StepFields& step) {
  const Silence silence;
  const std::string number = fmt::format("{:06d}", step.step), where = fmt::format("steps/{}.h5", number);
  NewFile data(impl_->folder / where, false);
  data.number("/", "step", step.step);
  data.number("/", "time", step.time);
  data.number("/", "load_factor", step.load_factor);
  std::string grid = fmt::format("      <Grid Name=\"step {}\">\n        <Time Value=\"{}\"/>\n{}", step.step,
                                 step.time, impl_->constant_part);
  for (const Field& field : step.fields) grid += impl_->write_field(data, field, where);
  data.finish();
  NewFile index(impl_->folder / "results.h5", true);
  index.link("steps/" + number, where);
  index.finish();
  impl_->grids.push_back(grid + "      </Grid>\n");
  impl_->write_xdmf();
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
  impl_->line(join(values, ","));  // fmt writes the shortest text that reads back the same
}

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

}  // namespace voile::io
