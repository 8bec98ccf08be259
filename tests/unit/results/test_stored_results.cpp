// Nothing is lost by a kill or a full disk, and steps, meshes and checkpoints are read back.
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <thread>

#include "results/checkpoint.hpp"
#include "results/stored_step.hpp"
#include "test_results_kit.hpp"

namespace test_stored_results {

using namespace voile;
using namespace voile::testing;

namespace {

/// Calls `work` in a process of its own, which gets a pipe, and kills it some microseconds after the first number came.
/// Returns the last number that it sent.
int last_before_kill(const std::function<void(int)>& work, int microseconds) {
  // A fork can find a lock that another thread, of MPI's, held at that moment: such a child says nothing, and another is tried.
  for (int attempt = 0; attempt < 5; ++attempt) {
    std::array<int, 2> ends{};
    REQUIRE(pipe(ends.data()) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
      work(ends[1]);
      _exit(0);
    }
    close(ends[1]);
    int last = -1;
    pollfd first{ends[0], POLLIN, 0};
    const bool came = poll(&first, 1, 15000) == 1 && ::read(ends[0], &last, sizeof last) == sizeof last;
    if (came) std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    while (::read(ends[0], &last, sizeof last) == sizeof last) {
    }
    close(ends[0]);
    if (came) return last;
  }
  FAIL("five processes in a row wrote nothing within 15 s each");
  return -1;
}

void send(int descriptor, int number) {
  if (::write(descriptor, &number, sizeof number) < 0) _exit(1);
}

/// Meshes change every five steps.
const mesh::SurfaceMesh& mesh_of(int number) {
  static const std::array<mesh::SurfaceMesh, 2> meshes{plate(10), plate(7)};
  return meshes[static_cast<std::size_t>(number / 5 % 2)];
}

results::StepFields changing_step(int number) {
  results::StepFields fields = step(mesh_of(number), number);
  fields.obstacles = raised(number);
  return fields;
}

void write_until_killed(const fs::path& folder, int pipe_end, int last) {
  results::ResultsWriter writer(folder, obstacles(true));
  for (int number = 0; number <= last; ++number) {
    const mesh::SurfaceMesh& mesh = mesh_of(number);
    if (number % 5 == 0) writer.begin_epoch(mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
    writer.write(changing_step(number));
    send(pipe_end, number);
  }
  writer.finish();
  send(pipe_end, last + 1);
}

/// All steps up to `last` are there, for HDF5 alone (up to the index) and for our reader.
void check_all(const fs::path& folder, int last) {
  const fs::path file = folder / "results.vtkhdf";
  CAPTURE(last);
  check_xdmf(folder);
  check_xdmf(folder, "obstacles.xdmf");
  const DataSet named = read(file, "/voile/steps/number");
  REQUIRE(!named.shape.empty());
  const DataSet points = read(file, "/VTKHDF/Points"), thickness = read(file, "/VTKHDF/CellData/thickness"),
                point = read(file, "/VTKHDF/Steps/PointOffsets"),
                cell = read(file, "/VTKHDF/Steps/CellDataOffsets/thickness");
  for (std::size_t i = 0; i < named.values.size(); ++i) {
    const mesh::SurfaceMesh& mesh = mesh_of(static_cast<int>(i));
    const results::StepFields wanted = step(mesh, static_cast<int>(i));
    CHECK(rows(points, point.values[i], mesh.vertex_count()) == moved(mesh, wanted));
    CHECK(rows(thickness, cell.values[i], mesh.triangle_count()) == wanted.fields[2].values);
  }
  for (int k = last; k >= 0 && k > last - 4; --k) {
    const results::StoredStep stored = results::read_step(file, k, mesh_of(k));
    CHECK(stored.displacement == step(mesh_of(k), k).fields[0].values);
    CHECK(stored.previous.empty() == (k % 5 == 0));
  }
  CHECK(results::read_step_mesh(file, last).triangles == mesh_of(last).triangles());
}

/// More than a quick test needs: VOILE_KILLS=300.
int kills(int few) {
  const char* text = std::getenv("VOILE_KILLS");
  return text ? std::atoi(text) : few;
}

}  // namespace

TEST_CASE("a killed process leaves every finished step readable") {
  const Folder folder;
  const int count = kills(8);
  for (int attempt = 0; attempt < count; ++attempt) {
    const int last = last_before_kill([&](int pipe_end) { write_until_killed(folder.path, pipe_end, 1 << 20); },
                                      3000 + 1777 * attempt % 211 * 997);
    check_all(folder.path, last);
  }
}

TEST_CASE("a process killed while it puts its steps into one file loses none") {
  const Folder folder;
  constexpr int last = 30;
  for (int attempt = 0; attempt < kills(8); ++attempt) {
    const auto finish = [&](int pipe_end) {
      std::array<int, 2> inner{};
      if (pipe(inner.data()) != 0) _exit(1);
      results::ResultsWriter writer(folder.path, obstacles(true));
      for (int number = 0; number <= last; ++number) {
        const mesh::SurfaceMesh& mesh = mesh_of(number);
        if (number % 5 == 0) writer.begin_epoch(mesh, ramp(mesh.vertex_count()), ramp(mesh.triangle_count()));
        writer.write(changing_step(number));
      }
      send(pipe_end, last);
      writer.finish();
      for (;;) pause();
    };
    CHECK(last_before_kill(finish, 100 + 1511 * attempt % 37 * 1000) == last);
    check_all(folder.path, last);
  }
}

TEST_CASE("a full disk is said, and what was there stays readable") {
  const Folder folder;
  const fs::path file = folder.path / "results.vtkhdf";
  const mesh::SurfaceMesh mesh = plate(20);
  const auto with_limit = [&](rlim_t bytes, const std::function<void()>& work) {
    (void)::signal(SIGXFSZ, SIG_IGN);
    rlimit old{};
    getrlimit(RLIMIT_FSIZE, &old);
    const rlimit small{bytes, old.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string said = error_of(work);
    setrlimit(RLIMIT_FSIZE, &old);
    return said;
  };
  std::string said;
  {
    results::ResultsWriter writer = begin(folder.path, mesh);
    for (int n = 1; n <= 5; ++n) writer.write(step(mesh, n));
    writer.flush();
    said = with_limit(20000, [&] { writer.write(step(mesh, 6)); });
    CHECK(has(said, "steps/000005.h5: writing failed; is the disk full"));
    CHECK(results::read_step(file, -1, mesh).step == 5);
    CHECK(read(file, "/voile/steps/number").values.size() == 5);
    for (std::size_t i = 0; i < 5; ++i)
      CHECK(vtk_array(file, i, "PointData/displacement") == step(mesh, static_cast<int>(i) + 1).fields[0].values);
    said = with_limit(120000, [&] { writer.finish(); });  // the steps fit, their sum does not
    CHECK(has(said, "results.vtkhdf: the steps could not be put into one file"));
    CHECK(has(said, "nothing is lost"));
    CHECK(results::read_step(file, 5, mesh).displacement == step(mesh, 5).fields[0].values);
    CHECK(!fs::exists(file.string() + ".part"));
    CHECK(!fs::exists(folder.path / "steps" / "000005.h5.part"));
    CHECK(check_xdmf(folder.path) == 5 * 12);
    writer.write(step(mesh, 6));  // there is room again
  }
  CHECK(!fs::exists(folder.path / "steps"));
  CHECK(results::read_step(file, -1, mesh).displacement == step(mesh, 6).fields[0].values);
}

TEST_CASE("results tell a motion from a path, whatever fields they have, and steps on a later mesh") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(3), finer = plate(4);
  const fs::path file = folder.path / "results.vtkhdf";
  for (const bool moves : {false, true}) {
    results::ResultsWriter writer = begin(folder.path, mesh);
    for (int n : {0, 1, 2}) {
      if (n == 2) writer.begin_epoch(finer, ramp(finer.vertex_count()), ramp(finer.triangle_count()));
      results::StepFields fields = step(n == 2 ? finer : mesh, n);
      fields.load_factor = moves && n == 1 ? 1.0 : fields.time;  // a motion may pass where time and load factor agree
      writer.write(fields);
    }
    const auto check = [&] {
      for (int n : {0, 1, 2}) CHECK(results::read_step(file, n, n == 2 ? finer : mesh).in_motion == moves);
      CHECK(!results::is_remeshed(file, 1));
      CHECK(results::is_remeshed(file, 2));
    };
    check();
    writer.finish();
    check();
  }
}

TEST_CASE("a stored step is read back with the one before it, and only into its own mesh") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(3), other = plate(4);
  const fs::path file = folder.path / "results.vtkhdf";
  results::ResultsWriter writer = begin(folder.path, mesh);
  for (int n : {0, 2, 7}) {
    results::StepFields fields = step(mesh, n);
    if (n == 2)
      fields.fields.push_back({"velocity", "m/s", results::Centre::vertex, 3, step(mesh, 9).fields[0].values});
    writer.write(fields);
  }
  const auto check = [&] {
    const results::StoredStep last = results::read_step(file, -1, mesh), first = results::read_step(file, 0, mesh),
                              motion = results::read_step(file, 2, mesh);
    CHECK(last.step == 7);
    CHECK(last.load_factor == 0.2 * 7);
    CHECK(last.displacement == step(mesh, 7).fields[0].values);
    CHECK(last.previous == step(mesh, 2).fields[0].values);
    CHECK(last.velocity.empty());
    CHECK(last.time == 0.0);
    CHECK(last.in_motion);
    CHECK(motion.velocity == step(mesh, 9).fields[0].values);
    CHECK(motion.time == 0.1 * 2);
    CHECK(first.step == 0);
    CHECK(first.previous.empty());
    CHECK(has(error_of([&] { (void)results::read_step(file, 3, mesh); }), "it has no step 3; it has 0, 2, 7"));
    CHECK(has(error_of([&] { (void)results::read_step(file, -1, other); }), "it belongs to another mesh"));
    CHECK(results::is_results(file));
  };
  check();
  writer.finish();
  check();
  CHECK_THROWS_AS((void)results::read_step(folder.path / "none.h5", -1, mesh), UserError);
  CHECK(!results::is_results(folder.path / "none.h5"));
}

TEST_CASE("the mesh of a step comes back as it was") {
  const Folder folder;
  const fs::path file = folder.path / "results.vtkhdf";
  const mesh::SurfaceMesh first = plate(2);
  mesh::MeshData data = plate(3).data();
  data.source = "cut \xc3\xb6.obj";
  for (std::size_t v = 0; v < data.positions.size(); ++v) {
    data.positions[v] += Vec3(1e-17 * static_cast<double>(v), 1.0 / 3.0, 0.1 * static_cast<double>(v * v));
    data.vertex_tags.push_back(1000000000000 + 7 * v);
  }
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    data.triangle_tags.push_back(3 * t + 1);
    const double x = 0.1 * static_cast<double>(t);
    data.texture.push_back({Vec2(x, 1.0 / 3.0), Vec2(x + 1, -2), Vec2(1e-300, x)});
  }
  std::swap(data.triangles[4][0], data.triangles[4][1]);  // turned round when the mesh is built
  data.groups.push_back({"nothing", 0, {}, {}, {}});
  data.groups.push_back({"rim", 1, {0, 1, 2, 3}, {{2, 1}, {0, 1}, {2, 3}}, {}});
  const mesh::SurfaceMesh second(data);
  REQUIRE(second.reoriented_count() == 1);
  results::ResultsWriter writer = begin(folder.path, first);
  writer.write(step(first, 1));
  writer.begin_epoch(second, ramp(16), ramp(18));
  writer.write(step(second, 2));
  const auto check = [&](const mesh::MeshData& got, const mesh::MeshData& wanted) {
    CHECK(got.source == wanted.source);
    CHECK(got.positions == wanted.positions);
    CHECK(got.triangles == wanted.triangles);
    CHECK(got.vertex_tags == wanted.vertex_tags);
    CHECK(got.triangle_tags == wanted.triangle_tags);
    CHECK(got.texture == wanted.texture);
    REQUIRE(got.groups.size() == wanted.groups.size());
    for (std::size_t g = 0; g < got.groups.size(); ++g) {
      CHECK(got.groups[g].name == wanted.groups[g].name);
      CHECK(got.groups[g].dimension == wanted.groups[g].dimension);
      CHECK(got.groups[g].vertices == wanted.groups[g].vertices);
      CHECK(got.groups[g].segments == wanted.groups[g].segments);
      CHECK(got.groups[g].triangles == wanted.groups[g].triangles);
    }
  };
  const auto check_both = [&] {
    check(results::read_step_mesh(file, 1), first.data());
    check(results::read_step_mesh(file, 2), second.data());
    check(results::read_step_mesh(file, -1), second.data());
    CHECK(results::read_step(file, 2, second).displacement == step(second, 2).fields[0].values);
    CHECK(results::read_step(file, 2, second).previous.empty());  // on another mesh
    CHECK_THROWS_AS((void)results::read_step(file, 2, first), UserError);
  };
  check_both();
  writer.finish();
  check_both();
  const mesh::SurfaceMesh again(results::read_step_mesh(file, 2));
  CHECK(again.reoriented_count() == 0);
}

TEST_CASE("steps not named yet are found, and a missing or damaged one is named") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  const fs::path copy = folder.path / "copy", file = copy / "results.vtkhdf", steps = folder.path / "steps";
  results::ResultsWriter writer = begin(folder.path, mesh);
  for (int n : {1, 2}) writer.write(step(mesh, n));
  writer.flush();
  fs::create_directories(copy / "steps");
  fs::copy_file(folder.path / "results.vtkhdf", file);
  const auto error = [&](int n) { return error_of([&] { (void)results::read_step(file, n, mesh); }); };
  CHECK(has(error(1), "its data are in steps/epoch_000000.h5 beside it, which is missing"));
  fs::copy_file(steps / "epoch_000000.h5", copy / "steps" / "epoch_000000.h5");
  CHECK(has(error(1), "its data are in steps/000000.h5 beside it, which is missing"));
  CHECK(has(error(-1), "copy the folder steps/ together with results.vtkhdf"));
  fs::copy_file(steps / "000001.h5", copy / "steps" / "000001.h5");
  CHECK(has(error(2), "steps/000000.h5"));  // the step before is needed, too
  fs::copy_file(steps / "000000.h5", copy / "steps" / "000000.h5");
  CHECK(error(2) == "no error");
  writer.write(step(mesh, 3));
  fs::copy_file(steps / "000002.h5", copy / "steps" / "000002.h5");  // of a killed run: the index does not know it
  CHECK(results::read_step(file, -1, mesh).step == 3);
  CHECK(results::read_step(file, 3, mesh).previous == step(mesh, 2).fields[0].values);

  const std::string whole = read_text(steps / "000002.h5");
  for (std::size_t size = 0; size < whole.size(); size += 97) {  // whatever is cut off, somebody is told
    std::ofstream(copy / "steps" / "000002.h5", std::ios::binary) << whole.substr(0, size);
    CHECK(has(error(3), "steps/000002.h5"));
  }
  std::string bytes = whole;
  const double value = step(mesh, 3).fields[0].values[5];
  const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&value), sizeof value));
  REQUIRE(at != std::string::npos);
  bytes[at + 6] = static_cast<char>(bytes[at + 6] ^ 0x10);
  std::ofstream(copy / "steps" / "000002.h5", std::ios::binary) << bytes;
  CHECK(has(error(3), "its checksum does not fit"));
  CHECK(has(error(3), "steps/000002.h5"));
}

TEST_CASE("damage of the one file is an error, not a wrong number") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(1);
  const fs::path file = folder.path / "results.vtkhdf";
  {
    results::ResultsWriter writer = begin(folder.path, mesh);
    for (int n : {1, 2}) writer.write(step(mesh, n));
  }
  const std::string whole = read_text(file);
  const auto error = [&] { return error_of([&] { (void)results::read_step(file, 2, mesh); }); };
  REQUIRE(error() == "no error");
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 40) {
    std::ofstream(file, std::ios::binary) << whole.substr(0, size);
    CHECK(has(error(), "--restart"));
  }
  int wrong = 0, found = 0;
  for (std::size_t at = 100; at < whole.size(); at += whole.size() / 60) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    std::ofstream(file, std::ios::binary) << bytes;
    if (error() != "no error")
      ++found;
    else if (results::read_step(file, 2, mesh).displacement != step(mesh, 2).fields[0].values)
      ++wrong;
  }
  CHECK(wrong == 0);
  MESSAGE(found << " of 60 damaged bytes matter for a restart");
}

TEST_CASE("a checkpoint comes back bit by bit, and only into its own mesh") {
  const Folder folder;
  fs::create_directories(folder.path);
  const mesh::SurfaceMesh mesh = plate(3);
  const fs::path file = folder.path / "checkpoint.h5";
  results::Checkpoint c{12, 0.1 + 0.2, 1.0 / 3.0, {}, {}, {}};
  for (Index i = 0; i < 3 * mesh.vertex_count(); ++i) {
    c.displacement.push_back(1.0 / (i + 1));
    c.velocity.push_back(-0.1 * i);
    c.acceleration.push_back(1e-17 * i);
  }
  c.slips.assign(1 + 3 * static_cast<std::size_t>(mesh.triangle_count()), 0.1 / 3.0);
  c.energy_balance.assign(13, 0.5);  // as written before friction inside the fabric
  results::write_checkpoint(file, c, mesh);
  results::Checkpoint back = results::read_checkpoint(file, mesh);
  CHECK(back.slips == c.slips);
  CHECK(back.energy_balance == c.energy_balance);
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
    CHECK(has(error_of([&] { (void)results::read_checkpoint(file, mesh); }), "its checksum does not fit"));
  }
  c.velocity[3] = INFINITY;
  results::write_checkpoint(file, c, mesh);
  CHECK(has(error_of([&] { (void)results::read_checkpoint(file, mesh); }),
            "'velocity' holds numbers that are not finite"));
  c.velocity[3] = 0.0;
  c.slips.clear();
  c.acceleration.clear();
  results::write_checkpoint(file, c, mesh);
  CHECK(results::read_checkpoint(file, mesh).acceleration.empty());
  CHECK_THROWS_AS((void)results::read_checkpoint(file, plate(4)), UserError);
  std::ofstream(file) << "not HDF5";
  CHECK_THROWS_AS((void)results::read_checkpoint(file, mesh), UserError);
}

}  // namespace test_stored_results
