// Vertices held to an obstacle that moves and deforms, and elastic bands: on any number of ranks.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "energy/anchor.hpp"
#include "solve/newton.hpp"
#include "system/attachments.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_attachments {

using namespace voile;
using namespace voile::testing;
using SupportKind = system::Support::Kind;

namespace {

/// A block below the unit square, which goes where `motion` says.
contact::Obstacle block(double top, std::function<std::vector<Vec3>(std::vector<Vec3>, double)> motion) {
  contact::Obstacle o;
  o.name = "block";
  for (const double z : {top - 0.5, top})
    for (const auto& [x, y] : {std::pair{-0.5, -0.5}, {1.5, -0.5}, {1.5, 1.5}, {-0.5, 1.5}})
      o.points.emplace_back(x, y, z);
  o.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                 {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  o.frames = [motion, rest = o.points](double t) { return motion(rest, t); };
  return o;
}

std::vector<Vec3> lifted(std::vector<Vec3> points, double t) {
  for (Vec3& x : points) x += t * Vec3(0.3, -0.2, 0.5);
  return points;
}

/// Turns about the z axis and grows.
std::vector<Vec3> turned(std::vector<Vec3> points, double t) {
  for (Vec3& x : points) x = Eigen::AngleAxisd(t, Vec3::UnitZ()) * x;
  return points;
}

system::Attachment hold(const std::string& group, double stiffness) {
  system::Attachment a;
  a.groups = {group};
  a.obstacle = "block";
  a.stiffness = stiffness;
  return a;
}

system::ModelInput input(contact::Obstacle obstacle, const std::vector<system::Attachment>& attachments) {
  system::ModelInput in;
  in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
  in.contact.active = true;
  in.contact.options = {1e-3, 1e4, 1e-3};
  in.contact.obstacles = {std::move(obstacle)};
  in.attachments = attachments;
  return in;
}

constexpr double height = 0.05;  // of the sheet above the block
const char* const edge = "left";

}  // namespace

TEST_CASE("an anchor: force and tangent are derivatives of its energy, none before it has a place") {
  energy::AnchorTerm anchor;
  anchor.add(0, 3.0);
  Vec3 x(0.1, 0.2, -0.3);
  const energy::Configuration c{&x, nullptr, nullptr, energy::Tangent::exact};
  CHECK(anchor.energy(0, c) == 0.0);
  const Vec3 place(0.4, 0.0, 0.1);
  anchor.set_place(0, place);
  CHECK(anchor.energy(0, c) == relative(1.5 * (x - place).squaredNorm()).epsilon(1e-14));
  const auto force = [&] {
    Vec3 f;
    anchor.gradient(0, c, [&](int, const Vec3& g) { f = g; });
    return f;
  };
  Mat3 k;
  anchor.hessian(0, c, [&](int, int, const Mat3& m) { k = m; });
  const double h = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const Vec3 middle = x, here = force();
    x = middle + h * Vec3::Unit(i);
    const double up = anchor.energy(0, c);
    const Vec3 force_up = force();
    x = middle - h * Vec3::Unit(i);
    const double down = anchor.energy(0, c);
    const Vec3 force_down = force();
    x = middle;
    CHECK((up - down) / (2.0 * h) == relative(here[i]).epsilon(1e-8));
    CHECK(((force_up - force_down) / (2.0 * h) - k.col(i)).norm() < 1e-8);
  }
}

TEST_CASE("an anchor goes with its triangle as a rigid body does, from the nearest point") {
  const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1)};
  const std::vector<mesh::Triangle> triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  const std::vector<Vec3> places{Vec3(0.2, 0.3, 0.1), Vec3(-0.4, 0.5, 0.2), Vec3(2.0, -1.0, 0.5), Vec3(0.6, 0.6, 0.3)};
  system::Attachment a;
  a.number = 2;
  const std::vector<system::Anchor> anchors = system::make_anchors(a, {0, 1, 2, 3}, places, points, triangles);
  const std::array nearest{Vec3(0.2, 0.3, 0.0), Vec3(0.0, 0.5, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.5, 0.0)};
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(0.3, 0.1, -0.7) * Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized());
  std::vector<Vec3> moved;
  for (const Vec3& p : points) moved.push_back(motion * p);
  for (std::size_t i = 0; i < 4; ++i) {
    const system::Anchor& one = anchors[i];
    const mesh::Triangle& t = triangles[one.triangle];
    CHECK((system::anchor_place(one, t, points) - places[i]).norm() < 1e-14);
    CHECK((system::anchor_place(one, t, moved) - motion * places[i]).norm() < 1e-14);
    system::Anchor bare = one;
    bare.offset.setZero();
    CHECK((system::anchor_place(bare, t, points) - nearest[i]).norm() < 1e-14);
  }
  a.gap = 0.01;
  const system::Anchor near = system::make_anchors(a, {0}, places, points, triangles).front();
  CHECK((system::anchor_place(near, triangles[near.triangle], points) - Vec3(0.2, 0.3, 0.01)).norm() < 1e-14);
  const std::vector<system::Anchor> back = system::anchors_of(system::numbers_of(anchors));
  REQUIRE(back.size() == 4);
  CHECK(back[2].attachment == 2);
  CHECK(back[2].vertex == 2);
  CHECK(back[2].triangle == anchors[2].triangle);
  CHECK(back[2].weights == anchors[2].weights);
  CHECK(back[2].offset == anchors[2].offset);
}

TEST_CASE(
    "attachments and bands in a model: the residual is the derivative of the energy, the tangent of the residual") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 5));
  system::ModelInput in = input(block(-height, lifted), {hold(edge, 7.0), hold("right", 5.0)});
  in.attachments[1].number = 1;
  system::Spring band;
  band.kind = system::Spring::Kind::band;
  band.group = "right";
  band.stiffness = 3.0;
  band.length = 0.8;
  in.springs = {band};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const auto vector = [&] { return model.dofs().create_vector(); };
  petsc::VecHandle a = vector(), d = vector();
  std::vector<system::Anchor> anchors;
  model.potential().attachments().attach(a, anchors);
  CHECK(anchors.size() == 12);
  model.set_time(0.05);
  set_displacement(model, a, noise(0.02, 3));
  set_displacement(model, d, noise(1.0, 4));
  check_potential(model, a, d);
}

TEST_CASE("an attachment's energy does not depend on the mesh, and goes by the motion of the obstacle") {
  const Vec3 way(0.3, -0.2, 0.5);
  for (const int cells : {3, 8}) {
    const mesh::SurfaceMesh mesh(square(Pattern::jittered, cells));
    system::Model model(PETSC_COMM_WORLD, mesh, input(block(-height, lifted), {hold(edge, 7.0)}));
    petsc::VecHandle a = model.dofs().create_vector();
    CHECK(system::energies(model, a).springs == 0.0);
    std::vector<system::Anchor> anchors;
    model.potential().attachments().attach(a, anchors);
    CHECK(std::abs(system::energies(model, a).springs) < 1e-25);
    model.set_time(0.02);
    CHECK(system::energies(model, a).springs == relative(0.5 * 7.0 * (0.02 * way).squaredNorm()).epsilon(1e-12));
    // What a restart remembers goes on, from wherever the sheet is then.
    system::Model again(PETSC_COMM_WORLD, mesh, input(block(-height, lifted), {hold(edge, 7.0)}));
    petsc::VecHandle elsewhere = again.dofs().create_vector();
    set_displacement(again, elsewhere, [&](Index) { return Vec3(0.01, 0.0, 0.01); });
    again.set_time(0.02);
    again.potential().attachments().attach(elsewhere, anchors);
    CHECK(system::energies(again, elsewhere).springs ==
          relative(0.5 * 7.0 * (0.02 * way - Vec3(0.01, 0.0, 0.01)).squaredNorm()).epsilon(1e-12));
  }
}

TEST_CASE("a free sheet follows what it is attached to") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 4));
  for (const bool turns : {false, true}) {
    system::ModelInput in = input(block(-height, turns ? turned : lifted), {hold("all", 50.0)});
    in.materials = {isotropic(1e3, 0.3, 0.05, 1.0)};
    mesh::MeshData data = mesh.data();
    mesh::Group all{"all", 2, {}, {}, {}};
    for (Index v = 0; v < mesh.vertex_count(); ++v) all.vertices.push_back(v);
    for (Index t = 0; t < mesh.triangle_count(); ++t) all.triangles.push_back(t);
    data.groups.push_back(all);
    const mesh::SurfaceMesh sheet(std::move(data));
    system::Model model(PETSC_COMM_WORLD, sheet, in);
    petsc::VecHandle a = model.dofs().create_vector();
    std::vector<system::Anchor> anchors;
    model.potential().attachments().attach(a, anchors);
    model.set_time(0.04);
    model.conditions().set_load_factor(1.0);
    solve::Newton newton(model);
    const solve::NewtonResult n = newton.step(a);
    CAPTURE(n.reason);
    REQUIRE(n.converged);
    const std::vector<Vec3> u = per_vertex(model, a);
    double worst = 0.0;
    for (Index v = 0; v < sheet.vertex_count(); ++v) {
      const Vec3& x = sheet.positions()[v];
      const std::vector<Vec3> now = turns ? turned({x}, 0.04) : lifted({x}, 0.04);
      worst = std::max(worst, (x + u[v] - now[0]).norm());
    }
    CHECK(worst < 1e-8);
  }
}

TEST_CASE("a band pulls with its stiffness times its strain, whatever the mesh, and never pushes") {
  for (const int cells : {3, 7})
    for (const double length : {0.8, 1.25}) {
      const mesh::SurfaceMesh mesh(square(Pattern::jittered, cells));
      system::ModelInput in;
      in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
      system::Spring band;
      band.kind = system::Spring::Kind::band;
      band.group = edge;
      band.stiffness = 3.0;
      band.length = length;
      in.springs = {band};
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      petsc::VecHandle a = model.dofs().create_vector();
      const double strain = 1.0 / length - 1.0;
      CHECK(system::energies(model, a).springs ==
            relative(strain > 0.0 ? 0.5 * 3.0 * strain * strain * length : 0.0).scale(1.0).epsilon(1e-12));
    }
}

TEST_CASE("a band that is shorter than its curve gets so in the time of its rise") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 3));
  system::ModelInput in;
  in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
  system::Spring band;
  band.kind = system::Spring::Kind::band;
  band.group = edge;
  band.stiffness = 3.0;
  band.length = 0.8;
  band.rise = 0.5;
  band.start = 2.0;
  in.springs = {band};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  CHECK(model.potential().depends_on_time());
  petsc::VecHandle a = model.dofs().create_vector();
  for (const auto& [time, length] : {std::pair{1.0, 1.0}, {2.0, 1.0}, {2.25, 0.9}, {2.5, 0.8}, {9.0, 0.8}}) {
    model.set_time(time);
    const double strain = 1.0 / length - 1.0;
    CHECK(system::energies(model, a).springs ==
          relative(0.5 * 3.0 * strain * strain * length).scale(1.0).epsilon(1e-12));
  }
}

TEST_CASE("attachments to what is not there are refused") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 3));
  system::Attachment wrong = hold(edge, 1.0);
  wrong.obstacle = "body";
  CHECK_THROWS_AS(system::Model(PETSC_COMM_WORLD, mesh, input(block(-height, lifted), {wrong})), UserError);
  CHECK_THROWS_AS(system::Model(PETSC_COMM_WORLD, mesh, input(block(-height, lifted), {hold("nowhere", 1.0)})),
                  UserError);
  system::ModelInput without;
  without.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
  without.attachments = {hold(edge, 1.0)};
  CHECK_THROWS_AS(system::Model(PETSC_COMM_WORLD, mesh, without), UserError);
}

}  // namespace test_attachments
