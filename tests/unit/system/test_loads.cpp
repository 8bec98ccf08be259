// Nodal forces: resultants, moments, and their balance with the reactions.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <set>

#include "solve/load_path.hpp"
#include "system/gas.hpp"
#include "test_following.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_loads {

using namespace voile;
using namespace voile::testing;
using LoadKind = system::Load::Kind;

namespace {

/// A curved sheet on the unit square; its boundary is curved too, its left edge straight.
mesh::MeshData curved_sheet(int n) {
  return mapped(square(Pattern::jittered, n),
                [](const Vec3& x) { return Vec3(x[0], x[1], 0.3 * std::sin(2.0 * x[0]) + 0.2 * x[0] * x[1] * x[1]); });
}

Vec3 sum(const std::vector<Vec3>& forces) {
  Vec3 total = Vec3::Zero();
  for (const Vec3& f : forces) total += f;
  return total;
}

Vec3 moment(const std::vector<Vec3>& x, const std::vector<Vec3>& forces) {
  Vec3 total = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) total += x[i].cross(forces[i]);
  return total;
}

/// Applied force per vertex in the state `a` (minus what the unbalanced force gains by the load factor).
std::vector<Vec3> applied(system::Model& model, Vec a, double factor) {
  petsc::VecHandle with = model.dofs().create_vector(), without = model.dofs().create_vector();
  model.conditions().set_load_factor(factor);
  model.unbalanced_force(a, with);
  model.conditions().set_load_factor(0.0);
  model.unbalanced_force(a, without);
  VOILE_PETSC(VecAXPY(without, -1.0, with));
  return per_vertex(model, without);
}

system::ModelInput free_sheet(std::vector<system::Load> loads) {
  system::ModelInput input;
  input.materials = {isotropic(1.0, 0.3, 0.1, 2.5)};
  input.loads = std::move(loads);
  return input;
}

/// Applied forces at rest, from the residual of a free sheet.
std::vector<Vec3> at_rest(const mesh::SurfaceMesh& mesh, const system::ModelInput& input, double factor = 1.0) {
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
  model.conditions().set_load_factor(factor);
  model.residual(a, r);
  std::vector<Vec3> f = per_vertex(model, r);
  for (Vec3& x : f) x = -x;
  return f;
}

/// Area vector of the surface from its boundary alone: 1/2 of the closed integral of x cross dx.
Vec3 area_vector(const mesh::SurfaceMesh& mesh) {
  Vec3 total = Vec3::Zero();
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s)
      if (mesh.neighbour(t, s) == no_index)
        total += 0.5 * mesh.rest_corner(t, (s + 1) % 3).cross(mesh.rest_corner(t, (s + 2) % 3));
  return total;
}

/// A sphere of radius 1 from an octahedron, each triangle divided into four `levels` times.
mesh::MeshData sphere(int levels) {
  mesh::MeshData d;
  d.source = "sphere";
  d.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  d.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<Index, Index>, Index> middle;
    const auto between = [&](Index a, Index b) {
      const auto [found, isnew] = middle.emplace(std::minmax(a, b), static_cast<Index>(d.positions.size()));
      if (isnew) d.positions.push_back((d.positions[a] + d.positions[b]).normalized());
      return found->second;
    };
    std::vector<mesh::Triangle> finer;
    for (const auto& [a, b, c] : d.triangles) {
      const Index ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    d.triangles.swap(finer);
  }
  return d;
}

/// |K^T x - K x| / |K x| for a rough x.
double asymmetry(system::Model& model, Vec a) {
  petsc::VecHandle x = model.dofs().create_vector(), kx = model.dofs().create_vector(),
                   ktx = model.dofs().create_vector();
  set_displacement(model, x, noise(1.0, 23));
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatMult(model.tangent().matrix(), x, kx));
  VOILE_PETSC(MatMultTranspose(model.tangent().matrix(), x, ktx));
  VOILE_PETSC(VecAXPY(ktx, -1.0, kx));
  return norm(ktx) / norm(kx);
}

}  // namespace

TEST_CASE("the forces of dead loads add up to the exact resultant") {
  mesh::MeshData d = curved_sheet(6);
  d.groups.push_back({"some", 0, {3, 17, 20}, {}, {}});
  mesh::Group half{"half", 2, {}, {}, {}};
  for (Index t = 0; t < 31; ++t) half.triangles.push_back(t);
  d.groups.push_back(half);
  const mesh::SurfaceMesh mesh(d);
  const Vec3 q(0.3, -0.7, 1.1);
  const double area = total_area(mesh);
  double half_area = 0.0;
  for (Index t : half.triangles) half_area += mesh.area(t);
  const auto resultant = [&](const system::Load& l) { return sum(at_rest(mesh, free_sheet({l}))); };
  CHECK((resultant(load(LoadKind::point, "some", q)) - 3.0 * q).norm() < 1e-14);
  CHECK((resultant(load(LoadKind::line, "left", q)) - q).norm() < 1e-14);  // a straight edge of length 1
  double right = 0.0;
  for (const mesh::Segment& s : mesh.group("right", 1).segments)
    right += (mesh.positions()[s[0]] - mesh.positions()[s[1]]).norm();
  CHECK(right > 1.01);
  CHECK((resultant(load(LoadKind::line, "right", q)) - right * q).norm() < 1e-14);
  CHECK((resultant(load(LoadKind::area, "", q)) - area * q).norm() < 1e-13);
  CHECK((resultant(load(LoadKind::area, "half", q)) - half_area * q).norm() < 1e-13);
  CHECK((resultant(load(LoadKind::gravity, "", q)) - 2.5 * area * q).norm() < 1e-13);
  CHECK((resultant(load(LoadKind::gravity, "half", q)) - 2.5 * half_area * q).norm() < 1e-13);
  for (const LoadKind kind : {LoadKind::pressure, LoadKind::follower_pressure})
    CHECK((resultant(load(kind, "", 1.7)) - 1.7 * area_vector(mesh)).norm() < 1e-13);
}

TEST_CASE("forces act where the load is") {
  const mesh::SurfaceMesh mesh(curved_sheet(6));
  // A line load: only on the edge, moment about the origin that of the edge's centre.
  const Vec3 q(0.3, -0.7, 1.1);
  const std::vector<Vec3> line = at_rest(mesh, free_sheet({load(LoadKind::line, "left", q)}));
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.positions()[v].x() > 1e-9) CHECK(line[v].norm() < 1e-15);  // round-off of the internal forces
  CHECK((moment(mesh.positions(), line) - Vec3(0.0, 0.5, 0.0).cross(q)).norm() < 1e-14);
  // Gravity: a uniform field has the moment of the facets' centres.
  const std::vector<Vec3> weight = at_rest(mesh, free_sheet({load(LoadKind::gravity, "", q)}));
  Vec3 expected = Vec3::Zero();
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    expected +=
        2.5 * mesh.area(t) * (mesh.rest_corner(t, 0) + mesh.rest_corner(t, 1) + mesh.rest_corner(t, 2)).cross(q) / 3.0;
  CHECK((moment(mesh.positions(), weight) - expected).norm() < 1e-13);
}

TEST_CASE("gravity on the parts of a sheet is that on the whole, masses where they meet too") {
  mesh::MeshData data = square(Pattern::jittered, 4);
  mesh::Group west{"west", 2, {}, {}, {}}, east{"east", 2, {}, {}, {}};
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    double x = 0.0;
    for (const Index v : data.triangles[t]) x += data.positions[v][0] / 3.0;
    (x < 0.5 ? west : east).triangles.push_back(static_cast<Index>(t));
  }
  for (mesh::Group* g : {&west, &east}) {
    std::set<Index> of;
    for (const Index t : g->triangles) of.insert(data.triangles[t].begin(), data.triangles[t].end());
    g->vertices.assign(of.begin(), of.end());
  }
  data.groups.push_back(west);
  data.groups.push_back(east);
  const mesh::SurfaceMesh mesh(data);
  system::ModelInput parts =
      free_sheet({load(LoadKind::gravity, "west", Vec3(0, 0, -1)), load(LoadKind::gravity, "east", Vec3(0, 0, -1))});
  parts.masses = {{"bottom", 3.0}};
  system::ModelInput whole = parts;
  whole.loads = {load(LoadKind::gravity, "", Vec3(0, 0, -1))};
  const std::vector<Vec3> by_parts = at_rest(mesh, parts), at_once = at_rest(mesh, whole);
  for (std::size_t v = 0; v < by_parts.size(); ++v) CHECK((by_parts[v] - at_once[v]).norm() < 1e-12);
  // A mass on the group of the load weighs in full there.
  whole.loads = {load(LoadKind::gravity, "west", Vec3(0, 0, -1))};
  whole.masses.clear();
  const double sheet = sum(at_rest(mesh, whole))[2];
  whole.masses = {{"west", 3.0}};
  const double loaded = sum(at_rest(mesh, whole))[2];
  CHECK(sheet - loaded == relative(3.0 * static_cast<double>(mesh.group("west").vertices.size())).epsilon(1e-12));
}

TEST_CASE("loads follow the load factor unless they are constant") {
  const mesh::SurfaceMesh mesh(curved_sheet(4));
  const Vec3 q(0.3, -0.7, 1.1), g(0.0, 0.0, -9.0);
  system::Load weight = load(LoadKind::gravity, "", g), pressure = load(LoadKind::follower_pressure, "", 1.7);
  weight.constant = pressure.constant = true;
  const Vec3 constant = 2.5 * total_area(mesh) * g + 1.7 * area_vector(mesh);
  const system::ModelInput input =
      free_sheet({load(LoadKind::line, "left", q), weight, pressure, load(LoadKind::follower_pressure, "", 0.4)});
  for (const double factor : {0.0, 0.5, -2.0})
    CHECK((sum(at_rest(mesh, input, factor)) - constant - factor * (q + 0.4 * area_vector(mesh))).norm() < 1e-12);
}

TEST_CASE("loads on vertices with oblique axes are turned into them") {
  const Mat3 turn = Eigen::AngleAxisd(0.6, Vec3(0.1, 0.3, 1.0).normalized()).toRotationMatrix();
  const mesh::SurfaceMesh mesh(mapped(curved_sheet(4), [&](const Vec3& x) { return Vec3(turn * x); }));
  const Vec3 q(0.3, -0.7, 1.1);
  system::ModelInput input = free_sheet({load(LoadKind::line, "left", q), load(LoadKind::follower_pressure, "", 1.7)});
  system::Support s = support("left", system::Support::Kind::symmetry);
  s.normal = turn * Vec3::UnitX();
  input.supports = {s};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector();
  CHECK((sum(applied(model, a, 1.0)) - q - 1.7 * area_vector(mesh)).norm() < 1e-13);
}

TEST_CASE("gravity without any mass is refused") {
  const mesh::SurfaceMesh mesh(curved_sheet(2));
  system::ModelInput input = free_sheet({load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))});
  input.materials[0].areal_density = 0.0;
  CHECK_THROWS_AS((system::Model{PETSC_COMM_WORLD, mesh, input}), UserError);
}

TEST_CASE("pressure in a closed surface: no resultant, the work of the volume, a symmetric stiffness") {
  const mesh::SurfaceMesh mesh(sphere(3));
  REQUIRE(mesh.triangle_count() == 512);
  REQUIRE(mesh.reoriented_count() == 0);
  const double p = 3.0;
  system::ModelInput input = free_sheet({load(LoadKind::follower_pressure, "", p)});
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, noise(0.05, 9));
  std::vector<Vec3> x = mesh.positions();
  for (Index v = 0; v < mesh.vertex_count(); ++v) x[v] += noise(0.05, 9)(v);
  const std::vector<Vec3> f = applied(model, a, 1.0);
  double size = 0.0, virial = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    size += f[i].norm();
    virial += f[i].dot(x[i]);
  }
  system::Load gas = load(LoadKind::gas, "", 1.0);
  gas.exponent = 1.0;
  const system::Model full(PETSC_COMM_WORLD, mesh, free_sheet({gas}));
  const double volume = full.conditions().gases()[0].at(model.potential().configuration(a)).volume;
  CHECK(volume == relative(4.2).epsilon(0.05));
  CHECK(size > 30.0);
  CHECK(sum(f).norm() < 1e-13 * size);
  CHECK(moment(x, f).norm() < 1e-13 * size);
  // f = p dV/dx and V is homogeneous of degree three.
  CHECK(virial == relative(3.0 * p * volume).epsilon(1e-12));
  model.conditions().set_load_factor(1.0);
  CHECK(asymmetry(model, a) < 1e-13);
}

namespace {

/// Volume in which a pressure acts: its work in a growth of the surface about the origin.
double pressed_volume(const mesh::SurfaceMesh& mesh, energy::MembraneOperator membrane) {
  system::ModelInput input = free_sheet({load(LoadKind::follower_pressure, "", 1.0)});
  input.element.membrane = membrane;
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector();
  const std::vector<Vec3> f = applied(model, a, 1.0);
  double virial = 0.0;
  for (std::size_t i = 0; i < f.size(); ++i) virial += f[i].dot(mesh.positions()[i]);
  return virial / 3.0;
}

}  // namespace

TEST_CASE("what pressure acts on encloses the volume of a sphere to the fourth order") {
  const double exact = 4.0 / 3.0 * std::numbers::pi;
  std::vector<double> errors;
  for (const int levels : {2, 3, 4})
    errors.push_back(std::abs(
        pressed_volume(mesh::SurfaceMesh(sphere(levels)), energy::MembraneOperator::six_node_corrected) / exact - 1.0));
  CHECK(errors[0] < 0.01);
  CHECK(errors[1] < errors[0] / 10.0);
  CHECK(errors[2] < errors[1] / 10.0);
}

TEST_CASE("pressure acts on plane triangles between creases, and where the membrane has straight chords") {
  // An octahedron.
  CHECK(pressed_volume(mesh::SurfaceMesh(sphere(0)), energy::MembraneOperator::six_node_corrected) ==
        relative(4.0 / 3.0).epsilon(1e-12));
  const mesh::SurfaceMesh mesh(sphere(2));
  double plane = 0.0;
  for (const mesh::Triangle& t : mesh.triangles())
    plane += mesh.positions()[t[0]].dot(mesh.positions()[t[1]].cross(mesh.positions()[t[2]])) / 6.0;
  CHECK(pressed_volume(mesh, energy::MembraneOperator::six_node) == relative(plane).epsilon(1e-12));
}

TEST_CASE("pressure on an open surface has an unsymmetric stiffness") {
  // Shows that the symmetry of the closed surface is no property of the test.
  const mesh::SurfaceMesh mesh(curved_sheet(6));
  system::Model model(PETSC_COMM_WORLD, mesh, free_sheet({load(LoadKind::follower_pressure, "", 3.0)}));
  petsc::VecHandle a = model.dofs().create_vector();
  CHECK_FALSE(model.conditions().symmetric());
  model.conditions().set_load_factor(1.0);
  CHECK(asymmetry(model, a) > 1e-2);
}

TEST_CASE("a follower moment is a pure couple about the edge") {
  const double m = 2.0;
  const auto check = [&](const mesh::SurfaceMesh& mesh, const std::function<Vec3(Index)>& u) {
    system::Model model(PETSC_COMM_WORLD, mesh, free_sheet({load(LoadKind::follower_moment, "right", m)}));
    petsc::VecHandle a = model.dofs().create_vector();
    set_displacement(model, a, u);
    std::vector<Vec3> x = mesh.positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) x[v] += u(v);
    const std::vector<Vec3> f = applied(model, a, 0.75);
    double size = 0.0;
    for (const Vec3& force : f) size += force.norm();
    REQUIRE(size > 1.0);
    CHECK(sum(f).norm() < 1e-13 * size);
    // The edge is lifted to the positive side: about minus the direction in which the boundary runs
    // (counter-clockwise), M per rest length whatever the current length.
    Vec3 expected = Vec3::Zero();
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      for (const mesh::Segment& s : mesh.group("right", 1).segments) {
        const int side = mesh.side_of(t, s[0], s[1]);
        if (side < 0) continue;
        const Index from = mesh.triangles()[t][(side + 1) % 3], to = mesh.triangles()[t][(side + 2) % 3];
        expected -= 0.75 * m * (mesh.positions()[to] - mesh.positions()[from]).norm() * (x[to] - x[from]).normalized();
      }
    CHECK((moment(x, f) - expected).norm() < 1e-13 * size);
    return expected;
  };
  const mesh::SurfaceMesh flat(square(Pattern::jittered, 6)), curved(curved_sheet(6));
  const Vec3 total = check(flat, [](Index) { return Vec3(Vec3::Zero()); });
  CHECK((total - Vec3(0.0, -0.75 * m, 0.0)).norm() < 1e-14);  // raises the right edge: about -y
  check(curved, noise(0.05, 5));
}

TEST_CASE("a moment inside the surface is refused") {
  mesh::MeshData d = square(Pattern::diagonal, 4);
  d.groups.push_back({"cut", 1, {10, 11, 12}, {{10, 11}, {11, 12}}, {}});
  const mesh::SurfaceMesh mesh(d);
  CHECK_THROWS_AS((system::Model{PETSC_COMM_WORLD, mesh, free_sheet({load(LoadKind::follower_moment, "cut", 1.0)})}),
                  UserError);
}

TEST_CASE("the reactions of a deformed shell balance its loads in force and moment") {
  mesh::MeshData d = curved_sheet(8);
  d.groups.push_back({"middle", 0, {40}, {}, {}});
  const mesh::SurfaceMesh mesh(d);
  const Vec3 point(0.004, -0.002, -0.01), g(0.0, 0.0, -9.81);
  system::ModelInput input;
  input.materials = {isotropic(1e3, 0.3, 0.01, 0.001)};
  input.loads = {load(LoadKind::point, "middle", point), load(LoadKind::gravity, "", g),
                 load(LoadKind::follower_pressure, "", -0.02)};
  input.supports = {support("left", system::Support::Kind::hinged), support("right", system::Support::Kind::hinged)};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  solve::LoadPath path(model, {});
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
  REQUIRE(follow_from(state_of(a), path).completed);
  model.unbalanced_force(a, r);
  const std::vector<Vec3> unbalanced = per_vertex(model, r), u = per_vertex(model, a);
  std::vector<Vec3> reactions(u.size(), Vec3::Zero()), loads(u.size(), Vec3::Zero()), x = mesh.positions();
  for (std::size_t i = 0; i < u.size(); ++i) x[i] += u[i];
  for (const auto& [v, s] : model.discretisation().constraints().vertices) reactions[v] = unbalanced[v];
  loads[40] += point;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Triangle& v = mesh.triangles()[t];
    for (Index i : v)
      loads[i] += 0.001 * g * mesh.area(t) / 3.0 - 0.02 * (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]) / 6.0;
  }
  double size = 0.0, deflection = 0.0;
  for (const Vec3& f : reactions) size += f.norm();
  for (const Vec3& d_v : u) deflection = std::max(deflection, d_v.norm());
  CHECK(deflection > 0.03);  // several thicknesses: a linear solution would not balance the moments
  CHECK(size > 0.02);
  // Newton's own tolerance: |r| <= 1e-8 of the forces.
  CHECK((sum(reactions) + sum(loads)).norm() < 1e-7 * size);
  CHECK((moment(x, reactions) + moment(x, loads)).norm() < 1e-7 * size);
}

}  // namespace test_loads
