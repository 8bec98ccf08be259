// Seams that bend otherwise than the fabric, and their allowances.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "mesh/weld.hpp"
#include "test_charts_kit.hpp"
#include "test_model_kit.hpp"

namespace test_seam_rules {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::charts;

namespace {

/// The unit square in two charts, left and right of a line near x = 0.5 that follows edges; "seam middle" is that line.
mesh::MeshData sewn_square(Pattern pattern, int n) {
  mesh::MeshData d = square(pattern, n);
  const auto right = [&](Index t) {
    const mesh::Triangle& v = d.triangles[t];
    return (d.positions[v[0]][0] + d.positions[v[1]][0] + d.positions[v[2]][0]) / 3.0 > 0.5 ? 1 : 0;
  };
  std::map<std::array<Index, 2>, int> sides;
  for (Index t = 0; t < static_cast<Index>(d.triangles.size()); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index a = d.triangles[t][(s + 1) % 3], b = d.triangles[t][(s + 2) % 3];
      sides[{std::min(a, b), std::max(a, b)}] += right(t) ? 1 : 10;
    }
  mesh::Group seam{mesh::seam_group("middle"), 1, {}, {}, {}};
  for (const auto& [edge, count] : sides)
    if (count == 11) {
      seam.segments.push_back(edge);
      seam.vertices.insert(seam.vertices.end(), edge.begin(), edge.end());
    }
  std::sort(seam.vertices.begin(), seam.vertices.end());
  seam.vertices.erase(std::unique(seam.vertices.begin(), seam.vertices.end()), seam.vertices.end());
  d = cut(d, right, true);
  d.groups.push_back(seam);
  return d;
}

/// A plate on the x-y plane folded by an angle about the line x = 0.5, as displacements.
std::function<Vec3(Index)> folded(const mesh::SurfaceMesh& mesh, double angle) {
  return [&mesh, angle](Index v) {
    const Vec3 x = mesh.positions()[v], line(0.5, x[1], 0.0);
    if (x[0] <= 0.5) return Vec3(Vec3::Zero());
    return Vec3(line + Eigen::AngleAxisd(angle, Vec3::UnitY()) * (x - line) - x);
  };
}

system::ModelInput with_rule(double bending, double allowance, energy::BendingOperator op,
                             energy::MembraneOperator membrane = energy::MembraneOperator::six_node) {
  system::ModelInput in = free_sheet(0.3);
  in.element.bending = op;
  in.element.membrane = membrane;
  in.seams = {{"middle", bending, allowance}};
  return in;
}

system::Energies energies(system::Model& model, const std::function<Vec3(Index)>& u) {
  const petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, u);
  return system::energies(model, a);
}

}  // namespace

TEST_CASE("a hinge folds by any angle without energy, and holds what bends beside it") {
  const mesh::SurfaceMesh mesh(sewn_square(Pattern::union_jack, 8));
  for (const auto op :
       {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle, energy::BendingOperator::six_node})
    for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::six_node_corrected}) {
      system::Model hinge(PETSC_COMM_WORLD, mesh, with_rule(0.0, 0.0, op, membrane)),
          fabric(PETSC_COMM_WORLD, mesh, with_rule(1.0, 0.0, op, membrane));
      for (const double angle : {0.3, 1.5}) {
        const system::Energies e = energies(hinge, folded(mesh, angle)), whole = energies(fabric, folded(mesh, angle));
        REQUIRE(whole.bending > 1e-6);
        CHECK(e.bending < 1e-12 * whole.bending);
        CHECK(e.membrane < 1e-12 * whole.bending);
      }
      // Rolled up about the y axis, every cell but the row beside the seam keeps its curvature.
      const auto roll = [&](Index v) {
        const Vec3 x = mesh.positions()[v];
        return Vec3(0.5 + std::sin(x[0] - 0.5) - x[0], 0.0, std::cos(x[0] - 0.5) - 1.0);
      };
      const double kept = energies(hinge, roll).bending / energies(fabric, roll).bending;
      CHECK(kept > 0.7);
      CHECK(kept < 0.9);
    }
}

TEST_CASE("bending across a seam in proportion to its factor") {
  const mesh::SurfaceMesh mesh(sewn_square(Pattern::union_jack, 8));
  const auto bent = folded(mesh, 0.2);
  for (const auto op :
       {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle, energy::BendingOperator::six_node}) {
    system::Model fabric(PETSC_COMM_WORLD, mesh, with_rule(1.0, 0.0, op));
    const double whole = energies(fabric, bent).bending;
    for (const double factor : {0.01, 0.25, 2.0, 9.0}) {
      // Nothing else bends: the part of the cut sheet is zero.
      system::Model model(PETSC_COMM_WORLD, mesh, with_rule(factor, 0.0, op));
      CHECK(energies(model, bent).bending == doctest::Approx(factor * whole).epsilon(1e-10));
    }
    const Answers one = ask(fabric, noise(0.05, 9));
    system::ModelInput none = with_rule(1.0, 0.0, op);
    none.seams.clear();
    system::Model without(PETSC_COMM_WORLD, mesh, none);
    CHECK(difference(one.residual, ask(without, noise(0.05, 9)).residual) == 0.0);
  }
}

TEST_CASE("seams that bend otherwise: derivatives, and the same on any number of ranks") {
  const mesh::SurfaceMesh mesh(sewn_square(Pattern::jittered, 6));
  for (const double factor : {0.0, 0.3, 4.0})
    for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::six_node_corrected}) {
      system::ModelInput in = with_rule(factor, 0.07, energy::BendingOperator::edge_slope, membrane);
      in.supports = {support("left", system::Support::Kind::clamped)};
      system::Model model(PETSC_COMM_WORLD, mesh, in), alone(PETSC_COMM_SELF, mesh, in);
      const Slopes s = slopes(model, 0.02);
      CHECK(s.force < 1e-9);
      CHECK(s.tangent < 1e-8);
      const petsc::VecHandle a = alone.dofs().create_vector();
      set_displacement(alone, a, noise(0.05, 9));
      const system::Energies here = system::energies(alone, a), all = energies(model, noise(0.05, 9));
      CHECK(all.bending == doctest::Approx(here.bending).epsilon(1e-12));
      CHECK(all.membrane == doctest::Approx(here.membrane).epsilon(1e-12));
    }
}

TEST_CASE("allowances of a seam weigh and carry what two strips of fabric do") {
  for (const Pattern pattern : {Pattern::union_jack, Pattern::jittered, Pattern::gmsh})
    for (const double width : {0.02, 0.125, 0.3}) {
      CAPTURE(name_of(pattern));
      CAPTURE(width);
      const mesh::MeshData data = sewn_square(pattern, 8);
      const mesh::SurfaceMesh mesh(data);
      double length = 0.0;
      for (const mesh::Segment& s : mesh.group("seam middle", 1).segments) length += mesh.rest_length(s);
      const bool straight = std::abs(length - 1.0) < 1e-12;
      double strips = 0.0;
      for (const double area : system::allowance_areas(mesh, {{"", 1.0, width}})) strips += area;
      if (straight)
        CHECK(strips == doctest::Approx(2.0 * width).epsilon(1e-12));
      else  // corners at the bends of the seam and ends count as they come
        CHECK(strips == doctest::Approx(2.0 * width * length).epsilon(0.2));
      const system::ModelInput in = with_rule(1.0, width, energy::BendingOperator::edge_slope);
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      double mass = 0.0;
      for (const Vec3& m : per_vertex(model, model.potential().constant().mass())) mass += m[0];
      CHECK(mass == doctest::Approx(1.0 + strips).epsilon(1e-12));  // 1 kg/m^2
      // Stretched along the seam by 1 % without contraction across: A11 / 2 E^2 per area, in two layers there.
      const double e = 0.01 + 0.5 * 0.01 * 0.01, a11 = in.materials[0].membrane(0, 0);
      const auto stretched = [&](Index v) { return Vec3(0.0, 0.01 * mesh.positions()[v][1], 0.0); };
      CHECK(energies(model, stretched).membrane == doctest::Approx(0.5 * a11 * e * e * (1.0 + strips)).epsilon(1e-10));
    }
}

TEST_CASE("allowances multiply all that fabric stores, loses and weighs") {
  const mesh::SurfaceMesh mesh(sewn_square(Pattern::union_jack, 8));
  energy::Material m = free_sheet(0.3).materials.at(0);
  m.friction.sliders = {{Vec3(3.0, 2.0, 1.0), Vec3(0.3, 0.2, 0.1)}};
  m.yarns.knots[0] = {{0.0, 5e3}, {0.02, -1e3}};
  m.yarns.stiffness = 40.0;
  m.yarns.limit = 2.0;
  m.yarns.rise = 7.0;
  std::vector<energy::Material> materials{m};
  std::vector<int> of(static_cast<std::size_t>(mesh.triangle_count()), 0);
  system::add_allowances(mesh, {{"", 1.0, 0.1}}, materials, of);
  REQUIRE(materials.size() > 1);
  for (const energy::Material& sewn : materials) {
    const double layers = sewn.areal_density / m.areal_density;
    if (&sewn != &materials.front()) CHECK(layers > 1.01);
    CHECK((sewn.membrane - layers * m.membrane).norm() < 1e-12 * sewn.membrane.norm());
    CHECK((sewn.bending - layers * m.bending).norm() < 1e-12 * sewn.bending.norm());
    CHECK((sewn.friction.sliders[0].stiffness - layers * m.friction.sliders[0].stiffness).norm() < 1e-12);
    CHECK((sewn.friction.sliders[0].limit - layers * m.friction.sliders[0].limit).norm() < 1e-12);
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK(sewn.yarns.knots[0][k].strain == m.yarns.knots[0][k].strain);
      CHECK(sewn.yarns.knots[0][k].bend == doctest::Approx(layers * m.yarns.knots[0][k].bend).epsilon(1e-12));
    }
    CHECK(sewn.yarns.stiffness == doctest::Approx(layers * 40.0).epsilon(1e-12));
    CHECK(sewn.yarns.limit == doctest::Approx(layers * 2.0).epsilon(1e-12));
    CHECK(sewn.yarns.rise == doctest::Approx(layers * 7.0).epsilon(1e-12));
  }
}

TEST_CASE("rules of seams: the one that names it, else the general one; none for other curves") {
  const mesh::SurfaceMesh mesh(sewn_square(Pattern::union_jack, 4));
  const auto factors = [&](const std::vector<system::SeamRule>& rules) {
    return system::bending_across_seams(mesh, rules);
  };
  CHECK(factors({{"", 0.5, 0.0}}).size() == 8);  // four edges, two triangles each
  CHECK(factors({{"", 0.5, 0.0}, {"middle", 0.0, 0.0}}).front().factor == 0.0);
  CHECK(factors({{"", 0.5, 0.0}, {"middle", 1.0, 0.0}}).empty());
  CHECK(factors({{"left", 0.0, 0.0}}).empty());
  CHECK(factors({{"mid*", 0.0, 0.0}, {"", 0.5, 0.0}}).front().factor == 0.0);
  CHECK(factors({{"mid*", 0.0, 0.0}, {"middle", 0.25, 0.0}}).front().factor == 0.25);
  CHECK(system::allowance_areas(mesh, {{"left", 1.0, 0.1}}).empty());
}

}  // namespace test_seam_rules
