// Runs as moments: steps of several meshes, running and finished; fields; what is exported is read back.
#include "picture/recording.hpp"

#include <cstring>

#include "../test_results_kit.hpp"
#include "formats/point_cache.hpp"
#include "picture/export.hpp"
#include "picture/field_values.hpp"
#include "picture/show.hpp"
#include "results/stored_run.hpp"

namespace test_recording {

using namespace voile;
using namespace voile::testing;
using namespace voile::picture;

namespace {

/// Steps 1 and 2 on a mesh, 3 to 5 on a finer one.
results::ResultsWriter two_meshes(const fs::path& folder) {
  results::ResultsWriter writer = begin(folder, plate(2));
  for (const int n : {1, 2}) writer.write(step(plate(2), n));
  const mesh::SurfaceMesh fine = plate(4);
  writer.begin_epoch(fine, ramp(fine.vertex_count()), ramp(fine.triangle_count()));
  for (const int n : {3, 4, 5}) writer.write(step(fine, n));
  return writer;
}

std::vector<int> numbers(const Recording& r, const std::string& steps) {
  std::vector<int> list;
  for (const Moment& m : r.select(steps)) list.push_back(r.number(m));
  return list;
}

void check_recording(const fs::path& folder) {
  const Recording r(folder);
  CHECK(numbers(r, "all") == std::vector{1, 2, 3, 4, 5});
  CHECK(numbers(r, "last") == std::vector{5});
  CHECK(numbers(r, "2") == std::vector{2});
  CHECK(numbers(r, "1:5:2") == std::vector{1, 3, 5});
  CHECK(numbers(r, "2:3") == std::vector{2, 3});
  CHECK(has(error_of([&] { (void)r.select("7"); }), "there is no step 7; there are 1, 2, 3, 4, 5"));
  CHECK(has(error_of([&] { (void)r.select("a:b"); }), "FIRST:LAST"));
  for (const Moment& m : r.select("all")) {
    const int number = r.number(m);
    const mesh::SurfaceMesh mesh = number <= 2 ? plate(2) : plate(4);
    const State s = r.state(m, 2.0);
    REQUIRE(s.positions.size() == mesh.positions().size());
    const results::Field u = step(mesh, number).fields[0];
    for (std::size_t v = 0; v < s.positions.size(); ++v)
      CHECK(
          (s.positions[v] - mesh.positions()[v] - 2.0 * Vec3(u.values[3 * v], u.values[3 * v + 1], u.values[3 * v + 2]))
              .norm() < 1e-12);
    const results::Field thickness = r.parts()[0].run.field(*m.step, "thickness", s.mesh->data);
    CHECK(thickness.centre == results::Centre::triangle);
    CHECK(thickness.unit == "m");
    CHECK(thickness.values == step(mesh, number).fields[2].values);
    CHECK(r.parts()[0].run.field(*m.step, "membrane_force", s.mesh->data).values ==
          step(mesh, number).fields[1].values);
  }
  const State s = r.state(r.select("1").front(), 1.0);
  CHECK(has(error_of([&] { (void)r.parts()[0].run.field(0, "thicknes", s.mesh->data); }), "did you mean 'thickness'"));
}

}  // namespace

TEST_CASE("steps of several meshes are read while the run goes on, and after it") {
  const Folder folder;
  results::ResultsWriter writer = two_meshes(folder.path);
  check_recording(folder.path);
  writer.finish();
  check_recording(folder.path);
  check_recording(folder.path / "results.vtkhdf");
}

TEST_CASE("what are no results says so") {
  const Folder folder;
  CHECK(has(error_of([&] { (void)Recording(folder.path); }), "no such folder"));
  fs::create_directories(folder.path);
  CHECK(has(error_of([&] { (void)Recording(folder.path); }), "there are no results"));
  { two_meshes(folder.path).finish(); }
  CHECK(has(error_of([&] { (void)Recording(folder.path, {"drape", 0}); }), "not a run in stages"));
  CHECK(has(error_of([&] { (void)Recording(folder.path, {"", 1}); }), "no modes"));
  const std::string whole = read_text(folder.path / "results.vtkhdf");
  for (const double part : {0.0, 0.1, 0.5, 0.9}) {
    std::ofstream(folder.path / "results.vtkhdf", std::ios::binary)
        << whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size())));
    CHECK(has(error_of([&] {
                const Recording r(folder.path);
                for (const Moment& m : r.select("all")) (void)r.state(m, 1.0);
              }),
              "results.vtkhdf"));
  }
}

TEST_CASE("without steps the mesh at the start is shown") {
  const Folder folder;
  const results::ResultsWriter writer = begin(folder.path, plate(2));
  const Recording r(folder.path);
  const std::vector<Moment> moments = r.select("last");
  REQUIRE(moments.size() == 1);
  CHECK(r.number(moments[0]) == -1);
  CHECK(r.state(moments[0], 1.0).positions == plate(2).positions());
  ShowOptions options;
  options.width = 40;
  options.height = 30;
  options.quality = Quality::draft();
  CHECK(Show(r, moments, options).picture(moments[0]).width() == 40);
}

TEST_CASE("pictures of all steps have one camera, whatever the mesh, and show what is asked for") {
  const Folder folder;
  { two_meshes(folder.path).finish(); }
  const Recording r(folder.path);
  ShowOptions options;
  options.width = 64;
  options.height = 48;
  options.quality = Quality::draft();
  options.field = "membrane_force:11";
  options.mesh_lines = options.contours = true;
  options.views = {"top", "front"};
  const Show show(r, r.select("all"), options);
  for (const Moment& m : show.moments()) CHECK(show.picture(m).height() == 48);
  options.field = "membrane_forc";
  CHECK(has(error_of([&] { (void)Show(r, r.select("all"), options); }), "did you mean 'membrane_force'"));
  options.field = "membrane_force:z";
  CHECK(has(error_of([&] { (void)Show(r, r.select("all"), options); }), "larger, smaller"));
}

TEST_CASE("strains along the threads are those of the warp, wherever it lies") {
  const Folder folder;
  const mesh::SurfaceMesh mesh = plate(2);
  results::StepFields strained = step(mesh, 1);
  std::vector<double> strain;  // stretched by 4 % and sheared, in material axes
  for (Index t = 0; t < mesh.triangle_count(); ++t) strain.insert(strain.end(), {0.0408, 0.0, 0.02});
  strained.fields.push_back({"membrane_strain", "1", results::Centre::triangle, 3, strain});
  {
    results::ResultsWriter writer = begin(folder.path, mesh);
    writer.write(strained);
    writer.finish();
  }
  for (const double degrees : {0.0, 90.0, 30.0, -30.0}) {
    std::ofstream(folder.path / "resolved_case.toml") << "[[material]]\nwarp_angle = " << degrees << "\n";
    const Recording r(folder.path);
    const double turn = degrees * 0.017453292519943295, c = std::cos(turn), s = std::sin(turn);
    const auto along = [&](double x, double y) {
      return 100.0 * (std::sqrt(1.0 + 2.0 * (0.0408 * x * x + 0.02 * x * y)) - 1.0);
    };
    const Moment moment = r.select("last")[0];
    for (const float x : field_values(r, moment, {"membrane_strain", "warp"}).values)
      CHECK(x == doctest::Approx(along(c, s)));
    for (const float x : field_values(r, moment, {"membrane_strain", "weft"}).values)
      CHECK(x == doctest::Approx(along(-s, c)));
    for (const float x : field_values(r, moment, {"membrane_strain", "11"}).values) CHECK(x == doctest::Approx(0.0408));
  }
}

TEST_CASE("numbers out of fields: magnitude, components, principal values") {
  const results::Field u{"displacement", "m", results::Centre::vertex, 3, {3, 4, 12, 0, 0, -1}};
  CHECK(field_values(u, "").values == std::vector<float>{13, 1});
  CHECK(field_values(u, "z").values == std::vector<float>{12, -1});
  CHECK(field_values(u, "").label == "displacement, magnitude [m]");
  const results::Field n{"membrane_force", "N/m", results::Centre::triangle, 3, {1, 1, 2}};
  CHECK(field_values(n, "larger").values == std::vector<float>{3});
  CHECK(field_values(n, "smaller").values == std::vector<float>{-1});
  CHECK(field_values(n, "max").values == std::vector<float>{3});
  // The third entry of a strain is twice the tensor's.
  const results::Field e{"membrane_strain", "1", results::Centre::triangle, 3, {1, 1, 2}};
  CHECK(field_values(e, "larger").values == std::vector<float>{2});
  CHECK(field_values(e, "").label == "membrane strain, larger");
  // A thread of length 1 that becomes 1.1 has the Green-Lagrange strain (1.21 - 1)/2.
  const results::Field f{"membrane_strain", "1", results::Centre::triangle, 3, {0.105, -0.095, 0, 0, 0, 0.21}};
  CHECK(field_values(f, "warp").values[0] == doctest::Approx(10.0));
  CHECK(field_values(f, "weft").values[0] == doctest::Approx(-10.0));
  CHECK(field_values(f, "stretch").values[1] == doctest::Approx(10.0));
  CHECK(field_values(f, "warp").label == "membrane strain, warp [%]");
  CHECK(field_values(f, "22").label == "membrane strain, 22");
}

TEST_CASE("a point cache is read back, and refused where the meshes are of different sheets") {
  const Folder folder;
  { two_meshes(folder.path).finish(); }
  const Recording r(folder.path);
  ExportOptions options{"pc2", folder.path / "motion.pc2", {}, 25.0, true};
  CHECK(has(error_of([&] { (void)export_results(r, r.select("all"), options); }), "is not in all meshes of the run"));
  CHECK(export_results(r, r.select("3:5"), options).files.size() == 2);
  const std::string bytes = read_text(folder.path / "motion.pc2");
  const std::size_t vertices = plate(4).positions().size();
  REQUIRE(bytes.size() == 32 + 3 * vertices * 12);
  CHECK(bytes.substr(0, 11) == "POINTCACHE2");
  for (int k = 0; k < 3; ++k) {
    const State s = r.state(r.select(std::to_string(3 + k)).front(), 1.0);
    for (std::size_t i = 0; i < 3 * vertices; ++i) {
      float x = 0.0F;
      std::memcpy(&x, bytes.data() + 32 + 4 * (static_cast<std::size_t>(k) * 3 * vertices + i), 4);
      CHECK(x == static_cast<float>(s.positions[i / 3][static_cast<Index>(i % 3)]));
    }
  }
}

}  // namespace test_recording
