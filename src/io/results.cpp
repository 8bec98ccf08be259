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

#include "voile/base/error.hpp"
#include "voile/base/text.hpp"

namespace voile::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& file) {
  throw UserError(fmt::format("{}: writing failed; is the disk full or the folder write-protected?", file.string()));
}

/// Owns one HDF5 identifier. `close` tells whether closing succeeded: only then the data is in the file.
class Id {
 public:
  using Closer = herr_t (*)(hid_t);
  Id(hid_t id, Closer closer, const fs::path& file) : id_(id), closer_(closer), file_(file) {
    if (id_ < 0) fail(file_);
  }
  ~Id() {
    if (id_ >= 0) closer_(id_);
  }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }
  void close() {
    if (closer_(std::exchange(id_, -1)) < 0) fail(file_);
  }

 private:
  hid_t id_;
  Closer closer_;
  const fs::path& file_;
};

/// While it lives HDF5 does not print its error stack: what fails is reported by an exception.
class Silence {
 public:
  Silence() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// An HDF5 file that appears under its name complete or not at all.
class NewFile {
 public:
  /// Starts empty, or as a copy of the present file.
  NewFile(const fs::path& path, bool copy) : path_(path), temporary_(path.string() + ".part") {
    if (copy) {
      std::error_code error;
      fs::copy_file(path_, temporary_, fs::copy_options::overwrite_existing, error);
      if (error) fail(temporary_);
    }
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, temporary_);
    // Nobody else opens the temporary file, and locks fail on some network drives.
    H5Pset_file_locking(access, false, true);
    const std::string name = temporary_.string();
    file_.emplace(copy ? H5Fopen(name.c_str(), H5F_ACC_RDWR, access)
                       : H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access),
                  H5Fclose, temporary_);
  }

  void finish() {
    file_->close();
    std::error_code error;
    fs::rename(temporary_, path_, error);
    if (error) fail(path_);
  }

  void group(const std::string& name) {
    Id(H5Gcreate2(*file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, temporary_).close();
  }

  void link(const std::string& name, const std::string& target_file) {
    if (H5Lcreate_external(target_file.c_str(), "/", *file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0)
      fail(temporary_);
  }

  void text(const std::string& object, const char* name, const std::string& value) {
    const Id type(H5Tcopy(H5T_C_S1), H5Tclose, temporary_);
    H5Tset_size(type, std::max<std::size_t>(1, value.size()));
    H5Tset_cset(type, H5T_CSET_UTF8);
    attribute(object, name, type, value.c_str());
  }

  void number(const std::string& object, const char* name, double value) {
    attribute(object, name, H5T_NATIVE_DOUBLE, &value);
  }
  void number(const std::string& object, const char* name, int value) {
    attribute(object, name, H5T_NATIVE_INT, &value);
  }

  /// rows x columns values; one column makes a plain list.
  void dataset(const std::string& name, hid_t type, std::size_t rows, std::size_t columns, const void* values) {
    const std::array<hsize_t, 2> size{rows, columns};
    const Id space(H5Screate_simple(columns == 1 ? 1 : 2, size.data(), nullptr), H5Sclose, temporary_);
    Id set(H5Dcreate2(*file_, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose, temporary_);
    if (rows > 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail(temporary_);
    set.close();
  }

 private:
  void attribute(const std::string& object, const char* name, hid_t type, const void* value) {
    const Id space(H5Screate(H5S_SCALAR), H5Sclose, temporary_);
    Id a(H5Acreate_by_name(*file_, object.c_str(), name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
         temporary_);
    if (H5Awrite(a, type, value) < 0) fail(temporary_);
    a.close();
  }

  fs::path path_, temporary_;
  std::optional<Id> file_;
};

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
  if (!out || error) fail(file);
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
    if (!out) fail(file);
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
