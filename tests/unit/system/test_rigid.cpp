// Rigid groups: their kinematics, derivatives, rigid motions, one answer on all ranks, mistakes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "system/constraints.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_rigid {

using namespace voile;
using namespace voile::testing;
using system::RigidGroup;

namespace {

using Motion = system::RigidMotion;

/// Where a stage finds a body.
system::RigidPlace turned_place() {
  const Vec3 p = Vec3(0.3, -0.5, 0.4);
  system::RigidPlace place;
  place.displacement = Vec3(0.2, 0.1, -0.3);
  place.turn << std::sqrt(1.0 - p.squaredNorm()), p;
  return place;
}

system::RigidBody turned_body() {
  system::RigidBody body;
  body.place = turned_place();
  body.basis = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  body.length = 0.8;
  body.stiffness = 3.0;
  return body;
}

/// Unknowns of a body as a function of seven numbers.
Motion at(const Motion::Row& b) {
  Motion m(turned_body());
  m.set(b.head<3>(), b.segment<3>(3), Vec3(b[6], 0.0, 0.0));
  return m;
}

mesh::MeshData sheet_of(bool curved) {
  return mapped(square(Pattern::jittered, 6), [&](const Vec3& x) {
    return Vec3(x[0], x[1], curved ? 0.25 * std::sin(2.0 * x[0]) + 0.15 * x[1] * x[1] : 0.0);
  });
}

/// A sheet that is held on the left and ends in a rigid group on the right.
system::ModelInput input(energy::BendingOperator bending = energy::BendingOperator::edge_slope) {
  system::ModelInput in;
  in.element.bending = bending;
  in.materials = {isotropic(100.0, 0.3, 0.2, 1.0)};
  in.supports = {support("left", system::Support::Kind::clamped)};
  RigidGroup g;
  g.group = "right";
  g.point = Vec3(1.2, 0.4, 0.1);
  g.force = Vec3(0.2, -0.3, 0.5);
  in.rigid = {g};
  return in;
}

system::Load gravity() {
  return load(system::Load::Kind::gravity, "", Vec3(0.3, -0.1, -1.0));
}

/// Unknowns of the bodies, large.
std::vector<double> unknowns(double size = 1.0) {
  std::vector<double> b;
  for (const double x : {0.1, -0.2, 0.15, 0.3, -0.2, 0.25, -0.1, 0.0, 0.0}) b.push_back(size * x);
  return b;
}

void set_state(const system::Model& model, Vec a, double noise_size, double body_size, unsigned seed = 3) {
  set_displacement(model, a, noise(noise_size, seed));
  model.dofs().scatter_bodies(unknowns(body_size), a);
  model.dofs().clear_fixed(a);
}

}  // namespace

TEST_CASE("rotation, spin and second derivatives of a rigid body by differences") {
  Motion::Row b;
  b << 0.1, 0.2, -0.3, 0.4, -0.5, 0.2, -0.3;
  constexpr double h = 1e-5;
  const Motion m = at(b);
  const Mat3 r = m.turned() + Mat3::Identity();
  CHECK((r * r.transpose() - Mat3::Identity()).norm() < 1e-14);
  CHECK(
      (r - Eigen::AngleAxisd(m.rotation_vector().norm(), m.rotation_vector().normalized()).toRotationMatrix()).norm() <
      1e-14);
  const Vec3 moment(0.3, -0.7, 0.4);
  for (int i = 0; i < Motion::turns; ++i) {
    Motion::Row up = b, down = b;
    up[3 + i] += h;
    down[3 + i] -= h;
    const Motion more = at(up), less = at(down);
    const Mat3 change = (more.turned() - less.turned()) / (2.0 * h);
    CHECK((change - m.slope(i)).norm() < 1e-8);
    const Mat3 spin = change * r.transpose();
    CHECK((Vec3(spin(2, 1), spin(0, 2), spin(1, 0)) - m.spin().col(i)).norm() < 1e-8);
    for (int j = 0; j < Motion::turns; ++j)
      CHECK(((more.slope(j) - less.slope(j)) / (2.0 * h) - m.curvature(i, j)).norm() < 1e-8);
    const Eigen::Vector4d force = (more.spin() - less.spin()).transpose() * moment / (2.0 * h);
    CHECK((force - m.moment_slope(moment).col(i)).norm() < 1e-8);
    CHECK((more.length_energy() - less.length_energy()) / (2.0 * h) == doctest::Approx(m.length_force()[i]));
    CHECK(((more.length_force() - less.length_force()) / (2.0 * h) - m.length_tangent().col(i)).norm() < 1e-8);
  }
}

TEST_CASE("a rotation about an axis is written as unknowns and read back, from where the body is") {
  const Vec3 p = turned_place().turn.tail<3>();
  const Mat3 first = Eigen::AngleAxisd(2.0 * std::asin(p.norm()), p.normalized()).toRotationMatrix();
  for (const double angle : {0.0, 0.3, 2.0, 5.0}) {
    Motion m(turned_body());
    const Vec3 axis = Vec3(0.2, -1.0, 0.4).normalized();
    const auto b = m.unknowns_of(axis, angle);
    m.set(Vec3(1.0, 2.0, 3.0), b[0], b[1]);
    CHECK((m.turn_in_stage() - angle * axis).norm() < 1e-14);
    CHECK((m.turned() + Mat3::Identity() - Eigen::AngleAxisd(angle, axis).toRotationMatrix() * first).norm() < 1e-14);
    CHECK((m.displacement() - turned_place().displacement - Vec3(1.0, 2.0, 3.0)).norm() < 1e-15);
  }
}

TEST_CASE("forces of inertia of a body are those of Lagrange's equations") {
  system::BodyMass mass;
  mass.add(0.4, Vec3(0.1, 0.2, 0.3));
  mass.add(0.7, Vec3(-0.2, 0.5, -0.1));
  mass.add(0.3, Vec3(0.4, -0.3, 0.2));
  Motion::Row b, v;
  b << 0.1, 0.2, -0.3, 0.4, -0.5, 0.2, -0.3;
  v << 0.3, -0.1, 0.2, 0.5, 0.4, -0.3, 0.2;
  constexpr double h = 1e-5;
  // d/dt (M v) - dT/db at constant rates
  Motion::Row expected = (at(b + h * v).mass(mass) - at(b - h * v).mass(mass)) * v / (2.0 * h);
  for (int i = 0; i < expected.size(); ++i) {
    Motion::Row up = b, down = b;
    up[i] += h;
    down[i] -= h;
    expected[i] -= 0.5 * v.dot((at(up).mass(mass) - at(down).mass(mass)) * v) / (2.0 * h);
  }
  CHECK((at(b).gyration(mass, v) - expected).norm() < 1e-8);
}

TEST_CASE("forces of sheets with rigid groups derive from the energy, and the tangent from the forces") {
  for (const bool curved : {false, true}) {
    const mesh::SurfaceMesh mesh(sheet_of(curved));
    for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle})
      for (const bool slope : {false, true}) {
        CAPTURE(curved);
        CAPTURE(static_cast<int>(bending));
        CAPTURE(slope);
        system::ModelInput in = input(bending);
        in.loads = {gravity()};
        in.rigid[0].slope = slope;
        if (!slope && !curved) {  // nothing resists a turn about the edge
          in.rigid[0].turn = RigidGroup::Turn::about;
          in.rigid[0].axis = Vec3(0.3, 0.1, 1.0);
        }
        system::Model model(PETSC_COMM_WORLD, mesh, in);
        model.conditions().set_load_factor(0.7);
        petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
        set_state(model, a, 0.03, 1.0);
        set_state(model, d, 1.0, 3.0, 7);
        check_potential(model, a, d, 1e-6);
      }
  }
}

TEST_CASE("a moment about the axis of a body has a potential, any other one an exact tangent") {
  const mesh::SurfaceMesh mesh(sheet_of(true));
  for (const bool about : {true, false}) {
    CAPTURE(about);
    system::ModelInput in = input();
    in.rigid[0].moment = Vec3(0.0, 0.8, 0.0);
    if (about) {
      in.rigid[0].turn = RigidGroup::Turn::about;
      in.rigid[0].axis = Vec3(0.0, 2.0, 0.0);
    }
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    model.conditions().set_load_factor(0.7);
    petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
    set_state(model, a, 0.03, 1.0);
    set_state(model, d, 1.0, 3.0, 7);
    CHECK(model.conditions().symmetric() == about);
    if (about) {
      check_potential(model, a, d, 1e-6);
      continue;
    }
    constexpr double h = 1e-6;
    petsc::VecHandle kd = model.dofs().create_vector(), up = model.dofs().create_vector(),
                     down = model.dofs().create_vector(), moved = model.dofs().create_vector();
    model.assemble_tangent(a, {.kind = energy::Tangent::exact});
    VOILE_PETSC(MatMult(model.tangent().matrix(), d, kd));
    VOILE_PETSC(VecWAXPY(moved, h, d, a));
    model.residual(moved, up);
    VOILE_PETSC(VecWAXPY(moved, -h, d, a));
    model.residual(moved, down);
    VOILE_PETSC(VecAXPY(up, -1.0, down));
    VOILE_PETSC(VecScale(up, 0.5 / h));
    VOILE_PETSC(VecAXPY(up, -1.0, kd));
    CHECK(norm(up) < 1e-6 * norm(kd));
  }
}

TEST_CASE("a rigid motion of all leaves no force") {
  const Vec3 axis = Vec3(0.3, 1.0, -0.2).normalized(), shift(0.4, -0.3, 0.2);
  for (const bool curved : {false, true})
    for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle}) {
      const mesh::SurfaceMesh mesh(sheet_of(curved));
      system::ModelInput in = input(bending);
      in.supports.clear();
      in.rigid[0].force.setZero();
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      const Mat3 r = Eigen::AngleAxisd(2.5, axis).toRotationMatrix();
      const Vec3 point = *in.rigid[0].point;
      petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
      set_displacement(model, a,
                       [&](Index v) { return Vec3(shift + (r - Mat3::Identity()) * (mesh.positions()[v] - point)); });
      const auto b = Motion(model.discretisation().constraints().bodies[0]).unknowns_of(axis, 2.5);
      std::vector<double> body(shift.begin(), shift.end());
      for (const Vec3& part : b) body.insert(body.end(), part.begin(), part.end());
      model.dofs().scatter_bodies(body, a);
      model.unbalanced_force(a, f);
      CHECK(norm(f) < 1e-12 * 20.0);  // of the membrane stiffness [N]
      CHECK(std::abs(model.energy(a)) < 1e-12);
      std::vector<Vec3> u = per_vertex(model, a);
      double wrong = 0.0;
      for (Index v = 0; v < mesh.vertex_count(); ++v)
        wrong = std::max(wrong, (u[v] - shift - (r - Mat3::Identity()) * (mesh.positions()[v] - point)).norm());
      CHECK(wrong < 1e-14);
    }
}

TEST_CASE("without a point a rigid group is held at its centre, however its vertices lie") {
  // Rows of cells get closer towards y = 0.
  const mesh::SurfaceMesh mesh(
      mapped(square(Pattern::diagonal, 6), [](const Vec3& x) { return Vec3(x[0], x[1] * x[1], 0.0); }));
  system::ModelInput in = input();
  in.rigid[0].point.reset();
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  CHECK((model.discretisation().constraints().bodies[0].point - Vec3(1.0, 0.5, 0.0)).norm() < 1e-14);
}

TEST_CASE("sheets with rigid groups are the same on all ranks as on one") {
  const mesh::SurfaceMesh mesh(sheet_of(true));
  const auto answer = [&](MPI_Comm comm) {
    system::ModelInput in = input();
    in.loads = {gravity(), load(system::Load::Kind::line, "right", Vec3(0.1, 0.2, 0.3))};
    in.loads.emplace_back();
    in.loads.back().kind = system::Load::Kind::follower_pressure;
    in.loads.back().magnitude = 0.4;
    in.rigid[0].moment = Vec3(0.1, 0.8, -0.3);
    system::Model model(comm, mesh, in);
    model.conditions().set_load_factor(0.7);
    petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                     r = model.dofs().create_vector();
    set_state(model, a, 0.02, 1.0);
    set_state(model, d, 1.0, 3.0, 7);
    std::vector<double> all;
    const auto take = [&](Vec v) {
      for (std::vector<double> part : {model.dofs().gather_forces(v), model.dofs().gather_bodies(v)}) {
        mpi::broadcast(comm, part);
        all.insert(all.end(), part.begin(), part.end());
      }
    };
    model.residual(a, r);
    take(r);
    model.assemble_tangent(a, {.kind = energy::Tangent::exact});
    VOILE_PETSC(MatMult(model.tangent().matrix(), d, r));
    take(r);
    const system::BlockMatrix mass = model.potential().constant().consistent_mass();
    VOILE_PETSC(MatMult(mass.mat(), d, r));
    take(r);
    std::vector<double> moments = model.triangle_fields(a).bending_moment;
    mpi::broadcast(comm, moments);
    all.insert(all.end(), moments.begin(), moments.end());
    all.push_back(model.energy(a));
    return all;
  };
  check_ranks_agree(answer);
}

TEST_CASE("the mass of a rigid group is that of its vertices, wherever it has turned to") {
  const mesh::SurfaceMesh mesh(sheet_of(true));
  system::ModelInput in = input();
  in.masses = {{"right", 0.3}};
  in.rigid[0].mass = 0.2;
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector(), v = model.dofs().create_vector(),
                   mv = model.dofs().create_vector();
  set_state(model, a, 0.02, 1.0);
  set_state(model, v, 1.0, 3.0, 7);
  std::vector<Vec3> u(static_cast<std::size_t>(model.dofs().local().count())), x = u;
  model.dofs().update_points(a, u, x);
  std::vector<double> velocity = model.dofs().gather_change(v);
  mpi::broadcast(PETSC_COMM_WORLD, velocity);
  const auto of = [&](Index i) { return Vec3(Eigen::Map<const Vec3>(velocity.data() + 3 * i)); };
  double twice = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (const Index i : mesh.triangles()[t])
      for (const Index j : mesh.triangles()[t]) twice += mesh.area(t) / 12.0 * (i == j ? 2.0 : 1.0) * of(i).dot(of(j));
  for (const Index i : mesh.group("right").vertices) twice += 0.3 * of(i).squaredNorm();
  const std::vector<Motion::Row> rows = model.dofs().body_rows(v);
  twice += 0.2 * rows[0].head<3>().squaredNorm();
  const system::BlockMatrix mass = model.potential().constant().consistent_mass();
  VOILE_PETSC(MatMult(mass.mat(), v, mv));
  CHECK(dot(mv, v) == relative(twice).epsilon(1e-12));
}

TEST_CASE("what no rigid group can be is refused by name") {
  const mesh::SurfaceMesh mesh(sheet_of(false));
  const auto refused = [&](const system::ModelInput& in, const std::string& text) {
    CAPTURE(text);
    std::string message;
    try {
      system::Model model(PETSC_COMM_WORLD, mesh, in);
    } catch (const UserError& e) {
      message = e.what();
    }
    CAPTURE(message);
    CHECK(message.find("[[rigid]] group") != std::string::npos);
    CHECK(message.find(text) != std::string::npos);
  };
  system::ModelInput in = input();
  in.rigid[0].group = "nowhere";
  refused(in, "there is no physical group 'nowhere'");
  in = input();
  in.supports.push_back(support("top", system::Support::Kind::hinged));
  refused(in, "is held by a [[support]] too");
  in = input();
  in.rigid[0].slope = false;
  refused(in, "lie on a line");
  in = input();
  in.supports.clear();
  in.rigid.push_back(in.rigid[0]);
  in.rigid[1].group = "top";
  refused(in, "both have vertex");
}

}  // namespace test_rigid
