// Rest coordinates per triangle corner: panels that lie anywhere in their charts, and seams between them.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "extent.hpp"
#include "mesh/panels.hpp"
#include "test_charts_kit.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_charts {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::charts;

namespace {

/// Which quarter of the unit square, wavy borders included, a triangle is in.
int quarter(const mesh::MeshData& d, const mesh::Triangle& t) {
  const Vec3 c = (d.positions[t[0]] + d.positions[t[1]] + d.positions[t[2]]) / 3.0;
  return (c[0] > 0.45 ? 1 : 0) + (c[1] > 0.55 ? 2 : 0);
}

/// Surface groups quarter0 .. quarter3.
mesh::MeshData with_quarters(mesh::MeshData d) {
  for (int q = 0; q < 4; ++q) {
    mesh::Group g{"quarter" + std::to_string(q), 2, {}, {}, {}};
    for (Index t = 0; t < static_cast<Index>(d.triangles.size()); ++t)
      if (quarter(d, d.triangles[t]) == q) g.triangles.push_back(t);
    d.groups.push_back(g);
  }
  return d;
}

energy::Material orthotropic(const Vec3& direction) {
  energy::Material m;
  m.membrane = energy::orthotropic_membrane(100.0, 40.0, 0.3, 20.0, 0.1);
  m.bending = energy::bending_from_membrane(m.membrane, 0.1);
  m.bending(0, 2) = m.bending(2, 0) = 0.05 * m.bending(0, 0);
  m.areal_density = 1.0;
  m.direction = direction;
  return m;
}

system::ModelInput plate_input(energy::BendingOperator bending, energy::MembraneOperator membrane) {
  system::ModelInput in;
  in.element.bending = bending;
  in.element.membrane = membrane;
  in.supports = {support("left", system::Support::Kind::clamped), support("top", system::Support::Kind::symmetry),
                 support("right", system::Support::Kind::hinged)};
  in.supports[2].value = Vec3(0.01, 0.0, 0.02);
  system::Load pressure = load(system::Load::Kind::pressure, "", Vec3::Zero());
  pressure.magnitude = 0.6;
  system::Load follower = pressure, moment = pressure;
  follower.kind = system::Load::Kind::follower_pressure;
  moment.kind = system::Load::Kind::follower_moment;
  moment.group = "bottom";
  moment.magnitude = 0.002;
  in.loads = {pressure, follower, moment, load(system::Load::Kind::gravity, "", Vec3(0.1, 0.2, -0.3)),
              load(system::Load::Kind::line, "bottom", Vec3(0.3, 0.0, 0.1))};
  system::Spring ground;
  ground.kind = system::Spring::Kind::area;
  ground.stiffness = 0.1;
  in.springs = {ground};
  return in;
}

/// `in_plane`, `charted`: the material directions of the quarters lie in their charts.
std::vector<energy::Material> quarter_materials(bool charted, bool in_plane) {
  std::vector<energy::Material> all;
  for (int q = 0; q < 4; ++q) {
    const Mat3 turn = random_motion(101u + static_cast<unsigned>(q), in_plane).turn;
    const Vec3 direction(1.0, 0.4, 0.0);
    all.push_back(orthotropic(charted ? Vec3(turn * direction) : direction));
    all.back().groups = {"quarter" + std::to_string(q)};
  }
  return all;
}

void check_same(const Answers& a, const Answers& b, bool fields, double tolerance = 1e-12) {
  CHECK(difference(a.residual, b.residual) < tolerance);
  CHECK(difference(a.tangent, b.tangent) < tolerance);
  CHECK(difference(a.mass, b.mass) < tolerance);
  CHECK(difference(a.energies, b.energies) < tolerance);
  if (!fields) return;
  CHECK(difference(a.fields.membrane_strain, b.fields.membrane_strain) < tolerance);
  CHECK(difference(a.fields.membrane_force, b.fields.membrane_force) < tolerance);
  CHECK(difference(a.fields.curvature, b.fields.curvature) < 10.0 * tolerance);
  CHECK(difference(a.fields.bending_moment, b.fields.bending_moment) < 10.0 * tolerance);
}

}  // namespace

TEST_CASE("a plate in four panels that lie anywhere answers as the uncut one") {
  for (const Pattern pattern : {Pattern::jittered, Pattern::gmsh, Pattern::split}) {
    if (extent(false, pattern != Pattern::gmsh)) continue;
    for (const auto bending :
         {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle, energy::BendingOperator::six_node})
      for (const auto membrane : {energy::MembraneOperator::cst, energy::MembraneOperator::six_node,
                                  energy::MembraneOperator::six_node_corrected})
        for (const bool in_plane : {true, false}) {
          CAPTURE(name_of(pattern));
          CAPTURE(in_plane);
          const mesh::MeshData whole = with_quarters(square(pattern, 7));
          const mesh::SurfaceMesh uncut(whole);
          const mesh::SurfaceMesh panels(cut(
              whole, [&](Index t) { return quarter(whole, whole.triangles[t]); }, in_plane));
          REQUIRE(panels.has_charts());
          system::ModelInput in = plate_input(bending, membrane);
          in.materials = quarter_materials(false, in_plane);
          system::Model expected(PETSC_COMM_WORLD, uncut, in);
          in.materials = quarter_materials(true, in_plane);
          system::Model model(PETSC_COMM_WORLD, panels, in);
          check_same(ask(model, noise(0.05, 9)), ask(expected, noise(0.05, 9)), true);
        }
  }
}

TEST_CASE(
    "large deflections of a plate in four panels, and of one in as many as it has triangles, are those of the uncut "
    "one") {
  const mesh::MeshData whole = with_quarters(square(Pattern::jittered, 8));
  system::ModelInput in = plate_input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node);
  in.materials = quarter_materials(false, false);
  const mesh::SurfaceMesh uncut(whole);
  system::Model expected(PETSC_COMM_WORLD, uncut, in);
  const std::vector<Vec3> u = equilibrium(expected);
  double largest = 0.0;
  for (const Vec3& d : u) largest = std::max(largest, d.norm());
  REQUIRE(largest > 0.1);  // of a thickness of 0.1 and a side of 1
  const mesh::SurfaceMesh panels(cut(
      whole, [&](Index t) { return quarter(whole, whole.triangles[t]); }, false));
  system::ModelInput charted = in;
  charted.materials = quarter_materials(true, false);
  system::Model model(PETSC_COMM_WORLD, panels, charted);
  CHECK(difference(equilibrium(model), u) < 1e-12);

  in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
  const mesh::SurfaceMesh shreds(cut(
      whole, [](Index t) { return static_cast<int>(t); }, false));
  system::Model plain(PETSC_COMM_WORLD, uncut, in), shredded(PETSC_COMM_WORLD, shreds, in);
  check_same(ask(shredded, noise(0.05, 9)), ask(plain, noise(0.05, 9)), false);
  CHECK(difference(equilibrium(shredded), equilibrium(plain)) < 1e-12);
}

TEST_CASE("a curved shell whose rest shape lies elsewhere answers as in place") {
  const mesh::MeshData in_place = mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
    return Vec3(x[0], x[1], 0.25 * std::sin(2.0 * x[0]) + 0.15 * x[1] * x[1]);
  });
  for (const auto bending :
       {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle, energy::BendingOperator::six_node}) {
    system::ModelInput in;
    in.element.bending = bending;
    in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
    in.supports = {support("left", system::Support::Kind::clamped), support("top", system::Support::Kind::hinged)};
    in.loads = {load(system::Load::Kind::gravity, "", Vec3(0.1, 0.2, -0.3))};
    const mesh::SurfaceMesh mesh(in_place), moved(cut(
                                                in_place, [](Index) { return 0; }, false));
    system::Model expected(PETSC_COMM_WORLD, mesh, in), model(PETSC_COMM_WORLD, moved, in);
    check_same(ask(model, noise(0.05, 9)), ask(expected, noise(0.05, 9)), false, 2e-12);
    const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
    model.conditions().set_load_factor(0.0);
    model.residual(a, f);
    CHECK(norm(f) < 1e-12);
    // The same numbers as corners as in the positions: planes of symmetry are in the chart then.
    in.supports.push_back(support("bottom", system::Support::Kind::symmetry));
    in.supports.back().normal = Vec3::UnitY();
    mesh::MeshData repeated = in_place;
    for (const mesh::Triangle& t : in_place.triangles)
      repeated.rest.push_back({in_place.positions[t[0]], in_place.positions[t[1]], in_place.positions[t[2]]});
    const mesh::SurfaceMesh again(repeated);
    system::Model mirrored(PETSC_COMM_WORLD, mesh, in), same(PETSC_COMM_WORLD, again, in);
    check_same(ask(same, noise(0.05, 9)), ask(mirrored, noise(0.05, 9)), true);
  }
}

TEST_CASE("charts of curved pieces, uneven seams, clamps that turn: forces and tangents are derivatives") {
  // A curved shell in four charts, bent at the start into another shape, one panel 15 % larger than its place.
  const mesh::MeshData flat = square(Pattern::jittered, 6);
  mesh::MeshData d =
      mapped(flat, [](const Vec3& x) { return Vec3(x[0], x[1], 0.25 * std::sin(2.0 * x[0]) + 0.15 * x[1] * x[1]); });
  d = cut(
      d, [&](Index t) { return quarter(flat, flat.triangles[t]); }, false);
  for (std::size_t t = 0; t < d.rest.size(); ++t)
    if (quarter(flat, d.triangles[t]) == 3)
      for (Vec3& x : d.rest[t]) x *= 1.15;
  for (std::size_t v = 0; v < d.positions.size(); ++v)
    d.positions[v][2] = -0.2 * flat.positions[v][0] * flat.positions[v][0];
  const mesh::SurfaceMesh mesh(d);
  system::ModelInput in;
  in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
  const auto turn = [](double t) { return Mat3(Eigen::AngleAxisd(t, Vec3::UnitY()).toRotationMatrix()); };
  system::Support top = support("top", system::Support::Kind::symmetry);
  top.normal = Vec3::UnitY();
  for (const bool turning : {false, true}) {
    system::Support left = support("left", system::Support::Kind::clamped);
    if (turning) {
      left.motion = [&](const Vec3& x, double t) { return Vec3(turn(t) * x - x); };
      left.rotation = turn;
    }
    in.supports = {left, top};
    for (const auto& [bending, membrane] :
         {std::pair{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node},
          std::pair{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected},
          std::pair{energy::BendingOperator::edge_angle, energy::MembraneOperator::six_node}})
      for (const double viscosity : {0.0, 0.5}) {
        in.element.bending = bending;
        in.element.membrane = membrane;
        system::Model model(PETSC_COMM_WORLD, mesh, in);
        model.set_time(0.4);
        const petsc::VecHandle start = model.dofs().create_vector();
        model.potential().start_step(start, viscosity);
        const Slopes s = slopes(model, 0.02);
        CHECK(s.force < 1e-9);
        CHECK(s.tangent < 1e-8);
      }
  }
}

TEST_CASE("curvature by angles is per length at rest of each panel, beside the triangles at the seam") {
  constexpr int n = 8;
  constexpr double larger = 1.15, radius = 0.3;
  const mesh::MeshData whole = square(Pattern::diagonal, n);
  const auto right = [&](Index t) {
    const mesh::Triangle& v = whole.triangles[t];
    return (whole.positions[v[0]] + whole.positions[v[1]] + whole.positions[v[2]])[0] > 1.5;
  };
  mesh::MeshData d = cut(
      whole, [&](Index t) { return right(t) ? 1 : 0; }, true);
  for (std::size_t t = 0; t < d.rest.size(); ++t)
    if (right(static_cast<Index>(t)))
      for (Vec3& x : d.rest[t]) x *= larger;
  const mesh::SurfaceMesh mesh(d);
  system::ModelInput in;
  in.element.bending = energy::BendingOperator::edge_angle;
  in.materials = {isotropic(100.0, 0.0, 0.1, 1.0)};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector();
  const auto roll = [&](const Vec3& x) {
    return Vec3(radius * std::sin(x[0] / radius), x[1], radius * (1.0 - std::cos(x[0] / radius)));
  };
  set_displacement(model, a, [&](Index v) { return Vec3(roll(mesh.positions()[v]) - mesh.positions()[v]); });
  // The same where it starts rolled up.
  mesh::MeshData bent = d;
  for (Vec3& x : bent.positions) x = roll(x);
  const mesh::SurfaceMesh bent_mesh(bent);
  system::Model rolled(PETSC_COMM_WORLD, bent_mesh, in);
  const petsc::VecHandle none = rolled.dofs().create_vector();
  CHECK(system::energies(rolled, none).bending == relative(system::energies(model, a).bending).epsilon(1e-10));
  const system::TriangleFields fields = model.triangle_fields(a);
  if (mpi::rank(PETSC_COMM_WORLD) > 0) return;
  int found = 0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    bool inside = true;
    int on_seam = 0;
    for (const Index v : mesh.triangles()[t]) on_seam += whole.positions[v][0] == 0.5 ? 1 : 0;
    for (const Index v : mesh.triangles()[t])
      for (int k = 0; k < 2; ++k) inside = inside && std::abs(whole.positions[v][k] - 0.5) < 0.5 - 1.5 / n;
    if (!inside || on_seam == 2) continue;
    const double* kappa = fields.curvature.data() + 3 * static_cast<std::size_t>(t);
    CHECK(kappa[0] + kappa[1] == relative(1.0 / (right(t) ? larger * radius : radius)).epsilon(1e-9));
    ++found;
  }
  CHECK(found == 2 * (n - 4) * (n - 5));
}

TEST_CASE("a panel larger than its place is compressed, up to the seam; too large it is refused") {
  mesh::MeshData whole = square(Pattern::jittered, 8);
  const auto right = [&](Index t) {
    const mesh::Triangle& v = whole.triangles[t];
    return (whole.positions[v[0]] + whole.positions[v[1]] + whole.positions[v[2]])[0] > 1.5;
  };
  const auto enlarged = [&](double factor) {
    mesh::MeshData d = cut(
        whole, [](Index) { return 0; }, true);
    for (Index t = 0; t < static_cast<Index>(d.triangles.size()); ++t)
      if (right(t))
        for (Vec3& x : d.rest[t]) x *= factor;
    return d;
  };
  const mesh::SurfaceMesh mesh(enlarged(1.1));
  system::Model model(PETSC_COMM_WORLD, mesh, free_sheet(0.3));
  const petsc::VecHandle a = model.dofs().create_vector();
  const std::vector<double> strain = model.triangle_fields(a).membrane_strain;
  for (std::size_t i = 0; i < strain.size(); ++i) {
    const auto t = static_cast<Index>(i / 3);
    // The gradients of the two sides of an edge, each on its own rest shape, weighted by rest areas.
    const auto own = [&](Index of) { return right(of) ? 1.0 / 1.1 : 1.0; };
    const auto green = [](double g) { return 0.5 * (g * g - 1.0); };
    double wanted = 0.1 * green(own(t));
    for (int s = 0; s < 3; ++s) {
      const Index n = mesh.neighbour(t, s);
      const double fraction = n == no_index ? 1.0 : mesh.area(t) / (mesh.area(t) + mesh.area(n));
      wanted += 0.3 * green(fraction * own(t) + (1.0 - fraction) * own(n == no_index ? t : n));
    }
    CHECK(strain[i] == relative(i % 3 < 2 ? wanted : 0.0).scale(1.0).epsilon(1e-13));
  }
  // Where the sheet is flat it does not bend, however its panels differ.
  CHECK(std::abs(system::energies(model, a).bending) < 1e-3 * system::energies(model, a).membrane);
  CHECK_THROWS_WITH_AS(mesh::SurfaceMesh(enlarged(4.5)), doctest::Contains("differ in length by a factor of 4.5"),
                       UserError);
}

TEST_CASE("panels from texture coordinates") {
  mesh::MeshData d = sheet(12, 3, 0.5, 0.1, true, rolled(0.5));
  const std::vector<std::array<Vec3, 3>> rest = d.rest;
  for (const auto& corners : rest) {
    std::array<Vec2, 3> uv;
    for (int i = 0; i < 3; ++i) uv[i] = 100.0 * corners[i].head<2>();
    d.texture.push_back(uv);
  }
  d.rest.clear();
  mesh::MeshData good = d;
  mesh::take_rest_from_texture(good, 0.01);
  for (std::size_t t = 0; t < rest.size(); ++t)
    for (int i = 0; i < 3; ++i) CHECK((good.rest[t][i] - rest[t][i]).norm() < 1e-14);
  // One triangle the other way round in the file: its corners turn with it.
  std::swap(good.triangles[5][1], good.triangles[5][2]);
  std::swap(good.rest[5][1], good.rest[5][2]);
  const mesh::SurfaceMesh mesh(good);
  CHECK_NOTHROW(mesh::check_panels(mesh));
  CHECK(mesh::seam_notes(mesh).front().find("; 3 edges are seams") != std::string::npos);
  const auto refused = [](mesh::MeshData wrong, double unit) { mesh::take_rest_from_texture(wrong, unit); };
  mesh::MeshData wrong = d;
  wrong.texture.clear();
  CHECK_THROWS_WITH_AS(refused(wrong, 0.01), doctest::Contains("rest = \"texture\": the file has no texture"),
                       UserError);
  wrong = d;
  wrong.texture[7][1][0] = std::nan("");
  CHECK_THROWS_WITH_AS(refused(wrong, 0.01), doctest::Contains("1 of 72 triangles have no texture coordinates"),
                       UserError);
  wrong = d;
  wrong.texture[7][1] = wrong.texture[7][0];
  CHECK_THROWS_WITH_AS(refused(wrong, 0.01), doctest::Contains("have no area in their texture coordinates"), UserError);
  CHECK_THROWS_WITH_AS(refused(d, 1.0), doctest::Contains("texture_unit = 1 is wrong, with 0.0099"), UserError);
  CHECK_THROWS_WITH_AS(refused(d, 1e-5), doctest::Contains("texture_unit = 1e-05 is wrong"), UserError);
  mesh::MeshData mirrored = good;
  for (std::size_t t = 0; t < 10; ++t)
    for (Vec3& x : mirrored.rest[t]) x[0] *= -1.0;
  CHECK_THROWS_WITH_AS(mesh::check_panels(mesh::SurfaceMesh(mirrored)),
                       doctest::Contains("10 of 72 triangles are mirror"), UserError);
}

}  // namespace test_charts
