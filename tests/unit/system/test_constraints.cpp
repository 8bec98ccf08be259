// Supports resolved to local axes and mirrored sides, and the contradictions that are refused.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "system/constraints.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_constraints {

using namespace voile;
using namespace voile::testing;
using Kind = system::Support::Kind;

namespace {

system::Support displacement(const std::string& group, std::array<bool, 3> components, const Vec3& value) {
  system::Support s = support(group, Kind::displacement);
  s.components = components;
  s.value = value;
  return s;
}

system::Support symmetry(const std::string& group, const Vec3& normal) {
  system::Support s = support(group, Kind::symmetry);
  s.normal = normal;
  return s;
}

std::string refusal(const mesh::SurfaceMesh& mesh, const std::vector<system::Support>& supports) {
  try {
    (void)system::resolve_supports(mesh, supports);
  } catch (const UserError& e) {
    return e.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

bool is_rotation(const Mat3& q) {
  return (q.transpose() * q - Mat3::Identity()).norm() < 1e-14 && std::abs(q.determinant() - 1.0) < 1e-14;
}

using Fixed = std::array<bool, 3>;

mesh::MeshData turned_about_z(const mesh::MeshData& d, double angle) {
  const Eigen::AngleAxisd turn(angle, Vec3::UnitZ());
  return mapped(d, [&](const Vec3& x) { return Vec3(turn * x); });
}

}  // namespace

TEST_CASE("supports along the axes keep the global axes") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 4));
  const auto c = system::resolve_supports(
      mesh, {displacement("left", {true, false, true}, {0.1, 7.0, 0.2}),
             displacement("top", {false, true, false}, {0.0, -0.3, 0.0}), symmetry("right", {-2.0, 0.0, 0.0})});
  CHECK(c.vertices.size() == 13);
  for (const auto& [v, s] : c.vertices) {
    CHECK(s.axes == Mat3::Identity());
    CHECK_FALSE(s.rotated());
  }
  const auto at = [&](int i, int j) { return c.vertices.at(5 * j + i); };
  CHECK(at(0, 2).fixed == Fixed{true, false, true});
  CHECK((at(0, 2).value - Vec3(0.1, 0.0, 0.2)).norm() < 1e-16);
  CHECK(at(2, 4).fixed == Fixed{false, true, false});
  CHECK(at(0, 4).fixed == Fixed{true, true, true});
  CHECK((at(0, 4).value - Vec3(0.1, -0.3, 0.2)).norm() < 1e-15);
  CHECK(at(4, 2).fixed == Fixed{true, false, false});
  CHECK(at(4, 4).fixed == Fixed{true, true, false});
  CHECK(c.mirrors.size() == 4);
}

TEST_CASE("a symmetry plane that is found along an axis keeps the global axes") {
  const mesh::SurfaceMesh mesh(mapped(square(Pattern::diagonal, 4),
                                      [](const Vec3& x) { return Vec3(x[0], x[1], 0.2 * x[1] * x[1] + 0.1 * x[0]); }));
  const auto c = system::resolve_supports(mesh, {support("left", Kind::symmetry)});
  for (const auto& [v, s] : c.vertices) {
    CHECK_FALSE(s.rotated());
    CHECK(s.fixed == Fixed{true, false, false});
  }
}

TEST_CASE("an oblique symmetry plane gives its normal as first axis") {
  const double angle = 0.6;
  const mesh::SurfaceMesh mesh(turned_about_z(square(Pattern::diagonal, 4), angle));
  const Vec3 nu(std::cos(angle), std::sin(angle), 0.0);
  const auto c = system::resolve_supports(mesh, {symmetry("left", 3.0 * nu)});  // any length
  REQUIRE(c.vertices.size() == 5);
  for (const auto& [v, s] : c.vertices) {
    CHECK(is_rotation(s.axes));
    CHECK(s.rotated());
    CHECK(std::abs(std::abs(s.axes.col(0).dot(nu)) - 1.0) < 1e-15);
    CHECK(s.fixed == Fixed{true, false, false});
    CHECK(s.value.norm() < 1e-16);
  }
  REQUIRE(c.mirrors.size() == 4);
  for (const mesh::MirrorSide& m : c.mirrors) {
    CHECK(mesh.neighbour(m.triangle, m.side) == no_index);
    CHECK((m.reflection - (Mat3::Identity() - 2.0 * nu * nu.transpose())).norm() < 1e-15);
  }
}

TEST_CASE("a symmetry plane that does not hold its group is refused by vertex") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 4));
  CHECK_THROWS_WITH_AS((void)system::resolve_supports(mesh, {symmetry("left", Vec3(1.0, 0.5, 0.0))}),
                       doctest::Contains("does not lie in the plane"), UserError);
}

TEST_CASE("two oblique planes leave their line, a third direction leaves nothing") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 4));
  // Planes through the edges: "left" runs along y, "bottom" along x.
  const Vec3 p = Vec3(1.0, 0.0, 0.2).normalized(), q = Vec3(0.0, 1.0, -0.4).normalized();
  const auto corner = [&](std::vector<system::Support> supports) {
    return system::resolve_supports(mesh, supports).vertices.at(0);
  };
  const system::VertexSupport two = corner({symmetry("left", p), symmetry("bottom", q)});
  CHECK(is_rotation(two.axes));
  CHECK(two.fixed == Fixed{true, true, false});
  CHECK(std::abs(two.axes.col(2).dot(p)) < 1e-14);
  CHECK(std::abs(two.axes.col(2).dot(q)) < 1e-14);
  CHECK(two.value.norm() < 1e-15);

  const system::VertexSupport same = corner({symmetry("left", p), symmetry("left", -p)});
  CHECK(same.fixed == Fixed{true, false, false});
  CHECK(std::abs(std::abs(same.axes.col(0).dot(p)) - 1.0) < 1e-14);

  // A prescribed component meets an oblique plane: u.p = 0 and u_y = 0.7.
  const system::VertexSupport mixed =
      corner({symmetry("left", p), displacement("bottom", {false, true, false}, {0.0, 0.7, 0.0})});
  CHECK(is_rotation(mixed.axes));
  CHECK(mixed.fixed == Fixed{true, true, false});
  for (const double free : {0.0, 1.3}) {  // whatever the free component does
    const Vec3 u = mixed.axes * Vec3(mixed.value[0], mixed.value[1], free);
    CHECK(std::abs(u.dot(p)) < 1e-15);
    CHECK(std::abs(u.y() - 0.7) < 1e-15);
  }

  const system::VertexSupport all = corner({symmetry("left", p), support("bottom", Kind::hinged)});
  CHECK(all.fixed == Fixed{true, true, true});
  CHECK_FALSE(all.rotated());
}

TEST_CASE("equal values prescribed twice agree, different ones are refused with the vertex's name") {
  mesh::MeshData d = square(Pattern::diagonal, 2);
  d.vertex_tags = {51, 52, 53, 54, 55, 56, 57, 58, 59};
  const mesh::SurfaceMesh mesh(d);
  const system::Support left = displacement("left", {true, false, false}, {0.1, 0.0, 0.0});
  CHECK(refusal(mesh, {left, displacement("bottom", {true, true, false}, {0.1, 0.4, 0.0})}).empty());
  const std::string text = refusal(mesh, {left, displacement("bottom", {true, true, false}, {0.2, 0.4, 0.0})});
  CHECK(contains(text, "contradicting"));
  CHECK(contains(text, "vertex 51"));
  CHECK(contains(text, "(0, 0, 0)"));
  // A symmetry plane against a motion out of it.
  CHECK(contains(refusal(mesh, {left, symmetry("left", {1.0, 0.0, 0.0})}), "contradicting"));
}

TEST_CASE("what has no slope across an edge cannot be clamped") {
  mesh::MeshData d = square(Pattern::diagonal, 4);
  d.groups.push_back({"cut", 1, {10, 11, 12}, {{10, 11}, {11, 12}}, {}});
  d.groups.push_back({"tip", 0, {12}, {}, {}});
  const mesh::SurfaceMesh mesh(d);
  for (const Kind kind : {Kind::clamped, Kind::symmetry}) {
    const std::string text = refusal(mesh, {support("cut", kind)});
    CHECK(contains(text, "'cut'"));
    CHECK(contains(text, "11-12"));
    CHECK(contains(text, "inside the surface"));
  }
  CHECK(refusal(mesh, {support("cut", Kind::hinged)}).empty());
  CHECK(contains(refusal(mesh, {support("tip", Kind::clamped)}), "'tip'"));
  CHECK(contains(refusal(mesh, {support("tip", Kind::clamped)}), "no slope"));
  CHECK(contains(refusal(mesh, {support("tip", Kind::symmetry)}), "no curve group 'tip'"));
  CHECK(contains(refusal(mesh, {support("nowhere", Kind::hinged)}), "'nowhere'"));
  CHECK(refusal(mesh, {support("tip", Kind::hinged)}).empty());
}

TEST_CASE("a clamped edge fixes its vertices and turns across each facet's normal") {
  const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 4),
                                      [](const Vec3& x) { return Vec3(x[0], x[1], 0.3 * x[0] + 0.4 * x[1] * x[1]); }));
  system::Support s = support("left", Kind::clamped);
  s.value = Vec3(0.0, 0.2, 0.5);
  const auto c = system::resolve_supports(mesh, {s});
  REQUIRE(c.mirrors.size() == 4);
  for (const mesh::MirrorSide& m : c.mirrors) {
    const Vec3 n = mesh.rest_normal(m.triangle);
    CHECK((m.reflection * n - n).norm() < 1e-15);
    CHECK((m.reflection + Mat3::Identity() - 2.0 * n * n.transpose()).norm() < 1e-15);
  }
  CHECK(c.vertices.size() == 5);
  for (const auto& [v, held] : c.vertices) {
    CHECK(held.fixed == Fixed{true, true, true});
    CHECK((held.value - s.value).norm() < 1e-15);
  }
}

TEST_CASE("the symmetry plane of a group is found where the mesh determines it") {
  const double angle = 0.6;
  const Vec3 nu(std::cos(angle), std::sin(angle), 0.0);
  const auto parallel = [&](const system::Constraints& c) {
    REQUIRE(c.mirrors.size() == 6);
    for (const mesh::MirrorSide& m : c.mirrors)
      CHECK((m.reflection - (Mat3::Identity() - 2.0 * nu * nu.transpose())).norm() < 1e-12);
    for (const auto& [v, s] : c.vertices) CHECK(std::abs(std::abs(s.axes.col(0).dot(nu)) - 1.0) < 1e-12);
  };
  SUBCASE("planar curved edge") {
    const mesh::SurfaceMesh mesh(turned_about_z(mapped(square(Pattern::jittered, 6),
                                                       [](const Vec3& x) {
                                                         return Vec3(x[0], std::sin(1.5 * x[1]),
                                                                     std::cos(1.5 * x[1]));  // the arc at x = 0
                                                       }),
                                                angle));
    parallel(system::resolve_supports(mesh, {support("left", Kind::symmetry)}));
  }
  SUBCASE("straight edge of a flat surface") {
    const mesh::SurfaceMesh mesh(turned_about_z(square(Pattern::jittered, 6), angle));
    parallel(system::resolve_supports(mesh, {support("left", Kind::symmetry)}));
  }
  SUBCASE("straight edge of a curved surface needs the normal") {
    const mesh::SurfaceMesh mesh(turned_about_z(mapped(square(Pattern::jittered, 6),
                                                       [](const Vec3& x) {
                                                         return Vec3(std::sin(1.5 * x[0]), x[1],
                                                                     std::cos(1.5 * x[0]));  // generator at x = 0
                                                       }),
                                                angle));
    const std::string text = refusal(mesh, {support("left", Kind::symmetry)});
    CHECK(contains(text, "'left'"));
    CHECK(contains(text, "normal"));
    parallel(system::resolve_supports(mesh, {symmetry("left", nu)}));
  }
  SUBCASE("an edge in no plane") {
    const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
      return Vec3(0.2 * x[1] * x[1] * x[1] + x[0], std::sin(1.5 * x[1]), std::cos(1.5 * x[1]));
    }));
    CHECK(contains(refusal(mesh, {support("left", Kind::symmetry)}), "do not lie in a plane"));
  }
}

TEST_CASE("supports that share a vertex each move what they hold, and equal motions are one") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 4));
  const auto moved = [](const std::string& group, Fixed held, const Vec3& speed) {
    system::Support s = displacement(group, held, Vec3::Zero());
    s.motion = [speed](const Vec3&, double t) { return Vec3(t * speed); };
    return s;
  };
  const auto across = moved("left", {true, false, false}, Vec3(0.1, 0.0, 5.0));
  const auto along = moved("bottom", {false, true, false}, Vec3(3.0, 0.2, 0.0));
  const auto still = displacement("bottom", {false, false, true}, Vec3::Zero());
  system::ModelInput in;
  in.materials = {isotropic(100.0, 0.3, 0.2, 1.0)};
  in.supports = {across, along, still};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector();
  model.set_time(2.0);
  model.conditions().enforce(a);
  const std::vector<double> u = model.dofs().gather(a);
  for (Index v = 0; v < mesh.vertex_count() && !u.empty(); ++v) {
    const Vec3& x = mesh.positions()[v];
    const Vec3 expected(x.x() == 0.0 ? 0.2 : 0.0, x.y() == 0.0 ? 0.4 : 0.0, 0.0);
    CHECK((Vec3(Eigen::Map<const Vec3>(&u[3 * static_cast<std::size_t>(v)])) - expected).norm() < 1e-15);
  }
  // What one moves another one must not hold; at rest the motion along y and z is none.
  CHECK(contains(refusal(mesh, {across, support("bottom", Kind::hinged)}), "moves vertex"));
  CHECK(refusal(mesh, {moved("left", {true, true, true}, Vec3(0.1, 0.0, 0.0)),
                       displacement("bottom", {false, true, true}, Vec3::Zero())})
            .empty());
  auto one = moved("left", {true, true, true}, Vec3::Ones()), other = moved("bottom", {true, true, true}, Vec3::Ones());
  CHECK(contains(refusal(mesh, {one, other}), "both move vertex"));
  one.motion_text = other.motion_text = "t, t, t";
  CHECK(refusal(mesh, {one, other}).empty());
  other.motion_text = "t, t, 2*t";
  CHECK(contains(refusal(mesh, {one, other}), "both move vertex"));
}

}  // namespace test_constraints
