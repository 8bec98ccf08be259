// Results read back with HDF5 itself; the XDMF only names what exists; nothing is lost by a kill.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

#include "test_case_kit.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"
#include "voile/io/checkpoint.hpp"
#include "voile/io/results.hpp"
#include "voile/io/stored_step.hpp"

using namespace voile;
using namespace voile::testing;
namespace fs = std::filesystem;

namespace {

class Folder {
 public:
  Folder() : path(fs::temp_directory_path() / fmt::format("voile_results_{}", ::getpid())) { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const fs::path path;
};

/// n x n squares, each cut in two, with groups of all dimensions.
mesh::SurfaceMesh plate(Index n) {
  mesh::MeshData data;
  data.source = "plate";
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i) data.positions.emplace_back(i, j, 0.25 * i);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      data.triangles.push_back({a, b, d});
      data.triangles.push_back({a, d, c});
    }
  data.groups = {{"corner", 0, {0}, {}, {}},
                 {"x < 1 & \"y\"/2", 1, {0, 1}, {{0, 1}}, {}},
                 {"first", 2, {0, 1, n + 2}, {}, {0}},
                 {"first", 1, {0, 1}, {{0, 1}}, {}}};
  return mesh::SurfaceMesh(data);
}

std::vector<int> ramp(Index n) {
  std::vector<int> values;
  for (Index i = 0; i < n; ++i) values.push_back(i % 3);
  return values;
}

io::StepFields step(const mesh::SurfaceMesh& mesh, int number) {
  const auto values = [&](Index count, int components) {
    std::vector<double> v;
    for (Index i = 0; i < count * components; ++i) v.push_back(number + 0.001 * i);
    return v;
  };
  return {number,
          0.1 * number,
          0.2 * number,
          {{"displacement", "m", io::Centre::vertex, 3, values(mesh.vertex_count(), 3)},
           {"membrane_force", "N/m", io::Centre::triangle, 3, values(mesh.triangle_count(), 3)},
           {"thickness", "m", io::Centre::triangle, 1, values(mesh.triangle_count(), 1)},
           {"tensor", "1", io::Centre::vertex, 9, values(mesh.vertex_count(), 9)}}};
}

/// Values and shape of a data set, read with HDF5 alone. `shape` stays empty if there is none.
struct DataSet {
  std::vector<hsize_t> shape;
  std::vector<double> values;
};

DataSet read(const fs::path& file, const std::string& name) {
  DataSet result;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (f < 0) return result;
  const hid_t set = H5Dopen2(f, name.c_str(), H5P_DEFAULT);
  if (set >= 0) {
    const hid_t space = H5Dget_space(set);
    result.shape.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, result.shape.data(), nullptr);
    result.values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.values.data()) < 0) result.shape.clear();
    H5Sclose(space);
    H5Dclose(set);
  }
  H5Fclose(f);
  return result;
}

std::string text_attribute(const fs::path& file, const std::string& object, const char* name) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t a = H5Aopen_by_name(f, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Aget_type(a);
  std::string text(H5Tget_size(type), ' ');
  H5Aread(a, type, text.data());
  H5Tclose(type);
  H5Aclose(a);
  H5Fclose(f);
  return text;
}

/// A list of texts of one length.
std::vector<std::string> texts(const fs::path& file, const std::string& name) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen2(f, name.c_str(), H5P_DEFAULT);
  const hid_t type = H5Dget_type(set), space = H5Dget_space(set);
  const std::size_t width = H5Tget_size(type);
  std::string all(width * static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)), ' ');
  H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data());
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
  H5Fclose(f);
  std::vector<std::string> list;
  for (std::size_t at = 0; at < all.size(); at += width) list.emplace_back(all.substr(at, width).c_str());
  return list;
}

std::string read_text(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Every data item of the XDMF exists with the dimensions it claims. Returns how many there are.
int check_xdmf(const fs::path& folder, const char* name = "results.xdmf") {
  const std::string text = read_text(folder / name);
  int count = 0;
  const auto between = [&](const char* open, const char* close, std::size_t from) {
    const std::size_t begin = text.find(open, from) + std::string(open).size();
    return text.substr(begin, text.find(close, begin) - begin);
  };
  for (std::size_t at = text.find("<DataItem"); at != std::string::npos; at = text.find("<DataItem", at + 1), ++count) {
    const std::string size = between("Dimensions=\"", "\"", at), where = between("Format=\"HDF\">", "</DataItem>", at);
    CAPTURE(where);
    const std::size_t colon = where.find(':');
    REQUIRE(colon != std::string::npos);
    const DataSet set = read(folder / where.substr(0, colon), where.substr(colon + 1));
    REQUIRE(!set.shape.empty());
    CHECK(join(set.shape, " ") == size);
  }
  const auto occurrences = [&](const char* what) {
    int n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
  };
  CHECK(occurrences("<Grid") == occurrences("</Grid>"));
  return count;
}

/// A triangle and a square.
io::ObstacleTriangles obstacles(bool move) {
  return {{"body", "floor & \xc3\xb6"},
          {{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0}, {-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}},
          {{0, 1, 2}, {3, 4, 5}, {3, 5, 6}},
          {0, 1, 1},
          move};
}

/// Those at a step: everything lies higher by its number.
std::vector<Vec3> raised(int number) {
  std::vector<Vec3> points = obstacles(true).positions;
  for (Vec3& x : points) x[2] += number;
  return points;
}

std::vector<double> single(const std::vector<Vec3>& points) {
  std::vector<double> values;
  for (const Vec3& x : points)
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(x[k]));
  return values;
}

}  // namespace

TEST_CASE("mesh, groups and partition are there before the first step") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  const io::ResultsWriter writer(folder.path, mesh, ramp(9), ramp(8));
  const fs::path h5 = folder.path / "results.h5";
  const DataSet positions = read(h5, "/mesh/positions");
  CHECK(positions.shape == std::vector<hsize_t>{9, 3});
  CHECK(positions.values[3] == 1.0);
  CHECK(positions.values[5] == 0.25);
  CHECK(read(h5, "/mesh/triangles").values[2] == 4.0);
  CHECK(read(h5, "/mesh/partition/vertices").values[5] == 2.0);
  CHECK(read(h5, "/mesh/partition/triangles").shape == std::vector<hsize_t>{8});
  CHECK(read(h5, "/mesh/groups/corner").values == std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0, 0});
  CHECK(read(h5, "/mesh/groups/first").values == std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0});
  CHECK(read(h5, "/mesh/groups/first_").values == std::vector<double>{1, 1, 0, 0, 0, 0, 0, 0, 0});
  CHECK(text_attribute(h5, "/mesh/groups/x___1____y__2", "name") == "x < 1 & \"y\"/2");
  CHECK(text_attribute(h5, "/mesh/positions", "unit") == "m");
  CHECK(check_xdmf(folder.path) == 2 + 2 + 4);
  CHECK(has(read_text(folder.path / "results.xdmf"), "Name=\"group:x &lt; 1 &amp; &quot;y&quot;/2\""));
}

TEST_CASE("steps are readable through results.h5 and the XDMF after each write") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  io::ResultsWriter writer(folder.path, mesh, ramp(9), ramp(8));
  for (int number = 1; number <= 3; ++number) {
    const io::StepFields fields = step(mesh, number);
    writer.write(fields);
    CHECK(check_xdmf(folder.path) == number * (8 + 4));
    for (int k = 1; k <= number; ++k)
      for (const io::Field& field : step(mesh, k).fields) {
        const DataSet set = read(folder.path / "results.h5", fmt::format("/steps/{:06d}/{}", k, field.name));
        CHECK(set.values == field.values);
      }
  }
  const std::string xdmf = read_text(folder.path / "results.xdmf");
  CHECK(has(xdmf, "CollectionType=\"Temporal\""));
  CHECK(has(xdmf, "<Time Value=\"0.2\"/>"));
  CHECK(has(xdmf, "Name=\"displacement\" AttributeType=\"Vector\" Center=\"Node\""));
  CHECK(has(xdmf, "Name=\"membrane_force_11_22_12\" AttributeType=\"Matrix\" Center=\"Cell\""));
  CHECK(has(xdmf, "Name=\"thickness\" AttributeType=\"Scalar\" Center=\"Cell\""));
  CHECK(has(xdmf, "Name=\"tensor\" AttributeType=\"Tensor\" Center=\"Node\""));
  CHECK(text_attribute(folder.path / "results.h5", "/steps/000002/membrane_force", "unit") == "N/m");
  for (const auto& entry : fs::recursive_directory_iterator(folder.path)) CHECK(entry.path().extension() != ".part");
}

TEST_CASE("the results folder can be moved, and a new run removes the old steps") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  {
    io::ResultsWriter writer(folder.path / "a", mesh, ramp(4), ramp(2));
    writer.write(step(mesh, 1));
    writer.write(step(mesh, 2));
  }
  fs::rename(folder.path / "a", folder.path / "b");
  CHECK(read(folder.path / "b" / "results.h5", "/steps/000002/thickness").values.size() == 2);
  std::ofstream(folder.path / "b" / "steps" / "notes.h5") << "mine";
  const io::ResultsWriter again(folder.path / "b", mesh, ramp(4), ramp(2));
  CHECK(!fs::exists(folder.path / "b" / "steps" / "000001.h5"));
  CHECK(fs::exists(folder.path / "b" / "steps" / "notes.h5"));
  CHECK(read(folder.path / "b" / "results.h5", "/steps/000002/thickness").shape.empty());
}

TEST_CASE("obstacles that move have positions in every step and an XDMF of their own") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  const fs::path h5 = folder.path / "results.h5";
  io::ResultsWriter writer(folder.path, mesh, ramp(4), ramp(2), obstacles(true));
  CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3);
  CHECK(read(h5, "/obstacles/triangles").values == std::vector<double>{0, 1, 2, 3, 4, 5, 3, 5, 6});
  CHECK(read(h5, "/obstacles/obstacle").values == std::vector<double>{0, 1, 1});
  CHECK(read(h5, "/obstacles/positions").values == single(obstacles(true).positions));
  CHECK(text_attribute(h5, "/obstacles/positions", "unit") == "m");
  CHECK(texts(h5, "/obstacles/names") == obstacles(true).names);
  for (int number = 1; number <= 3; ++number) {
    io::StepFields fields = step(mesh, number);
    fields.obstacles = raised(number);
    writer.write(fields);
    CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3 * number);
    CHECK(read(h5, fmt::format("/steps/{:06d}/obstacle_positions", number)).values == single(raised(number)));
  }
  check_xdmf(folder.path);
  const std::string xdmf = read_text(folder.path / "obstacles.xdmf");
  CHECK(has(xdmf, "CollectionType=\"Temporal\""));
  CHECK(has(xdmf, "<Time Value=\"0.2\"/>"));
  CHECK(has(xdmf, "Name=\"obstacle\" AttributeType=\"Scalar\" Center=\"Cell\""));
  CHECK_THROWS_WITH_AS(writer.write(step(mesh, 4)), "0 positions for 7 vertices of obstacles", InternalError);
}

TEST_CASE("obstacles at rest are stored once; a run without them leaves none behind") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  {
    io::ResultsWriter writer(folder.path, mesh, ramp(4), ramp(2), obstacles(false));
    writer.write(step(mesh, 1));
    CHECK(read(folder.path / "results.h5", "/steps/000001/obstacle_positions").shape.empty());
    CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3);
    CHECK(!has(read_text(folder.path / "obstacles.xdmf"), "<Time"));
  }
  const io::ResultsWriter again(folder.path, mesh, ramp(4), ramp(2));
  CHECK(!fs::exists(folder.path / "obstacles.xdmf"));
  CHECK(read(folder.path / "results.h5", "/obstacles/positions").shape.empty());
}

TEST_CASE("failures have a message") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  fs::create_directories(folder.path);
  std::ofstream(folder.path / "file") << "x";
  CHECK_THROWS_AS(io::ResultsWriter(folder.path / "file", mesh, ramp(4), ramp(2)), UserError);
  CHECK_THROWS_AS(io::ResultsWriter(folder.path, mesh, ramp(3), ramp(2)), InternalError);
  io::ResultsWriter writer(folder.path / "r", mesh, ramp(4), ramp(2));
  io::StepFields fields = step(mesh, 1);
  fields.fields[0].values.pop_back();
  CHECK_THROWS_WITH_AS(writer.write(fields), "field 'displacement' has 11 values instead of 4 x 3", InternalError);
  fs::remove_all(folder.path / "r");
  CHECK_THROWS_AS(writer.write(step(mesh, 1)), UserError);
  CHECK_THROWS_AS(io::HistoryWriter(folder.path / "none" / "history.csv", {"a"}), UserError);
}

TEST_CASE("a killed process leaves every finished step readable") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(10);
  for (int attempt = 0; attempt < 8; ++attempt) {
    std::array<int, 2> pipe_ends{};
    REQUIRE(pipe(pipe_ends.data()) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      io::ResultsWriter writer(folder.path, mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()),
                               obstacles(true));
      for (int number = 1;; ++number) {
        io::StepFields fields = step(mesh, number);
        fields.obstacles = raised(number);
        writer.write(fields);
        if (::write(pipe_ends[1], &number, sizeof number) < 0) _exit(1);
      }
    }
    close(pipe_ends[1]);
    int last = 0;
    REQUIRE(::read(pipe_ends[0], &last, sizeof last) == sizeof last);
    std::this_thread::sleep_for(std::chrono::microseconds(3000 + 1700 * attempt));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    while (::read(pipe_ends[0], &last, sizeof last) == sizeof last) {
    }
    close(pipe_ends[0]);
    CAPTURE(last);
    check_xdmf(folder.path);
    CHECK(check_xdmf(folder.path, "obstacles.xdmf") >= 3 * last);
    for (int k = 1; k <= last; ++k)
      CHECK(read(folder.path / "results.h5", fmt::format("/steps/{:06d}/displacement", k)).values ==
            step(mesh, k).fields[0].values);
  }
}

TEST_CASE("naming steps costs no more than writing them, and a restart finds those not named yet") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  const fs::path index = folder.path / "results.h5";
  const auto inode = [&] {
    struct stat s {};
    REQUIRE(stat(index.c_str(), &s) == 0);
    return s.st_ino;
  };
  std::size_t rewritten = 0;
  constexpr int steps = 600;
  {
    io::ResultsWriter writer(folder.path, mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
    for (int n = 0; n < steps; ++n) {
      const auto before = inode();
      writer.write(step(mesh, n));
      rewritten += inode() != before ? 1 : 0;
      const io::StoredStep last = io::read_step(index, -1, mesh);
      CHECK(last.step == n);
      CHECK(last.displacement == step(mesh, n).fields[0].values);
    }
  }
  MESSAGE(rewritten << " times for " << steps << " steps");
  CHECK(rewritten >= 64);
  CHECK(rewritten < 64 + steps / 6);
  CHECK(check_xdmf(folder.path) >= steps);
  CHECK(read(index, fmt::format("/steps/{:06d}/displacement", steps - 1)).values ==
        step(mesh, steps - 1).fields[0].values);
}

TEST_CASE("history numbers read back exactly, each line at once") {
  const Folder folder;
  fs::create_directories(folder.path);
  const fs::path file = folder.path / "history.csv";
  io::HistoryWriter history(file, {"step", "load factor", "tip_z"});
  CHECK(read_text(file) == "step,load factor,tip_z\n");
  history.write({1, 0.1, 1.0 / 3.0});
  CHECK(read_text(file) == "step,load factor,tip_z\n1,0.1,0.3333333333333333\n");
  CHECK(std::stod("0.3333333333333333") == 1.0 / 3.0);
  history.write({2, 1e-300, -2.5});
  CHECK(has(read_text(file), "2,1e-300,-2.5\n"));
  history.write({3, std::nan(""), INFINITY});
  CHECK(has(read_text(file), "\n3,,\n"));
  CHECK_THROWS_AS(history.write({1.0}), InternalError);
}

TEST_CASE("a stored step is read back with the one before it, and only into its own mesh") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(3), other = plate(4);
  io::ResultsWriter writer(folder.path, mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
  for (int n : {0, 2, 7}) writer.write(step(mesh, n));
  const fs::path file = folder.path / "results.h5";
  const io::StoredStep last = io::read_step(file, -1, mesh), first = io::read_step(file, 0, mesh);
  CHECK(last.step == 7);
  CHECK(last.load_factor == 0.2 * 7);
  CHECK(last.displacement == step(mesh, 7).fields[0].values);
  CHECK(last.previous == step(mesh, 2).fields[0].values);
  CHECK(first.step == 0);
  CHECK(first.previous.empty());
  CHECK_THROWS_AS((void)io::read_step(file, 3, mesh), UserError);
  CHECK_THROWS_AS((void)io::read_step(file, -1, other), UserError);
  CHECK_THROWS_AS((void)io::read_step(folder.path / "none.h5", -1, mesh), UserError);
}

TEST_CASE("a results.h5 without its steps/ names the file that is missing") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  io::ResultsWriter writer(folder.path, mesh, ramp(4), ramp(2));
  for (int n : {1, 2}) writer.write(step(mesh, n));
  const fs::path copy = folder.path / "copy";
  fs::create_directories(copy / "steps");
  fs::copy_file(folder.path / "results.h5", copy / "results.h5");
  const auto error = [&](int n) { return error_of([&] { (void)io::read_step(copy / "results.h5", n, mesh); }); };
  CHECK(has(error(1), "'steps/000001' is a link to steps/000001.h5 beside it, which is missing"));
  CHECK(has(error(-1), "'steps/000002' is a link to steps/000002.h5 beside it"));
  CHECK(has(error(1), "copy the folder steps/ together with results.h5"));
  fs::copy_file(folder.path / "steps" / "000002.h5", copy / "steps" / "000002.h5");
  CHECK(has(error(2), "'steps/000001' is a link to steps/000001.h5"));  // the step before is needed, too
  fs::copy_file(folder.path / "steps" / "000001.h5", copy / "steps" / "000001.h5");
  CHECK(error(2) == "no error");
}

TEST_CASE("a checkpoint comes back bit by bit, and only into its own mesh") {
  const Folder folder;
  fs::create_directories(folder.path);
  const mesh::SurfaceMesh mesh = plate(3);
  const fs::path file = folder.path / "checkpoint.h5";
  io::Checkpoint c{12, 0.1 + 0.2, 1.0 / 3.0, {}, {}, {}};
  for (Index i = 0; i < 3 * mesh.vertex_count(); ++i) {
    c.displacement.push_back(1.0 / (i + 1));
    c.velocity.push_back(-0.1 * i);
    c.acceleration.push_back(1e-17 * i);
  }
  io::write_checkpoint(file, c, mesh);
  io::Checkpoint back = io::read_checkpoint(file, mesh);
  CHECK(back.step == 12);
  CHECK(back.time == c.time);
  CHECK(back.next_step == c.next_step);
  CHECK(back.displacement == c.displacement);
  CHECK(back.velocity == c.velocity);
  CHECK(back.acceleration == c.acceleration);
  {  // one bit in the middle of the velocities
    std::string bytes = read_text(file);
    const std::string value(reinterpret_cast<const char*>(&c.velocity[7]), sizeof(double));
    const std::size_t at = bytes.find(value);
    REQUIRE(at != std::string::npos);
    bytes[at + 6] = static_cast<char>(bytes[at + 6] ^ 0x10);
    std::ofstream(file, std::ios::binary) << bytes;
    CHECK(has(error_of([&] { (void)io::read_checkpoint(file, mesh); }), "its checksum does not fit"));
  }
  c.velocity[3] = INFINITY;
  io::write_checkpoint(file, c, mesh);
  CHECK(has(error_of([&] { (void)io::read_checkpoint(file, mesh); }), "'velocity' holds numbers that are not finite"));
  c.velocity[3] = 0.0;
  c.acceleration.clear();
  io::write_checkpoint(file, c, mesh);
  CHECK(io::read_checkpoint(file, mesh).acceleration.empty());
  CHECK_THROWS_AS((void)io::read_checkpoint(file, plate(4)), UserError);
  std::ofstream(file) << "not HDF5";
  CHECK_THROWS_AS((void)io::read_checkpoint(file, mesh), UserError);
}
