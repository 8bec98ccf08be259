// Joints of sheets: constant moments, rigid motions, derivatives, one answer on all ranks.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "energy/joint.hpp"
#include "energy/sheet.hpp"
#include "test_joined_meshes.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_joints {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

energy::Material ply(double along, double across, double angle) {
  energy::Material m;
  m.bending << along, 0.3 * across, 0.0, 0.3 * across, across, 0.0, 0.0, 0.0, 0.5 * across;
  m.bending = energy::rotated_stiffness(m.bending, angle * degree);
  m.membrane = 1e-13 * m.bending;
  m.direction = Vec3::UnitY();  // axis 2 is -x of the sheet, or x where it is turned over
  return m;
}

/// D of the sheet along x and y.
Mat3 along_sheet(const energy::Material& m, bool turned_over) {
  Mat3 d = energy::rotated_stiffness(m.bending, 90.0 * degree);
  if (!turned_over) return d;
  for (int i = 0; i < 2; ++i) d(i, 2) = d(2, i) = -d(i, 2);
  return d;
}

struct Fan {
  std::vector<double> angles;
  std::vector<energy::Material> materials;
  Vec3 bent = Vec3::Zero();  ///< second derivative of the edge
};

/// A state of constant moments: curvatures (xx, yy, 2 xy) along each sheet that balance at the edge, one twist, one turn.
class ConstantMoments {
 public:
  static constexpr int nx = 10, ny = 13;

  ConstantMoments(const Fan& f, const mesh::SurfaceMesh& mesh) : f_(f), mesh_(mesh) {
    constexpr double twist = 0.4;
    double moment = 0.0;
    for (std::size_t k = 0; k < f.angles.size(); ++k) {
      const Index first = mesh.group("sheet " + std::to_string(k)).triangles.front();
      turned_.push_back(mesh.rest_normal(first).dot(normal(k)) < 0.0);
      const Mat3 d = along_sheet(f.materials[k], turned_.back());
      Vec3 c(0.3 + 0.5 * std::sin(3.0 * static_cast<double>(k)), f.bent.dot(normal(k)), 2.0 * twist);
      if (k + 1 == f.angles.size()) c[0] -= (moment + d.row(0).dot(c)) / d(0, 0);
      moment += d.row(0).dot(c);
      curvature_.push_back(c);
      moments_.emplace_back(d * c);
    }
    sheet_.resize(static_cast<std::size_t>(mesh.vertex_count()));
    for (std::size_t k = 0; k < f.angles.size(); ++k)
      for (const Index t : mesh.group("sheet " + std::to_string(k)).triangles) {
        triangles_.emplace_back(t, k);
        for (const Index v : mesh.triangles()[t]) sheet_[static_cast<std::size_t>(v)] = k;
      }
  }
  [[nodiscard]] std::function<Vec3(Index)> displacement(double size) const {
    return [this, size](Index v) -> Vec3 {
      constexpr double turn = 0.7;
      const std::size_t k = sheet_[static_cast<std::size_t>(v)];
      const Vec3 n = normal(k), along(n[2], 0.0, -n[0]);
      const double x = mesh_.positions()[v].dot(along), y = mesh_.positions()[v][1] - 0.5;
      const Vec3& c = curvature_[k];
      return size * (0.5 * c[0] * x * x + 0.5 * c[1] * y * y + 0.5 * c[2] * x * y + turn * x) * n;
    };
  }
  /// Where no operator reaches the rim.
  [[nodiscard]] static bool is_inside(const Vec3& x) {
    return std::hypot(x[0], x[2]) < 1.0 - 4.0 / nx && std::abs(x[1] - 0.5) < 0.5 - 4.0 / ny;
  }
  /// Largest force inside over the largest of all.
  [[nodiscard]] double unbalanced(const std::vector<Vec3>& forces) const {
    double inside = 0.0, all = 0.0;
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      const double size = forces[static_cast<std::size_t>(v)].norm();
      all = std::max(all, size);
      if (is_inside(mesh_.positions()[v])) inside = std::max(inside, size);
    }
    return inside / all;
  }
  /// Largest error of the moments inside, over the largest.
  [[nodiscard]] double error_of(const std::vector<double>& moments) const {
    double wrong = 0.0, most = 0.0;
    for (const auto& entry : triangles_) {
      const Index t = entry.first;
      if (!is_inside((mesh_.start_corner(t, 0) + mesh_.start_corner(t, 1) + mesh_.start_corner(t, 2)) / 3.0)) continue;
      const Vec3& m = moments_[entry.second];  // axis 1 is y; axis 2 is -x, or x where the sheet is turned over
      const double sign = turned_[entry.second] ? -1.0 : 1.0;
      const Vec3 expected(sign * m[1], sign * m[0], -m[2]);
      most = std::max(most, expected.norm());
      wrong = std::max(wrong, (Eigen::Map<const Vec3>(&moments[3 * static_cast<std::size_t>(t)]) - expected).norm());
    }
    return wrong / most;
  }

 private:
  [[nodiscard]] Vec3 normal(std::size_t k) const { return {-std::sin(f_.angles[k]), 0.0, std::cos(f_.angles[k])}; }

  const Fan& f_;
  const mesh::SurfaceMesh& mesh_;
  std::vector<Vec3> curvature_, moments_;
  std::vector<bool> turned_;  ///< whether the sheet is turned over
  std::vector<std::size_t> sheet_;
  std::vector<std::pair<Index, std::size_t>> triangles_;
};

/// Unbalanced forces under constant moments, and the error of the moments that are recovered from small ones.
std::pair<double, double> patch_test(const Fan& f, Pattern pattern) {
  const mesh::SurfaceMesh mesh(fan(f.angles, pattern, ConstantMoments::nx, ConstantMoments::ny));
  system::ModelInput in;
  for (std::size_t k = 0; k < f.angles.size(); ++k) {
    in.materials.push_back(f.materials[k]);
    in.materials[k].groups = {"sheet " + std::to_string(k)};
  }
  const ConstantMoments state(f, mesh);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector(), u = model.dofs().create_vector(),
                   force = model.dofs().create_vector();
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  set_displacement(model, u, state.displacement(1.0));
  VOILE_PETSC(MatMult(model.tangent().matrix(), u, force));
  const double amplitude = 1e-6;
  set_displacement(model, u, state.displacement(amplitude));
  std::vector<double> moments = model.triangle_fields(u).bending_moment;
  mpi::broadcast(PETSC_COMM_WORLD, moments);
  for (double& m : moments) m /= amplitude;
  return {state.unbalanced(per_vertex(model, force)), state.error_of(moments)};
}

energy::Material plain(double stiffness) {
  energy::Material m = isotropic(12.0 * stiffness, 0.3, 1.0);
  m.membrane *= 1e-13;
  m.direction = Vec3::UnitY();
  return m;
}

system::ModelInput input(energy::BendingOperator bending, energy::MembraneOperator membrane) {
  system::ModelInput in;
  in.element.bending = bending;
  in.element.membrane = membrane;
  in.materials = {isotropic(2e6, 0.3, 0.03, 30.0)};
  return in;
}

struct Shape {
  std::string name;
  mesh::MeshData data;
  std::vector<system::Support> supports;
  std::vector<system::Hinge> hinges = {};
};

system::Hinge hinge(double stiffness, const std::string& group = "hinge") {
  system::Hinge c;
  c.group = group;
  c.stiffness = stiffness;
  return c;
}

void fold(system::Hinge& c, double angle) {
  c.angle.value = [=](const Vec3&, double) { return angle; };
  c.constant = true;
}

std::vector<Shape> shapes() {
  return {{"T",
           fan({0.0, 180.0 * degree, 90.0 * degree}, Pattern::jittered, 4, 5),
           {support("ends", system::Support::Kind::clamped)}},
          {"four at odd angles", fan({0.1, 1.9, 3.0, 4.4}, Pattern::union_jack, 3, 4), {}},
          {"acute", fan({0.0, 10.0 * degree, 20.0 * degree}, Pattern::diagonal, 3, 4), {}},
          {"Moebius strip", moebius(14, 3), {}},
          {"corner", cell_corner(3), {}},
          {"corner of single cells", cell_corner(1), {}},
          {"flat hinge", hinged(fan({0.0, 180.0 * degree}, Pattern::jittered, 4, 5)), {}, {hinge(40.0)}},
          {"folded hinge", hinged(fan({0.2, 2.0}, Pattern::union_jack, 4, 4)), {}, {hinge(3.0)}},
          {"elastic edge", fan({0.3}, Pattern::jittered, 5, 5), {}, {hinge(5.0, "end 0")}}};
}

}  // namespace

TEST_CASE("constant moments pass joints of three and four sheets exactly") {
  const std::vector<Fan> fans{
      {{0.0, 180.0 * degree, 90.0 * degree}, {plain(125.0), plain(5.0), plain(1.0)}, Vec3::Zero()},
      {{0.3, 2.2, 4.1}, {ply(10.0, 1.0, 30.0), ply(10.0, 1.0, -45.0), ply(10.0, 1.0, 0.0)}, Vec3::Zero()},
      {{0.0, 90.0 * degree, 180.0 * degree, 270.0 * degree},
       {plain(1.0), plain(5.0), plain(25.0), plain(2.0)},
       Vec3::Zero()},
      {{0.0, 180.0 * degree, 0.0}, {plain(1.0), plain(3.0), ply(10.0, 1.0, 20.0)}, Vec3(0.0, 0.0, 0.6)}};
  for (const Fan& f : fans)
    for (const Pattern p : {Pattern::diagonal, Pattern::union_jack, Pattern::jittered}) {
      CAPTURE(name_of(p));
      CAPTURE(f.angles.size());
      const auto [unbalanced, moments] = patch_test(f, p);
      CHECK(unbalanced < 4e-12);  // round-off: what cancels is 1e4 times the forces
      CHECK(moments < 1e-5);
    }
}

TEST_CASE("joined sheets move as a rigid body without force and energy") {
  for (const Shape& shape : shapes()) {
    if (shape.name == "elastic edge") continue;  // the ground stays
    CAPTURE(shape.name);
    const mesh::SurfaceMesh mesh(shape.data);
    REQUIRE(!mesh.joints().empty());
    system::Model model(PETSC_COMM_WORLD, mesh, [&] {
      system::ModelInput in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
      in.natural.hinges = shape.hinges;
      return in;
    }());
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    set_displacement(model, a, noise(0.01, 3));
    model.residual(a, r);
    const double scale = norm(r), stored = model.energy(a);
    for (const double angle : {0.0, 1.2, 3.1}) {
      const Mat3 turn(Eigen::AngleAxisd(angle, Vec3(0.2, -1.0, 0.4).normalized()));
      set_displacement(model, a, [&](Index v) {
        return Vec3(turn * mesh.positions()[v] - mesh.positions()[v] + Vec3(0.1, 0.2, -0.3));
      });
      model.residual(a, r);
      CHECK(norm(r) < 1e-10 * scale);
      CHECK(std::abs(model.energy(a)) < 1e-12 * stored);
    }
  }
}

TEST_CASE("joints that share a triangle are solved together, and turn freely as one") {
  const mesh::SurfaceMesh mesh(cell_corner(3));
  const mesh::PatchMesh patches(mesh, {});
  const std::vector<energy::Material> materials{isotropic(2e6, 0.3, 0.03)};
  const energy::Sheet sheet(patches, materials, std::vector<int>(static_cast<std::size_t>(mesh.triangle_count()), 0),
                            {});
  energy::CurvatureBuilder curvatures(sheet);
  const std::vector<double> stiff(mesh.joints().size(), std::numeric_limits<double>::infinity());
  std::size_t largest = 0;
  for (const std::vector<Index>& cluster : energy::joint_clusters(sheet)) {
    largest = std::max(largest, cluster.size());
    const energy::JointElement joint =
        energy::make_joint_element(sheet, curvatures, cluster, {stiff, std::vector(stiff.size(), 1.0)});
    const Eigen::MatrixXd& q = joint.stiffness;
    const double scale = q.norm();
    for (const energy::JointElement::Angle& first : joint.angles) {
      Eigen::VectorXd turn(q.rows());
      for (Eigen::Index n = 0; n < q.rows(); ++n)
        turn[n] = joint.angles[static_cast<std::size_t>(n)].edge == first.edge ? 1.0 : 0.0;
      CHECK((q * turn).norm() < 1e-12 * scale);
    }
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(q).eigenvalues();
    CHECK(values.minCoeff() > -1e-12 * scale);
    const auto zero = std::count_if(values.begin(), values.end(), [&](double v) { return v < 1e-9 * scale; });
    CHECK(static_cast<std::size_t>(zero) == cluster.size());
  }
  CHECK(largest == 2);
}

TEST_CASE("forces of joints derive from the energy, and the tangent from the forces") {
  using Bending = energy::BendingOperator;
  using Membrane = energy::MembraneOperator;
  for (const Shape& shape : shapes())
    for (const auto& element : {std::pair(Bending::edge_slope, Membrane::six_node_corrected),
                                std::pair(Bending::edge_angle, Membrane::six_node_corrected),
                                std::pair(Bending::edge_slope, Membrane::six_node)}) {
      CAPTURE(shape.name);
      CAPTURE(static_cast<int>(element.first));
      const mesh::SurfaceMesh mesh(shape.data);
      system::ModelInput in = input(element.first, element.second);
      in.supports = shape.supports;
      in.natural.hinges = shape.hinges;
      for (system::Hinge& c : in.natural.hinges) fold(c, 50.0);
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
      set_displacement(model, a, noise(0.03, 3));
      model.dofs().clear_fixed(a);
      set_displacement(model, d, noise(1.0, 7));
      model.dofs().clear_fixed(d);
      check_potential(model, a, d, 1e-6);
    }
}

TEST_CASE("joined sheets are the same on all ranks as on one") {
  for (const Shape& shape : shapes()) {
    if (shape.data.positions.size() < 20) continue;
    CAPTURE(shape.name);
    const mesh::SurfaceMesh mesh(shape.data);
    const auto answer = [&](MPI_Comm comm) {
      system::ModelInput in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
      in.supports = shape.supports;
      in.natural.hinges = shape.hinges;
      for (system::Hinge& c : in.natural.hinges) fold(c, -20.0);
      system::Model model(comm, mesh, in);
      petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                       r = model.dofs().create_vector();
      set_displacement(model, a, noise(0.02, 3));
      set_displacement(model, d, noise(1.0, 7));
      model.residual(a, r);
      std::vector<Vec3> values = per_vertex(model, r);
      model.assemble_tangent(a, {.kind = energy::Tangent::exact});
      VOILE_PETSC(MatMult(model.tangent().matrix(), d, r));
      for (const Vec3& x : per_vertex(model, r)) values.push_back(x);
      std::vector<double> moments = model.triangle_fields(a).bending_moment;
      mpi::broadcast(comm, moments);
      for (const double m : moments) values.emplace_back(m, 0.0, 0.0);
      values.emplace_back(model.energy(a), 0.0, 0.0);
      return values;
    };
    const std::vector<Vec3> one = answer(PETSC_COMM_SELF), all = answer(PETSC_COMM_WORLD);
    REQUIRE(one.size() == all.size());
    double most = 0.0, wrong = 0.0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      most = std::max(most, one[i].norm());
      wrong = std::max(wrong, (one[i] - all[i]).norm());
    }
    CHECK(wrong < 1e-12 * most);
  }
}

TEST_CASE("a natural curvature bends joined sheets without force") {
  mesh::SurfaceMesh mesh(fan({0.0, 2.0, 4.0}, Pattern::jittered, 6, 6));
  energy::Material m = isotropic(2e6, 0.0, 0.03);
  m.direction = Vec3::UnitY();
  m.expands = true;
  m.layers = {{-0.015, 0.015, m.membrane / 0.03}};
  energy::set_expansion(m, Vec3(0.0, 1e-4, 0.0), {});
  system::ModelInput in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
  in.materials = {m};
  in.natural.by_load = true;
  system::Temperature t;
  const double difference = 3e-5;
  t.difference = {"", [=](const Vec3&, double) { return difference; }, false};
  in.natural.temperatures = {t};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
  model.residual(a, r);
  const double held = norm(r);
  std::vector<std::size_t> of(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (std::size_t k = 0; k < 3; ++k)
    for (const Index triangle : mesh.group("sheet " + std::to_string(k)).triangles)
      for (const Index v : mesh.triangles()[triangle]) of[static_cast<std::size_t>(v)] = k;
  double least = held;
  for (const double curvature : {-1e-7, 1e-7}) {
    set_displacement(model, a, [&](Index v) {
      const std::size_t k = of[static_cast<std::size_t>(v)];
      const double angle = 2.0 * static_cast<double>(k);
      const Vec3 along(std::cos(angle), 0.0, std::sin(angle)), normal(-along[2], 0.0, along[0]);
      const double x = mesh.positions()[v].dot(along), sign = k % 2 == 1 ? -1.0 : 1.0;
      return Vec3(sign * 0.5 * curvature * x * x * normal);
    });
    model.residual(a, r);
    least = std::min(least, norm(r));
  }
  CHECK(least < 1e-4 * held);
}

TEST_CASE("a hinge turns by the moment over its stiffness, inside a sheet and at its held edge") {
  // A cantilever of length 2 and width 1 with the hinge in its middle or at its root, and a force at its tip.
  const mesh::SurfaceMesh mesh(hinged(fan({0.0, 180.0 * degree}, Pattern::union_jack, 6, 6)));
  const double force = 1e-3;
  const auto tip = [&](double stiffness, bool at_root) {
    system::ModelInput in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
    in.materials = {isotropic(2e6, 0.0, 0.03)};
    in.supports = {support("end 0", at_root ? system::Support::Kind::hinged : system::Support::Kind::clamped)};
    in.natural.hinges = {hinge(1e12), hinge(stiffness, "end 0")};
    if (!at_root) in.natural.hinges = {hinge(stiffness)};
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    const auto at_tip = [&](Index v) { return std::abs(mesh.positions()[v][0] + 1.0) < 1e-9; };
    set_displacement(model, r, [&](Index v) {
      const double part = std::abs(mesh.positions()[v][1] - 0.5) > 0.499 ? 0.5 : 1.0;
      return Vec3(0.0, 0.0, at_tip(v) ? part * force / 6.0 : 0.0);
    });
    model.assemble_tangent(a, {.kind = energy::Tangent::exact});
    solve_linear(model, r, a);
    const std::vector<Vec3> moved = per_vertex(model, a);
    double sum = 0.0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
      if (at_tip(v)) sum += moved[static_cast<std::size_t>(v)][2] / 7.0;
    return sum;
  };
  const double whole = tip(1e12, false), stiffness = 2e6 * 0.03 * 0.03 * 0.03 / 12.0;
  CHECK(whole == doctest::Approx(force * 8.0 / 3.0 / stiffness).epsilon(0.01));
  CHECK(tip(1e12, true) == doctest::Approx(whole).epsilon(0.01));
  for (const double k : {0.1, 4.0, 300.0}) {
    CHECK(tip(k, false) - whole == doctest::Approx(force / k).epsilon(1e-3));
    CHECK(tip(k, true) - tip(1e12, true) == doctest::Approx(4.0 * force / k).epsilon(1e-3));
  }
}

TEST_CASE("an elastic edge folds by its angle, towards the normals, without force") {
  const mesh::SurfaceMesh mesh(fan({0.0}, Pattern::jittered, 5, 5));
  for (const double angle : {70.0, -130.0}) {
    CAPTURE(angle);
    system::ModelInput in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
    in.natural.hinges = {hinge(2.0, "end 0")};
    fold(in.natural.hinges.front(), angle);
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    model.residual(a, r);
    const double held = norm(r);
    const double side = mesh.start_normal(0)[2] > 0.0 ? 1.0 : -1.0;  // the sheet lies at x < 1
    const Mat3 turn(Eigen::AngleAxisd(side * angle * degree, Vec3::UnitY()));
    set_displacement(model, a, [&](Index v) {
      const Vec3 x = mesh.positions()[v] - Vec3::UnitX();
      return Vec3(turn * x - x);
    });
    model.residual(a, r);
    CHECK(held > 0.01);
    CHECK(norm(r) < 1e-9 * held);
  }
}

TEST_CASE("a hinge folds by its angle, towards the normals, without force") {
  for (const double rest : {180.0, 70.0})
    for (const double angle : {90.0, -100.0, 20.0}) {
      CAPTURE(rest);
      CAPTURE(angle);
      const mesh::SurfaceMesh mesh(hinged(fan({0.0, rest * degree}, Pattern::jittered, 5, 5)));
      system::ModelInput in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
      in.natural.hinges = {hinge(2.0)};
      fold(in.natural.hinges.front(), angle);
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
      model.residual(a, r);
      const double held = norm(r), stored = model.energy(a);
      CHECK(model.potential().natural_force() > 0.01 * held);
      CHECK(model.potential().natural_force() < 100.0 * held);
      // Sheet 0 lies along x; sheet 1 turns about y towards the side of its normal.
      const double side = mesh.start_normal(mesh.group("sheet 0").triangles.front())[2] > 0.0 ? 1.0 : -1.0;
      const Mat3 turn(Eigen::AngleAxisd(side * angle * degree, Vec3::UnitY()));
      std::vector<char> turned(static_cast<std::size_t>(mesh.vertex_count()), 0);
      for (const Index t : mesh.group("sheet 1").triangles)
        for (const Index v : mesh.triangles()[t]) turned[static_cast<std::size_t>(v)] = 1;
      set_displacement(model, a, [&](Index v) {
        const Vec3& x = mesh.positions()[v];
        return turned[static_cast<std::size_t>(v)] ? Vec3(turn * x - x) : Vec3(Vec3::Zero());
      });
      model.residual(a, r);
      CHECK(norm(r) < 1e-9 * held);
      CHECK(std::abs(model.energy(a)) < 1e-11 * stored);  // round-off of larger parts that cancel
    }
}

TEST_CASE("what joints cannot have is refused by its key") {
  const mesh::SurfaceMesh mesh(fan({0.0, 2.0, 4.0}, Pattern::diagonal, 3, 3));
  const auto refused = [&](const system::ModelInput& in, const std::string& text) {
    try {
      system::Model model(PETSC_COMM_WORLD, mesh, in);
    } catch (const UserError& e) {
      return std::string(e.what()).find(text) != std::string::npos;
    }
    return false;
  };
  system::ModelInput in = input(energy::BendingOperator::six_node, energy::MembraneOperator::cst);
  CHECK(refused(in, "[element] type = \"zhou_sze_2012\""));
  in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node);
  in.materials[0].coupling = Mat3::Identity();
  CHECK(refused(in, "unsymmetric"));
  in = input(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected);
  in.natural.hinges = {hinge(1.0)};
  in.natural.hinges = {hinge(1.0, "end 0")};
  in.supports = {support("end 0", system::Support::Kind::clamped)};
  CHECK(refused(in, "holds the slope"));
  in.supports.clear();
  const mesh::SurfaceMesh folded(hinged(fan({0.0, 2.0}, Pattern::diagonal, 3, 3)));
  in.natural.hinges = {hinge(1.0), hinge(2.0)};
  try {
    system::Model model(PETSC_COMM_WORLD, folded, in);
    FAIL("two hinges on one edge");
  } catch (const UserError& e) {
    CHECK(std::string(e.what()).find("another hinge") != std::string::npos);
  }
}

}  // namespace test_joints
