// Results as they are laid out, read back with HDF5 itself by the rules of VTKHDF; the XDMF only names what exists.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "test_results_kit.hpp"

namespace test_results {

using namespace voile;
using namespace voile::testing;

namespace {

/// Every step of `count` equals what was written, through the arrays of VTKHDF.
void check_steps(const fs::path& file, const mesh::SurfaceMesh& mesh, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const results::StepFields wanted = step(mesh, static_cast<int>(i) + 1);
    const VtkStep got = vtk_step(file, i);
    CAPTURE(i);
    CHECK(got.time == wanted.time);
    CHECK(got.points == moved(mesh, wanted));
    CHECK(got.connectivity == corners(mesh));
    CHECK(got.offsets.front() == 0.0);
    CHECK(got.offsets.back() == 3.0 * mesh.triangle_count());
    CHECK(got.types == std::vector<double>(mesh.triangles().size(), 5.0));
    CHECK(vtk_array(file, i, "PointData/displacement") == wanted.fields[0].values);
    CHECK(vtk_array(file, i, "CellData/membrane_force_11_22_12") == wanted.fields[1].values);
    CHECK(vtk_array(file, i, "CellData/thickness") == wanted.fields[2].values);
    CHECK(vtk_array(file, i, "PointData/tensor") == wanted.fields[3].values);
  }
}

bool all_nan(const std::vector<double>& values) {
  return !values.empty() && std::all_of(values.begin(), values.end(), [](double x) { return std::isnan(x); });
}

std::vector<double> numbers(const std::vector<int>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

TEST_CASE("mesh, groups and partition are there before the first step") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  const results::ResultsWriter writer = begin(folder.path, mesh);
  const fs::path h5 = folder.path / "results.vtkhdf";
  const DataSet positions = read(h5, "/voile/epochs/000000/positions");
  CHECK(positions.shape == std::vector<hsize_t>{9, 3});
  CHECK(positions.values[3] == 1.0);
  CHECK(positions.values[5] == 0.25);
  CHECK(read(h5, "/voile/epochs/000000/triangles").values == corners(mesh));
  CHECK(read(h5, "/VTKHDF/Connectivity").values == corners(mesh));
  CHECK(read(h5, "/VTKHDF/PointData/partition").values == numbers(ramp(9)));
  CHECK(read(h5, "/VTKHDF/CellData/partition").shape == std::vector<hsize_t>{8});
  CHECK(read(h5, "/VTKHDF/PointData/group_corner").values == std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0, 0});
  CHECK(read(h5, "/VTKHDF/CellData/group_first").values == std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0});
  CHECK(read(h5, "/VTKHDF/PointData/group_first_").values == std::vector<double>{1, 1, 0, 0, 0, 0, 0, 0, 0});
  CHECK(text_attribute(h5, "/VTKHDF/PointData/group_x___1____y__2", "name") == "group:x < 1 & \"y\"/2");
  CHECK(text_attribute(h5, "/voile/epochs/000000/groups/000001", "name") == "x < 1 & \"y\"/2");
  CHECK(text_attribute(h5, "/voile/epochs/000000/positions", "unit") == "m");
  CHECK(text_attribute(h5, "/VTKHDF", "Type") == "UnstructuredGrid");
  CHECK(is_ascii(h5, "/VTKHDF", "Type"));  // ParaView 5.11 takes no other
  CHECK(check_xdmf(folder.path) == 2 + 2 + 4);
  CHECK(has(read_text(folder.path / "results.xdmf"), "Name=\"group:x &lt; 1 &amp; &quot;y&quot;/2\""));
  CHECK(has(join(writer.renamed_groups(), "; "), "'x < 1 & \"y\"/2' is /VTKHDF/PointData/group_x___1____y__2"));
}

TEST_CASE("steps are readable through VTKHDF and the XDMF after each write, and in one file at the end") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  const fs::path h5 = folder.path / "results.vtkhdf";
  results::ResultsWriter writer = begin(folder.path, mesh);
  for (int number = 1; number <= 3; ++number) {
    writer.write(step(mesh, number));
    writer.flush();
    CHECK(check_xdmf(folder.path) == number * (8 + 4));
    check_steps(h5, mesh, static_cast<std::size_t>(number));
  }
  const std::string xdmf = read_text(folder.path / "results.xdmf");
  CHECK(has(xdmf, "CollectionType=\"Temporal\""));
  CHECK(has(xdmf, "<Time Value=\"0.2\"/>"));
  CHECK(has(xdmf, "Name=\"displacement\" AttributeType=\"Vector\" Center=\"Node\""));
  CHECK(has(xdmf, "Name=\"membrane_force_11_22_12\" AttributeType=\"Matrix\" Center=\"Cell\""));
  CHECK(has(xdmf, "Name=\"thickness\" AttributeType=\"Scalar\" Center=\"Cell\""));
  CHECK(has(xdmf, "Name=\"tensor\" AttributeType=\"Tensor\" Center=\"Node\""));
  CHECK(text_attribute(h5, "/VTKHDF/CellData/membrane_force_11_22_12", "unit") == "N/m");
  CHECK(read(h5, "/voile/steps/load_factor").values == std::vector<double>{0.2 * 1, 0.2 * 2, 0.2 * 3});
  CHECK(read(h5, "/VTKHDF/Steps/CellOffsets").shape == std::vector<hsize_t>{3, 1});
  CHECK(fs::exists(folder.path / "steps"));
  writer.finish();
  CHECK(!fs::exists(folder.path / "steps"));
  CHECK(read_text(folder.path / "results.xdmf") == xdmf);
  CHECK(check_xdmf(folder.path) == 3 * (8 + 4));
  CHECK_THROWS_AS(writer.write(step(mesh, 4)), InternalError);
  fs::create_directories(folder.path / "elsewhere");
  fs::rename(h5, folder.path / "elsewhere" / "copy.vtkhdf");
  check_steps(folder.path / "elsewhere" / "copy.vtkhdf", mesh, 3);
  CHECK(read(folder.path / "elsewhere" / "copy.vtkhdf", "/voile/epochs/000000/positions").shape.size() == 2);
  CHECK(text_attribute(folder.path / "elsewhere" / "copy.vtkhdf", "/VTKHDF/PointData/displacement", "unit") == "m");
  for (const auto& entry : fs::recursive_directory_iterator(folder.path)) CHECK(entry.path().extension() != ".part");
}

TEST_CASE("datasets of many steps are put together whatever the size of a step") {
  const Folder folder;
  for (const Index n : {1, 2, 70}) {  // steps much smaller than a chunk, not a whole number of them, and one each
    const mesh::SurfaceMesh mesh = plate(n);
    const int count = n == 70 ? 3 : 200;
    {
      results::ResultsWriter writer = begin(folder.path, mesh);
      for (int number = 1; number <= count; ++number) writer.write(step(mesh, number));
      writer.finish();
    }
    const DataSet all = read(folder.path / "results.vtkhdf", "/VTKHDF/CellData/membrane_force_11_22_12");
    CAPTURE(n);
    for (int number = 1; number <= count; ++number)
      CHECK(rows(all, (number - 1) * mesh.triangle_count(), mesh.triangle_count()) ==
            step(mesh, number).fields[1].values);
  }
}

TEST_CASE("steps of a chunk's size that begin within a chunk are put together, too") {
  const Folder folder;
  const mesh::SurfaceMesh large = plate(70), small = plate(3);
  const fs::path h5 = folder.path / "results.vtkhdf";
  {
    results::ResultsWriter writer(folder.path);
    for (const auto& [mesh, number] : {std::pair{&large, 1}, {&small, 2}, {&large, 3}}) {
      writer.begin_epoch(*mesh, ramp(mesh->vertex_count()), ramp(mesh->triangle_count()));
      writer.write(step(*mesh, number));
    }
    writer.finish();
  }
  CHECK(vtk_array(h5, 0, "PointData/displacement") == step(large, 1).fields[0].values);
  CHECK(vtk_array(h5, 1, "PointData/displacement") == step(small, 2).fields[0].values);
  CHECK(vtk_array(h5, 2, "PointData/displacement") == step(large, 3).fields[0].values);
  CHECK(vtk_step(h5, 2).points == moved(large, step(large, 3)));
}

TEST_CASE("a mesh may change between steps") {
  const Folder folder;
  const mesh::SurfaceMesh coarse = plate(2), fine = plate(5);
  const fs::path h5 = folder.path / "results.vtkhdf";
  results::ResultsWriter writer = begin(folder.path, coarse);
  writer.write(step(coarse, 1));
  writer.write(step(coarse, 2));
  writer.begin_epoch(fine, ramp(fine.vertex_count()), ramp(fine.triangle_count()));
  writer.write(step(fine, 3));
  writer.begin_epoch(coarse, ramp(9), ramp(8));
  writer.write(step(coarse, 4));
  writer.flush();
  const auto check = [&] {
    check_steps(h5, coarse, 2);
    const VtkStep third = vtk_step(h5, 2), fourth = vtk_step(h5, 3);
    CHECK(third.points == moved(fine, step(fine, 3)));
    CHECK(third.connectivity == corners(fine));
    CHECK(third.offsets[1] == 3.0);
    CHECK(third.offsets.back() == 3.0 * fine.triangle_count());
    CHECK(vtk_array(h5, 2, "PointData/tensor") == step(fine, 3).fields[3].values);
    CHECK(vtk_array(h5, 2, "CellData/partition") == numbers(ramp(fine.triangle_count())));
    CHECK(vtk_array(h5, 2, "PointData/group_first_")[1] == 1.0);
    CHECK(fourth.points == moved(coarse, step(coarse, 4)));
    CHECK(fourth.connectivity == corners(coarse));
    CHECK(vtk_array(h5, 3, "CellData/thickness") == step(coarse, 4).fields[2].values);
    CHECK(read(h5, "/VTKHDF/Connectivity").shape[0] == 3 * (8 + 50 + 8));  // once per mesh, not per step
    CHECK(read(h5, "/voile/steps/epoch").values == std::vector<double>{0, 0, 1, 2});
    CHECK(read(h5, "/voile/epochs/000001/triangles").values == corners(fine));
    CHECK(check_xdmf(folder.path) == 4 * (8 + 4));
  };
  check();
  writer.finish();
  check();
}

TEST_CASE("a field that a step does not have is not a number there, and a group that a mesh does not have is empty") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  mesh::MeshData other = plate(3).data();
  other.groups = {{"new", 0, {3}, {}, {}}};
  const mesh::SurfaceMesh second(other);
  const fs::path h5 = folder.path / "results.vtkhdf";
  results::ResultsWriter writer = begin(folder.path, mesh);
  const auto without = [](results::StepFields fields, std::size_t i) {
    fields.fields.erase(fields.fields.begin() + static_cast<std::ptrdiff_t>(i));
    return fields;
  };
  writer.write(without(step(mesh, 1), 3));  // the tensor comes later
  writer.write(step(mesh, 2));
  writer.write(without(step(mesh, 3), 0));  // no displacement: the vertices are where they rest
  writer.begin_epoch(second, ramp(16), ramp(18));
  writer.write(without(step(second, 4), 2));
  writer.flush();
  const auto check = [&] {
    CHECK(all_nan(vtk_array(h5, 0, "PointData/tensor")));
    CHECK(vtk_array(h5, 1, "PointData/tensor") == step(mesh, 2).fields[3].values);
    CHECK(all_nan(vtk_array(h5, 2, "PointData/displacement")));
    CHECK(vtk_step(h5, 2).points == single(mesh.positions()));
    CHECK(vtk_array(h5, 3, "PointData/displacement") == step(second, 4).fields[0].values);
    CHECK(all_nan(vtk_array(h5, 3, "CellData/thickness")));
    CHECK(vtk_array(h5, 3, "CellData/thickness").size() == 18);
    CHECK(vtk_array(h5, 3, "PointData/group_corner") == std::vector<double>(16, 0.0));
    CHECK(vtk_array(h5, 3, "PointData/group_new")[3] == 1.0);
    CHECK(vtk_array(h5, 1, "PointData/group_new") == std::vector<double>(9, 0.0));
    CHECK(read(h5, "/voile/steps/has/tensor").values == std::vector<double>{0, 1, 1, 1});
    CHECK(read(h5, "/voile/steps/has/thickness").values == std::vector<double>{1, 1, 1, 0});
    check_xdmf(folder.path);
  };
  check();
  writer.finish();
  check();
  const std::string xdmf = read_text(folder.path / "results.xdmf");
  CHECK(!has(between(xdmf, "Name=\"step 1\"", "</Grid>", 0), "tensor"));
  CHECK(has(between(xdmf, "Name=\"step 2\"", "</Grid>", 0), "tensor"));
}

TEST_CASE("the folder of a run that goes on can be moved, and a new run removes the old steps") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  const auto b = folder.path / "b";
  {
    results::ResultsWriter writer = begin(folder.path / "a", mesh);
    writer.write(step(mesh, 1));
    writer.write(step(mesh, 2));
    writer.flush();
    fs::rename(folder.path / "a", b);
    CHECK(vtk_array(b / "results.vtkhdf", 1, "CellData/thickness") == step(mesh, 2).fields[2].values);
    fs::create_directories(folder.path / "a");  // nothing can be put together here
  }
  std::ofstream(b / "steps" / "notes.h5") << "mine";
  const results::ResultsWriter again = begin(b, mesh);
  CHECK(!fs::exists(b / "steps" / "000001.h5"));
  CHECK(fs::exists(b / "steps" / "notes.h5"));
  CHECK(read(b / "results.vtkhdf", "/VTKHDF/CellData/thickness").shape.empty());
}

TEST_CASE("obstacles that move have positions in every step and an XDMF of their own") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  const fs::path h5 = folder.path / "results.vtkhdf";
  results::ResultsWriter writer = begin(folder.path, mesh, obstacles(true));
  CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3);
  const auto check = [&](int steps) {
    CHECK(read(h5, "/voile/obstacles/triangles").values == std::vector<double>{0, 1, 2, 3, 4, 5, 3, 5, 6});
    CHECK(read(h5, "/voile/obstacles/obstacle").values == std::vector<double>{0, 1, 1});
    CHECK(read(h5, "/voile/obstacles/positions").values == single(obstacles(true).positions));
    CHECK(text_attribute(h5, "/voile/obstacles/positions", "unit") == "m");
    CHECK(texts(h5, "/voile/obstacles/names") == obstacles(true).names);
    CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3 * steps);
    const DataSet positions = read(h5, "/voile/steps/obstacle_positions");
    for (int n = 1; n <= steps; ++n) CHECK(rows(positions, 7 * (n - 1), 7) == single(raised(n)));
  };
  for (int number = 1; number <= 3; ++number) {
    results::StepFields fields = step(mesh, number);
    fields.obstacles = raised(number);
    writer.write(fields);
    writer.flush();
    check(number);
  }
  check_xdmf(folder.path);
  const std::string xdmf = read_text(folder.path / "obstacles.xdmf");
  CHECK(has(xdmf, "CollectionType=\"Temporal\""));
  CHECK(has(xdmf, "<Time Value=\"0.2\"/>"));
  CHECK(has(xdmf, "Name=\"obstacle\" AttributeType=\"Scalar\" Center=\"Cell\""));
  CHECK_THROWS_WITH_AS(writer.write(step(mesh, 4)), "0 positions for 7 vertices of obstacles", InternalError);
  writer.finish();
  check(3);
}

TEST_CASE("obstacles at rest are stored once; a run without them leaves none behind") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  {
    results::ResultsWriter writer = begin(folder.path, mesh, obstacles(false));
    writer.write(step(mesh, 1));
    CHECK(read(folder.path / "results.vtkhdf", "/voile/steps/obstacle_positions").shape.empty());
    CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3);
    CHECK(!has(read_text(folder.path / "obstacles.xdmf"), "<Time"));
    writer.finish();
    CHECK(check_xdmf(folder.path, "obstacles.xdmf") == 3);
  }
  const results::ResultsWriter again = begin(folder.path, mesh);
  CHECK(!fs::exists(folder.path / "obstacles.xdmf"));
  CHECK(read(folder.path / "results.vtkhdf", "/voile/obstacles/positions").shape.empty());
}

TEST_CASE("failures have a message") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  fs::create_directories(folder.path);
  std::ofstream(folder.path / "file") << "x";
  CHECK_THROWS_AS(results::ResultsWriter(folder.path / "file"), UserError);
  CHECK_THROWS_AS(results::ResultsWriter(folder.path).begin_epoch(mesh, ramp(3), ramp(2)), InternalError);
  CHECK_THROWS_AS(results::ResultsWriter(folder.path).write(step(mesh, 1)), InternalError);
  results::ResultsWriter writer = begin(folder.path / "r", mesh);
  results::StepFields fields = step(mesh, 1);
  fields.fields[0].values.pop_back();
  CHECK_THROWS_WITH_AS(writer.write(fields), "field 'displacement' has 11 values instead of 4 x 3", InternalError);
  fs::remove_all(folder.path / "r");
  CHECK_THROWS_AS(writer.write(step(mesh, 1)), UserError);
  CHECK_THROWS_AS(results::HistoryWriter(folder.path / "none" / "history.csv", {"a"}), UserError);
}

TEST_CASE("names of steps are renewed twenty times their own cost apart, and at once for a step that comes late") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  const fs::path index = folder.path / "results.vtkhdf";
  // Each look at the clock is a millisecond later than the one before: so are a step and a renewal.
  std::chrono::steady_clock::time_point now{};
  results::ResultsWriter writer(folder.path, {}, "m", [&] { return now += std::chrono::milliseconds(1); });
  writer.begin_epoch(mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
  const auto named = [&] { return read(index, "/voile/steps/number").values.size(); };
  int steps = 0;
  for (const std::size_t wanted : {0, 20, 40, 60}) {
    CHECK(named() == wanted);
    for (int i = 0; i < 19; ++i) writer.write(step(mesh, steps++));
    CHECK(named() == wanted);
    writer.write(step(mesh, steps++));
    CHECK(named() == wanted + 20);
  }
  for (int i = 0; i < 3; ++i) writer.write(step(mesh, steps++));
  CHECK(named() == 80);
  now += std::chrono::milliseconds(20);
  writer.write(step(mesh, steps++));
  CHECK(named() == 84);
  writer.write(step(mesh, steps++));
  CHECK(named() == 84);
  writer.flush();
  CHECK(named() == 85);
  CHECK(vtk_array(index, 84, "PointData/displacement") == step(mesh, 84).fields[0].values);
}

/// For tests/check_paraview.py: VOILE_SAMPLE_RESULTS=FOLDER.
TEST_CASE("results of three meshes with moving obstacles, ended and killed, for other readers") {
  const char* given = std::getenv("VOILE_SAMPLE_RESULTS");
  if (!given) return;
  const std::vector<mesh::SurfaceMesh> meshes{plate(3), plate(7), plate(2)};
  const auto write = [&](results::ResultsWriter& writer) {
    for (int number = 1; number <= 9; ++number) {
      const mesh::SurfaceMesh& mesh = meshes[static_cast<std::size_t>((number - 1) / 3)];
      if (number % 3 == 1) writer.begin_epoch(mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
      results::StepFields fields = step(mesh, number);
      fields.obstacles = raised(number);
      if (number % 2 == 0) fields.fields.pop_back();  // the tensor
      writer.write(fields);
    }
  };
  const fs::path ended = fs::path(given) / "ended", killed = fs::path(given) / "killed";
  fs::remove_all(killed);
  results::ResultsWriter writer(ended, obstacles(true));
  write(writer);
  writer.flush();
  fs::copy(ended, killed, fs::copy_options::recursive);
}

TEST_CASE("history numbers read back exactly, each line at once") {
  const Folder folder;
  fs::create_directories(folder.path);
  const fs::path file = folder.path / "history.csv";
  results::HistoryWriter history(file, {"step", "load factor", "tip_z"});
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

}  // namespace test_results
