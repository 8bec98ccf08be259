// Seams of three layers: how the sheets that meet there bend.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "../pattern/test_pattern_kit.hpp"
#include "mesh/weld.hpp"
#include "system/seam_tension.hpp"
#include "test_charts_kit.hpp"
#include "test_model_kit.hpp"

namespace test_layers {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::charts;

namespace {

/// A skirt (y < 0) sewn to two layers of a band (y > 0), as flat as at rest; the inner layer may be turned over.
mesh::MeshData sewn(bool is_turned, bool is_welded = true) {
  std::vector<pattern::Panel> panels{rectangle("skirt", 1.0, 0.5, 0.2), rectangle("outer", 1.0, 0.4, 0.2),
                                     rectangle("inner", 1.0, 0.4, 0.15)};
  panels[0].shift = {0.0, -0.5, 0.0};
  if (is_turned) {
    panels[2].turn = Eigen::AngleAxisd(std::acos(-1.0), Vec3::UnitY()).toRotationMatrix();
    panels[2].shift = {1.0, 0.0, 0.0};
    std::swap(panels[0], panels[1]);  // then a layer of the band is the first sheet, and the other is folded against it
  }
  const std::string corner = is_turned ? "inner@1" : "inner@0";
  const pattern::Garment g = pattern::make_garment(panels, {seam({"skirt/2"}, {"outer/0"}, {"skirt@3", "outer@0"}),
                                                            seam({"skirt/2"}, {"inner/0"}, {"skirt@3", corner})});
  if (!is_welded) return g.mesh;
  const std::vector<double> mass(g.mesh.positions.size(), 1.0);
  return mesh::weld(g.mesh, mesh::open_seams(g.mesh, {"all"}), g.mesh.positions, mass).data;
}

system::ModelInput with_bending(double factor) {
  system::ModelInput in = free_sheet(0.0);
  in.seams.push_back({"", factor, 0.0});
  return in;
}

/// A piece turned about the line.
std::function<Vec3(Index)> turned(const mesh::SurfaceMesh& mesh, const std::string& piece, double angle) {
  std::vector<char> moves(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (const Index v : mesh.group(piece, 2).vertices) moves[static_cast<std::size_t>(v)] = 1;
  return [&mesh, moves, angle](Index v) {
    const Vec3 x = mesh.positions()[static_cast<std::size_t>(v)];
    return moves[static_cast<std::size_t>(v)] ? Vec3(Eigen::AngleAxisd(angle, Vec3::UnitX()) * x - x)
                                              : Vec3(Vec3::Zero());
  };
}

double bending(const mesh::SurfaceMesh& mesh, double factor, const std::function<Vec3(Index)>& u) {
  system::Model model(PETSC_COMM_WORLD, mesh, with_bending(factor));
  const petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, u);
  return system::energies(model, a).bending;
}

}  // namespace

TEST_CASE("three layers: the band lies on itself at rest, and each layer is flat against the skirt") {
  for (const bool is_turned : {false, true}) {
    CAPTURE(is_turned);
    const mesh::SurfaceMesh mesh(sewn(is_turned));
    REQUIRE(mesh.joints().size() > 5);
    CHECK(mesh.component_count() == 1);
    system::Model model(PETSC_COMM_WORLD, mesh, with_bending(1.0));
    const petsc::VecHandle a = model.dofs().create_vector();
    const system::Energies e = system::energies(model, a);
    // Springs of three equal slopes, c = l^2 D / A: turning one by an angle stores sum of 1/2 (c_1 (c_2 + c_3)/(c_1 + c_2 + c_3)) angle^2.
    const double d = isotropic(100.0, 0.0, 0.02, 1.0).bending(0, 0), angle = 0.4;
    for (const std::string piece : {"skirt", "outer", "inner"}) {
      CAPTURE(piece);
      double expected = 0.0;
      for (const mesh::Joint& joint : mesh.joints()) {
        double own = 0.0, others = 0.0;
        for (const mesh::TriangleSide& s : joint.sides) {
          const double length = mesh.rest_length(joint.edge), c = length * length * d / mesh.area(s.triangle);
          const auto& in = mesh.group(piece, 2).triangles;
          (std::find(in.begin(), in.end(), s.triangle) != in.end() ? own : others) += c;
        }
        expected += 0.5 * own * others / (own + others) * angle * angle;
      }
      CHECK(e.bending < 1e-20 * expected);
      for (const double factor : {1.0, 0.25, 4.0})
        CHECK(bending(mesh, factor, turned(mesh, piece, angle)) == doctest::Approx(factor * expected).epsilon(1e-3));
      CHECK(bending(mesh, 0.0, turned(mesh, piece, angle)) < 1e-8 * expected);
    }
  }
}

TEST_CASE("three layers: derivatives, and the same on any number of ranks") {
  const mesh::SurfaceMesh mesh(sewn(true));
  for (const double factor : {1.0, 0.3}) {
    system::Model model(PETSC_COMM_WORLD, mesh, with_bending(factor)),
        alone(PETSC_COMM_SELF, mesh, with_bending(factor));
    const Slopes s = slopes(model, 0.01, 1e-3);  // shorter ones end in round-off
    CHECK(s.force < 1e-8);
    CHECK(s.tangent < 1e-9);
    const petsc::VecHandle a = alone.dofs().create_vector(), b = model.dofs().create_vector();
    set_displacement(alone, a, noise(0.02, 9));
    set_displacement(model, b, noise(0.02, 9));
    CHECK(system::energies(model, b).bending == doctest::Approx(system::energies(alone, a).bending).epsilon(1e-11));
  }
}

TEST_CASE("charts that branch without a seam that says how are refused") {
  mesh::MeshData data = sewn(false);
  data.folded.clear();
  CHECK_THROWS_WITH_AS(mesh::SurfaceMesh{data}, doctest::Contains("branch only along a seam"), UserError);
}

TEST_CASE("tension of a seam of three layers: of its own edge as long as it is open, then what the line carries") {
  const std::map<std::string, double> strains{{"skirt", 0.03}, {"outer", 0.02}, {"inner", 0.01}};
  std::map<std::string, double> tensions;
  for (const auto& [piece, e] : strains)
    tensions[piece] = isotropic(100.0, 0.0, 0.02, 1.0).membrane(0, 0) * (e + 0.5 * e * e) * (1.0 + e);
  for (const bool is_welded : {false, true}) {
    CAPTURE(is_welded);
    const mesh::SurfaceMesh mesh(sewn(false, is_welded));
    system::Model model(PETSC_COMM_WORLD, mesh, with_bending(1.0));
    std::vector<Vec3> places = mesh.positions();
    for (const auto& [piece, e] : strains)
      for (const Index v : mesh.group(piece, 2).vertices) places[v][1] = (1.0 + e) * mesh.positions()[v][1];
    const petsc::VecHandle u = model.dofs().create_vector();
    set_displacement(model, u, [&](Index v) { return Vec3(places[v] - mesh.positions()[v]); });
    const system::TriangleFields fields = model.triangle_fields(u);
    if (mpi::rank(PETSC_COMM_WORLD) != 0) continue;
    std::vector<double> found;
    for (const mesh::Group& group : mesh.groups())
      if (group.name.starts_with(mesh::seam_group(""))) {
        const system::SeamTension t =
            system::seam_tension(model.discretisation().sheet(), group, fields.membrane_force, places);
        CHECK(t.length == doctest::Approx(1.0).epsilon(1e-12));
        CHECK(t.error < 1e-9 * t.mean);
        CHECK(t.largest == doctest::Approx(is_welded ? tensions["skirt"] : t.mean).epsilon(1e-9));
        found.push_back(t.mean);
      }
    REQUIRE(found.size() == 2);
    const double carried = 0.5 * (tensions["skirt"] + tensions["outer"] + tensions["inner"]);
    CHECK(found[0] == doctest::Approx(is_welded ? carried : tensions["outer"]).epsilon(1e-9));
    CHECK(found[1] == doctest::Approx(is_welded ? carried : tensions["inner"]).epsilon(1e-9));
  }
}

}  // namespace test_layers
