#include "results_index.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <limits>
#include <memory>

#include "base/child_process.hpp"
#include "hdf5_file.hpp"

namespace voile::results {

namespace fs = std::filesystem;

namespace {

/// Chunks of the one file hold so much at least: many small ones are slow to read.
constexpr std::size_t least_chunk = 65536;

std::vector<std::int64_t> each(const Catalogue& c, std::int64_t (*value)(const Catalogue&, const StepPlace&)) {
  std::vector<std::int64_t> values;
  for (const StepPlace& step : c.steps()) values.push_back(value(c, step));
  return values;
}

void write_list(FileContent& file, const std::string& name, const std::vector<std::int64_t>& values,
                int dimensions = 1) {
  file.dataset(name, H5T_NATIVE_INT64, values.size(), 1, values.data(), dimensions);
}

/// NumberOf*: one part of the VTKHDF file is one epoch.
void write_parts(FileContent& file, const Catalogue& c) {
  std::vector<std::int64_t> points, cells, ids;
  for (const EpochPlace& e : c.epochs()) {
    points.push_back(static_cast<std::int64_t>(e.vertices));
    cells.push_back(static_cast<std::int64_t>(e.triangles));
    ids.push_back(3 * cells.back());
  }
  write_list(file, "VTKHDF/NumberOfPoints", points);
  write_list(file, "VTKHDF/NumberOfCells", cells);
  write_list(file, "VTKHDF/NumberOfConnectivityIds", ids);
}

/// Where each step finds its part of each dataset. A reader of Offsets adds the number of the part by itself, for each
/// part has one entry more than cells.
void write_vtk_steps(FileContent& file, const Catalogue& c) {
  const std::string steps = "VTKHDF/Steps/";
  std::vector<double> times;
  for (const StepPlace& step : c.steps()) times.push_back(step.time);
  file.dataset(steps + "Values", H5T_NATIVE_DOUBLE, times.size(), 1, times.data());
  file.number("VTKHDF/Steps", "NSteps", static_cast<int>(times.size()));
  const auto triangle = [](const Catalogue& all, const StepPlace& s) {
    return static_cast<std::int64_t>(all.epochs()[s.epoch].triangle);
  };
  const std::vector<std::int64_t> cells = each(c, triangle);
  std::vector<std::int64_t> ids;
  for (const std::int64_t first : cells) ids.push_back(3 * first);
  write_list(file, steps + "PartOffsets",
             each(c, [](const Catalogue&, const StepPlace& s) { return static_cast<std::int64_t>(s.epoch); }));
  write_list(file, steps + "NumberOfParts", std::vector<std::int64_t>(times.size(), 1));
  write_list(file, steps + "PointOffsets",
             each(c, [](const Catalogue&, const StepPlace& s) { return static_cast<std::int64_t>(s.point); }));
  write_list(file, steps + "CellOffsets", cells, 2);  // steps x kinds of cells
  write_list(file, steps + "ConnectivityIdOffsets", ids, 2);
  for (const Array& a : c.arrays())
    write_list(file,
               steps + (a.centre == Centre::vertex ? "Point" : "Cell") + "DataOffsets/" +
                   a.table.path.substr(a.table.path.rfind('/') + 1),
               a.begin);
}

void write_own_steps(FileContent& file, const Catalogue& c) {
  std::vector<int> number, epoch;
  std::vector<double> time, load_factor, path, bodies;
  for (const StepPlace& step : c.steps()) {
    number.push_back(step.number);
    epoch.push_back(static_cast<int>(step.epoch));
    time.push_back(step.time);
    load_factor.push_back(step.load_factor);
    path.insert(path.end(), step.path.begin(), step.path.end());
    bodies.insert(bodies.end(), step.bodies.begin(), step.bodies.end());
  }
  const std::string steps = "voile/steps/";
  file.dataset(steps + "number", H5T_NATIVE_INT, number.size(), 1, number.data());
  file.dataset(steps + "epoch", H5T_NATIVE_INT, epoch.size(), 1, epoch.data());
  file.dataset(steps + "time", H5T_NATIVE_DOUBLE, time.size(), 1, time.data());
  file.dataset(steps + "load_factor", H5T_NATIVE_DOUBLE, load_factor.size(), 1, load_factor.data());
  if (!path.empty()) file.dataset(steps + "path", H5T_NATIVE_DOUBLE, path.size(), 1, path.data());
  if (!bodies.empty()) file.dataset(steps + "bodies", H5T_NATIVE_DOUBLE, bodies.size(), 1, bodies.data());
  for (const Array& a : c.arrays())
    if (a.is_field) file.dataset(steps + "has/" + a.name, H5T_NATIVE_UINT8, a.present.size(), 1, a.present.data());
}

void write_units(FileContent& file, const Catalogue& c) {
  file.text("VTKHDF/Points", "unit", c.length());
  for (const Array& a : c.arrays()) {
    file.text(a.table.path, "name", a.name);
    file.text(a.table.path, "centre", a.centre == Centre::vertex ? "vertex" : "triangle");
    if (a.is_field) file.text(a.table.path, "unit", a.unit);
  }
}

/// All that is neither a table nor the record of an epoch.
void write_small(FileContent& file, const Catalogue& c, bool complete) {
  file.numbers("VTKHDF", "Version", {2, 0});
  file.ascii("VTKHDF", "Type", "UnstructuredGrid");
  write_parts(file, c);
  // Without steps the file holds the mesh at rest.
  if (!c.steps().empty()) write_vtk_steps(file, c);
  write_own_steps(file, c);
  write_units(file, c);
  file.number("voile", "layout", layout_version);
  file.number("voile", "complete", complete ? 1 : 0);
}

/// Selects `rows` rows from `begin` on.
void select(hid_t space, std::size_t begin, std::size_t rows, std::size_t columns, const fs::path& file) {
  const std::array<hsize_t, 2> start{begin, 0}, count{rows, columns};
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0) fail_writing(file);
}

void set_no_value(hid_t how, Number number) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (number == Number::float64 || number == Number::float32) H5Pset_fill_value(how, H5T_NATIVE_DOUBLE, &none);
}

class IndexFile : public NewFile {
 public:
  explicit IndexFile(const fs::path& path) : NewFile(path) {}

  void virtual_dataset(const Table& t) {
    const Id space(plane(t.rows, t.columns), H5Sclose, temporary_);
    const Id how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, temporary_);
    set_no_value(how, t.number);
    for (const Piece& piece : t.pieces) {
      const Id source(plane(piece.rows, t.columns), H5Sclose, temporary_);
      select(space, piece.begin, piece.rows, t.columns, temporary_);
      if (H5Pset_virtual(how, space, piece.file.c_str(), piece.dataset.c_str(), source) < 0) fail_writing(temporary_);
    }
    H5Sselect_all(space);
    Id set(H5Dcreate2(*file_, t.path.c_str(), memory_type(t.number), space, parents(), how, H5P_DEFAULT), H5Dclose,
           temporary_);
    set.close();
  }
};

/// The file of all data, written directly: it can be larger than the memory.
class WholeFile : public FileContent {
 public:
  WholeFile(const fs::path& folder, const Catalogue& catalogue)
      : FileContent(folder / results_name), folder_(folder), catalogue_(catalogue) {
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, temporary_);
    H5Pset_file_locking(access, false, true);  // locks fail on some network drives
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    file_.emplace(H5Fcreate(temporary_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, temporary_);
  }

  /// The file has no name of its own yet.
  void write() {
    for (const Table* t : catalogue_.all_tables()) targets_.push_back(std::make_unique<Target>(*this, *t));
    std::map<std::string, std::vector<std::pair<Target*, const Piece*>>> by_file;
    for (const std::unique_ptr<Target>& target : targets_)
      for (const Piece& piece : target->table.pieces) by_file[piece.file].emplace_back(target.get(), &piece);
    for (const auto& [name, pieces] : by_file) {
      const Source source(folder_ / name);
      for (const auto& [target, piece] : pieces) target->copy(source, *piece);
    }
    for (std::size_t e = 0; e < catalogue_.epochs().size(); ++e)
      copy(Source(folder_ / epoch_file(e)), "mesh", epoch_path(e));
    if (fs::exists(folder_ / obstacle_file)) copy(Source(folder_ / obstacle_file), "obstacles", "voile/obstacles");
    for (const std::unique_ptr<Target>& target : targets_) target->set.close();
    write_small(*this, catalogue_, true);
    file_->close();
  }

 private:
  struct Source : public Hdf5Handle {
    explicit Source(const fs::path& file)
        : Hdf5Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose), name(file) {
      if (!valid()) fail();
    }
    [[noreturn]] void fail() const {
      throw UserError(fmt::format("{}: it cannot be read; was it changed from outside?", name.string()));
    }
    fs::path name;
  };

  struct Target {
    const Table& table;
    std::size_t chunk_rows;
    Id set;
    const fs::path& file;

    Target(WholeFile& whole, const Table& t)
        : table(t),
          chunk_rows(rows_of_chunk(t)),
          set(create(whole, t), H5Dclose, whole.temporary_),
          file(whole.temporary_) {}

    static std::size_t rows_of_chunk(const Table& t) {
      const std::size_t rows = t.pieces.empty() ? 1 : std::max<std::size_t>(1, t.pieces.front().rows);
      const std::size_t pieces = std::max<std::size_t>(1, least_chunk / (rows * t.columns * bytes_of(t.number)));
      return std::min({pieces * rows, most_rows(t.columns), std::max<std::size_t>(1, t.rows)});
    }

    hid_t create(WholeFile& whole, const Table& t) const {
      const Id space(plane(t.rows, t.columns), H5Sclose, whole.temporary_);
      const Id how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, whole.temporary_);
      const Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose, whole.temporary_);
      set_no_value(how, t.number);
      if (t.rows > 0) whole.checked_chunks(how, {chunk_rows, t.columns}, t.columns == 1 ? 1 : 2);
      // Steps that do not fill chunks exactly write parts of two.
      const std::size_t bytes = chunk_rows * t.columns * bytes_of(t.number);
      H5Pset_chunk_cache(access, H5D_CHUNK_CACHE_NSLOTS_DEFAULT, std::max<std::size_t>(1 << 20, 2 * bytes + 1),
                         H5D_CHUNK_CACHE_W0_DEFAULT);
      return H5Dcreate2(*whole.file_, t.path.c_str(), memory_type(t.number), space, whole.parents(), how, access);
    }

    void copy(const Source& from, const Piece& piece) {
      const Hdf5Handle source(H5Dopen2(from, piece.dataset.c_str(), H5P_DEFAULT), H5Dclose);
      if (!source.valid()) from.fail();
      if (piece.rows == chunk_rows && piece.begin % chunk_rows == 0) return copy_chunk(from, source, piece);
      const hid_t type = memory_type(table.number);
      std::vector<char> values(piece.rows * table.columns * bytes_of(table.number));
      const Id memory(plane(piece.rows, table.columns), H5Sclose, file), space(H5Dget_space(set), H5Sclose, file);
      select(space, piece.begin, piece.rows, table.columns, file);
      if (H5Dread(source, type, memory, H5S_ALL, H5P_DEFAULT, values.data()) < 0) from.fail();
      if (H5Dwrite(set, type, memory, space, H5P_DEFAULT, values.data()) < 0) fail_writing(file);
    }

    /// The bytes as they are, with their checksum.
    void copy_chunk(const Source& from, hid_t source, const Piece& piece) {
      const std::array<hsize_t, 2> zero{0, 0}, begin{piece.begin, 0};
      hsize_t size = 0;
      std::uint32_t filters = 0;
      if (H5Dget_chunk_storage_size(source, zero.data(), &size) < 0) from.fail();
      std::vector<char> bytes(size);
      if (H5Dread_chunk(source, H5P_DEFAULT, zero.data(), &filters, bytes.data()) < 0) from.fail();
      if (H5Dwrite_chunk(set, H5P_DEFAULT, filters, begin.data(), size, bytes.data()) < 0) fail_writing(file);
    }
  };

  const fs::path& folder_;
  const Catalogue& catalogue_;
  std::vector<std::unique_ptr<Target>> targets_;
};

/// What steps/ held may go only when this is on the disk.
void force_to_disk(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = descriptor >= 0 && fsync(descriptor) == 0;
  if (descriptor >= 0) close(descriptor);
  if (!done) fail_writing(file);
}

}  // namespace

void write_index(const fs::path& folder, const Catalogue& catalogue) {
  IndexFile file(folder / results_name);
  for (const Table* t : catalogue.all_tables()) file.virtual_dataset(*t);
  for (std::size_t e = 0; e < catalogue.epochs().size(); ++e) file.link(epoch_path(e), epoch_file(e), "mesh");
  if (fs::exists(folder / obstacle_file)) file.link("voile/obstacles", obstacle_file, "obstacles");
  write_small(file, catalogue, false);
  file.finish();
}

void consolidate(const fs::path& folder, const Catalogue& catalogue) {
  const fs::path file = folder / results_name, temporary = file.string() + ".part";
  std::error_code error;
  try {
    try_in_child(temporary.string(), [&] {
      const Silence silence;
      WholeFile(folder, catalogue).write();
      force_to_disk(temporary);
    });
    fs::rename(temporary, file);
  } catch (const std::exception& e) {
    fs::remove(temporary, error);
    throw UserError(
        fmt::format("{}: the steps could not be put into one file, for which as much room is needed again as {} takes; "
                    "nothing is lost: the results can be read as long as both stay together ({})",
                    file.string(), (folder / "steps").string(), e.what()));
  }
}

}  // namespace voile::results
