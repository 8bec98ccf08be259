// Rubber: laws against closed forms, derivatives, small strains, kernels, ranks, natural states.
#include "energy/hyperelastic.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "../test_model_kit.hpp"
#include "energy/biot_force.hpp"
#include "energy/layer_stress.hpp"
#include "energy/membrane.hpp"

namespace test_hyperelastic {

using namespace voile;
using namespace voile::testing;

namespace {

using energy::Hyperelastic;
using energy::MembraneOperator;
using Kind = system::Support::Kind;

constexpr double shear = 3.0;  ///< of all laws at zero strain [N/m]
constexpr double thickness = 0.01;

/// Of the same shear modulus: neo-Hooke, Mooney-Rivlin, Ogden's of Treloar's rubber, Ogden with the powers of Mooney-Rivlin nearby.
std::vector<Hyperelastic> laws() {
  std::vector<Hyperelastic> all(4);
  all[0].c10 = 0.5 * shear;
  all[1].c10 = 0.4 * shear;
  all[1].c01 = 0.1 * shear;
  all[2].terms = {{6.3, 1.3}, {0.012, 5.0}, {-0.1, -2.0}};
  all[2].scale(shear / all[2].shear_modulus());
  all[3].c10 = 0.3 * shear;
  all[3].terms = {{0.3 * shear, 3.0}, {-0.1 * shear, 1.0}};
  return all;
}

energy::Material rubber(const Hyperelastic& law) {
  energy::Material m = isotropic(3.0 * law.shear_modulus() / thickness, 0.5, thickness, 1.0);
  m.rubber = law;
  m.layers = {{-0.5 * thickness, 0.5 * thickness, m.membrane / thickness}};
  return m;
}

/// Principal forces F S, of stretches a and b: dw/da and dw/db by the text-book formula.
Vec2 nominal_forces(const Hyperelastic& law, double a, double b) {
  const double c = 1.0 / (a * b);
  Vec2 f = Vec2::Zero();
  const auto add = [&](double modulus, double alpha) {
    f += modulus * Vec2((std::pow(a, alpha) - std::pow(c, alpha)) / a, (std::pow(b, alpha) - std::pow(c, alpha)) / b);
  };
  add(2.0 * law.c10, 2.0);
  add(-2.0 * law.c01, -2.0);
  for (const Hyperelastic::Term& t : law.terms) add(t.modulus, t.exponent);
  return f;
}

Vec3 strain_of(const Mat2& f) {
  const Mat2 c = f.transpose() * f;
  return {0.5 * (c(0, 0) - 1.0), 0.5 * (c(1, 1) - 1.0), c(0, 1)};
}

/// A flat patch, all of it stretched alike.
struct Patch {
  mesh::SurfaceMesh mesh{square(Pattern::jittered, 3)};
  mesh::PatchMesh patches{mesh, {}};
  std::vector<energy::Material> materials;
  energy::Sheet sheet;
  energy::MembraneTerm term;
  std::vector<Vec3> x, u;

  Patch(const energy::Material& m, MembraneOperator kind)
      : materials{m},
        sheet(patches, materials, energy::assign_materials(mesh, materials), options(kind)),
        term(sheet),
        x(mesh.positions()),
        u(x.size(), Vec3::Zero()) {
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      term.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), true);
  }
  static energy::ElementOptions options(MembraneOperator kind) {
    energy::ElementOptions o;
    o.membrane = kind;
    return o;
  }
  energy::Configuration at(const Mat2& f) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      const Vec3& p = mesh.positions()[v];
      x[v].head<2>() = f * p.head<2>();
      u[v] = x[v] - p;
    }
    return {x.data(), u.data()};
  }
  /// Derivative of the energy by F, per area.
  Mat2 nominal(const Mat2& f, double& energy) {
    std::vector<Vec3> g(x.size(), Vec3::Zero());
    energy = term.add_gradients(at(f), g.data());
    Mat2 sum = Mat2::Zero();
    for (std::size_t v = 0; v < x.size(); ++v) sum += g[v].head<2>() * mesh.positions()[v].head<2>().transpose();
    return sum;
  }
};

Mat2 turned(double angle) {
  Mat2 r;
  r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

}  // namespace

TEST_CASE("hyperelastic sheets pulled in one, in both, and in one direction with the other held") {
  for (const Hyperelastic& law : laws())
    for (const MembraneOperator kind : {MembraneOperator::cst, MembraneOperator::six_node}) {
      Patch patch(rubber(law), kind);
      const double area = 1.0;
      for (const double l : {0.6, 0.999999, 1.0 + 1e-7, 1.2, 2.0, 3.0, 6.0})
        for (const double power : {-0.5, 0.0, 1.0}) {
          const double across = std::pow(l, power);
          const Mat2 r = turned(0.3), q = turned(1.1);
          const Mat2 f = r * Vec2(l, across).asDiagonal() * q.transpose();
          double energy = 0.0;
          const Mat2 force = r.transpose() * patch.nominal(f, energy) * q / area;
          const Vec2 exact = nominal_forces(law, l, across);
          CAPTURE(l);
          CAPTURE(power);
          const double scale = std::max(shear, exact.norm());
          CHECK(std::abs(force(0, 0) - exact[0]) < 1e-10 * scale);
          CHECK(std::abs(force(1, 1) - exact[1]) < 1e-10 * scale);
          CHECK(std::abs(force(0, 1)) + std::abs(force(1, 0)) < 1e-10 * scale);
          const energy::HyperelasticResponse w = energy::response(law, strain_of(f));
          if (std::abs(l - 1.0) > 0.01) CHECK(energy == relative(w.energy * area).epsilon(1e-11));
        }
    }
}

TEST_CASE("energy of a hyperelastic sheet at small strains keeps its figures") {
  for (const Hyperelastic& law : laws()) {
    Patch patch(rubber(law), MembraneOperator::six_node);
    const Mat2 f = Vec2(1.0 + 2e-6, 1.0 - 1e-6).asDiagonal();
    const Vec3 strain = strain_of(f);
    double energy = 0.0;
    (void)patch.nominal(f, energy);
    CHECK(energy == relative(0.5 * strain.dot(patch.materials[0].membrane * strain)).epsilon(1e-5));
  }
}

TEST_CASE("the law of a hyperelastic sheet has the derivatives of its energy") {
  for (Hyperelastic law : laws()) {
    law.natural = energy::turned_strain(0.2) * 0.9;
    law.area = 1.1;
    for (const Vec3& strain :
         {Vec3(0.4, 0.1, 0.3), Vec3(4.0, 0.2, -0.5), Vec3(-0.1, -0.2, 0.05), Vec3(2.0, 2.0, 0.0)}) {
      const energy::HyperelasticResponse at = energy::response(law, strain);
      for (int k = 0; k < 3; ++k) {
        const Vec3 step = 1e-6 * Vec3::Unit(k);
        const energy::HyperelasticResponse up = energy::response(law, strain + step),
                                           down = energy::response(law, strain - step);
        CHECK((up.energy - down.energy) / 2e-6 == doctest::Approx(at.force[k]).epsilon(1e-6));
        CHECK(((up.force - down.force) / 2e-6 - at.tangent.col(k)).norm() < 1e-6 * at.tangent.norm());
      }
    }
    law.natural = Mat3::Identity();
    law.area = 1.0;
    const energy::HyperelasticResponse rest = energy::response(law, Vec3::Zero());
    CHECK((rest.tangent - energy::isotropic_membrane(3.0 * shear, 0.5, 1.0)).norm() < 1e-11 * rest.tangent.norm());
  }
}

TEST_CASE("hyperelastic membranes are the gradient of their energy, with its tangent") {
  for (const Hyperelastic& law : laws())
    for (const MembraneOperator kind :
         {MembraneOperator::cst, MembraneOperator::six_node, MembraneOperator::six_node_corrected})
      for (const double viscosity : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(viscosity);
        const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 4), [&](const Vec3& x) {
          return Vec3(x[0], x[1], 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1]);
        }));
        system::ModelInput in;
        in.materials = {rubber(law)};
        in.element.membrane = kind;
        in.supports = {support("left", Kind::clamped)};
        system::Model model(PETSC_COMM_WORLD, mesh, in);
        const petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
        set_displacement(model, d, noise(1.0, 5));
        model.dofs().clear_fixed(d);
        model.potential().start_step(a, viscosity);
        for (const double stretch : {0.0, 0.8}) {
          set_displacement(model, a, [&](Index v) {
            const Vec3& x = mesh.positions()[v];
            return Vec3(noise(0.02, 11)(v) + stretch * Vec3(x[0], 0.6 * x[1], x[2]));
          });
          model.dofs().clear_fixed(a);
          check_potential(model, a, d, 1e-6);
        }
      }
}

TEST_CASE("hyperelastic stiffness without its negative part is not below the exact one") {
  Hyperelastic law;  // Its tangent in the strain is indefinite where it is stretched.
  law.c10 = 0.1 * shear;
  law.c01 = 0.4 * shear;
  Patch patch(rubber(law), MembraneOperator::six_node);
  energy::Configuration c = patch.at(Vec2(1.8, 1.1).asDiagonal());
  const auto stiffness = [&](energy::Tangent kind) {
    c.tangent = kind;
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(18, 18);
    patch.term.hessian(0, c, [&](int i, int j, const Mat3& block) { k.block<3, 3>(3 * i, 3 * j) += block; });
    return k;
  };
  const Eigen::MatrixXd exact = stiffness(energy::Tangent::exact), positive = stiffness(energy::Tangent::positive);
  const auto least = [](const Eigen::MatrixXd& k) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues()[0];
  };
  CHECK(least(exact) < -1e-3 * exact.norm());
  CHECK(least(positive) > -1e-12 * exact.norm());
  CHECK(least(positive - exact) > -1e-12 * exact.norm());
}

TEST_CASE("the linearised stress of rubber is that of its tangent") {
  for (const Hyperelastic& law : laws()) {
    energy::Material plain = rubber(law);
    plain.rubber = {};
    Patch patch(rubber(law), MembraneOperator::six_node), flat(plain, MembraneOperator::six_node);
    const auto stiffness = [](Patch& p, const Mat2& f, const std::vector<Vec3>& previous, energy::Tangent kind) {
      energy::Configuration c = p.at(f);
      c.previous = previous.data();
      c.tangent = kind;
      Eigen::MatrixXd k = Eigen::MatrixXd::Zero(18, 18);
      p.term.hessian(0, c, [&](int i, int j, const Mat3& block) { k.block<3, 3>(3 * i, 3 * j) += block; });
      return k;
    };
    const Mat2 rest = Mat2::Identity(), pulled = Vec2(1.8, 0.9).asDiagonal();
    (void)patch.at(pulled);
    const std::vector<Vec3> far = patch.x;
    // At rest the tangent is the isotropic one, from wherever the iteration comes.
    const Eigen::MatrixXd there = stiffness(patch, rest, far, energy::Tangent::linearised_stress),
                          exact = stiffness(patch, rest, far, energy::Tangent::exact);
    CHECK((there - stiffness(flat, rest, far, energy::Tangent::linearised_stress)).norm() < 1e-11 * there.norm());
    CHECK((there - exact).norm() > 0.1 * exact.norm());
    const Eigen::MatrixXd settled = stiffness(patch, pulled, far, energy::Tangent::linearised_stress);
    CHECK((settled - stiffness(patch, pulled, far, energy::Tangent::exact)).norm() < 1e-12 * settled.norm());
  }
}

TEST_CASE("at small strains rubber is an isotropic sheet with nu = 1/2") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 4));
  for (const Hyperelastic& law : laws()) {
    system::ModelInput in;
    in.materials = {rubber(law)};
    in.supports = {support("left", Kind::clamped)};
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    in.materials[0].rubber = {};
    system::Model plain(PETSC_COMM_WORLD, mesh, in);
    const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                           g = model.dofs().create_vector();
    set_displacement(model, a, noise(1e-7, 3));
    model.residual(a, f);
    plain.residual(a, g);
    CHECK(relative_difference(per_vertex(model, f), per_vertex(plain, g)) < 1e-5);
  }
}

TEST_CASE("rubber beside yarns and plates in one batch: every triangle answers as in a sheet of its own material") {
  energy::Material woven = isotropic(100.0, 0.2, 0.1);
  woven.yarns.knots[0] = {{0.001, 300.0}};
  woven.yarns.stiffness = 8.0;
  woven.yarns.limit = 0.02;
  std::vector<energy::Material> all{rubber(laws()[2]), woven, isotropic(50.0, 0.3, 0.1), rubber(laws()[1])};
  for (energy::Material& m : all) m.direction = Vec3::UnitX();
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 4));
  const mesh::PatchMesh patches(mesh, {});
  std::vector<int> of(static_cast<std::size_t>(mesh.triangle_count()));
  for (std::size_t t = 0; t < of.size(); ++t) of[t] = static_cast<int>(t % all.size());
  std::vector<Vec3> x, u;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    u.push_back(noise(0.04, 3)(v) + 0.3 * mesh.positions()[v]);
    x.push_back(mesh.positions()[v] + u.back());
  }
  const energy::Configuration c{x.data(), u.data()};
  // The published element, which averages across borders of materials too.
  energy::ElementOptions published = Patch::options(MembraneOperator::six_node);
  published.bending = energy::BendingOperator::six_node;
  const auto term_of = [&](const std::vector<int>& material_of) {
    const energy::Sheet sheet(patches, all, material_of, published);
    energy::MembraneTerm term(sheet);
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      term.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), true);
    return term;
  };
  const energy::MembraneTerm mixed = term_of(of);
  std::vector<Vec3> force(x.size(), Vec3::Zero()), sum = force;
  double energy = 0.0;
  const double whole = mixed.add_gradients(c, force.data());
  for (std::size_t m = 0; m < all.size(); ++m) {
    const energy::MembraneTerm own = term_of(std::vector<int>(of.size(), static_cast<int>(m)));
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      if (of[static_cast<std::size_t>(t)] != static_cast<int>(m)) continue;
      CHECK(mixed.energy(t, c) == relative(own.energy(t, c)).epsilon(1e-12));
      energy += own.energy(t, c);
      own.gradient(t, c, [&](int i, const Vec3& g) { sum[static_cast<std::size_t>(own.stencil(t)[i])] += g; });
    }
  }
  CHECK(whole == relative(energy).epsilon(1e-12));
  CHECK(relative_difference(force, sum) < 1e-12);
}

TEST_CASE("rubber is the same on any number of ranks") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 7));
  system::ModelInput in;
  in.materials = {rubber(laws()[2])};
  in.supports = {support("left", Kind::clamped)};
  system::Model model(PETSC_COMM_WORLD, mesh, in), alone(PETSC_COMM_SELF, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                         b = alone.dofs().create_vector(), g = alone.dofs().create_vector();
  const auto at = [&](Index v) { return Vec3(mesh.positions()[v] + noise(0.03, 8)(v)); };
  set_displacement(model, a, at);
  set_displacement(alone, b, at);
  CHECK(system::energies(model, a).membrane == relative(system::energies(alone, b).membrane).epsilon(1e-11));
  model.residual(a, f);
  alone.residual(b, g);
  CHECK(relative_difference(per_vertex(model, f), per_vertex(alone, g)) < 1e-11);
}

TEST_CASE("an initial strain is where rubber is without force, and its law holds from there") {
  energy::Material m = rubber(laws()[1]);
  m.initial_strain = Vec3(-0.2, 0.1, 0.05);
  m.direction = Vec3::UnitX();
  const energy::Material seen = energy::in_natural_frame(m);
  Mat2 stretch;
  stretch << 0.8, 0.025, 0.025, 1.1;
  const Mat2 f = turned(0.4) * Vec2(1.5, 0.9).asDiagonal() * turned(0.7);
  // From the natural state: F = F_n U, E - E_natural.
  const Vec3 elastic = strain_of(f * stretch) - strain_of(stretch);
  const energy::HyperelasticResponse here = energy::response(seen.rubber, elastic),
                                     own = energy::response(m.rubber, strain_of(f));
  CHECK(here.energy == relative(stretch.determinant() * own.energy).epsilon(1e-12));
  CHECK(energy::thinning(seen.rubber, elastic) == relative(1.0 / f.determinant()).epsilon(1e-12));
}

TEST_CASE("true stress of a hyperelastic sheet") {
  const Hyperelastic law = laws()[2];
  const energy::Material m = rubber(law);
  const Mat2 q = turned(0.35), f = q * Vec2(2.0, 1.3).asDiagonal() * q.transpose();
  const Vec2 nominal = nominal_forces(law, 2.0, 1.3);
  const Vec3 force = energy::true_force(law, strain_of(f));
  Mat2 tensor;
  tensor << force[0], force[2], force[2], force[1];
  CHECK((q.transpose() * tensor * q - Mat2(Vec2(2.0 * nominal[0], 1.3 * nominal[1]).asDiagonal())).norm() < 1e-11);
  const energy::SheetState state{strain_of(f), Vec3(1.0, 0.0, 0.0)};
  const Vec3 top = energy::layer_stress(m, m.layers[0], 0.5 * thickness, state);
  CHECK((top - (force / thickness - 0.5 * thickness * m.layers[0].stiffness.col(0))).norm() < 1e-9 * top.norm());
}

TEST_CASE("forces of a hyperelastic sheet on stretches, and their tangent") {
  for (const Hyperelastic& law : laws()) {
    const Mat2 q = turned(0.35);
    const auto at = [&](double a, double b) { return nominal_forces(law, a, b); };
    const Vec2 force = at(2.0, 1.3);
    Mat2 slope;
    slope.col(0) = (at(2.0 + 1e-6, 1.3) - at(2.0 - 1e-6, 1.3)) / 2e-6;
    slope.col(1) = (at(2.0, 1.3 + 1e-6) - at(2.0, 1.3 - 1e-6)) / 2e-6;
    const energy::BiotForce b = energy::biot_force(law, strain_of(q * Vec2(2.0, 1.3).asDiagonal() * q.transpose()));
    Mat2 tensor;
    tensor << b.force[0], b.force[2], b.force[2], b.force[1];
    CHECK((q.transpose() * tensor * q - Mat2(force.asDiagonal())).norm() < 1e-11);
    CHECK(b.softness == relative(force.dot(slope.inverse() * force)).epsilon(1e-7));
  }
}

TEST_CASE("where laws of rubber lose ellipticity") {
  for (const Hyperelastic& law : laws())
    for (const double l : {1.1, 2.0, 4.0}) CHECK(energy::ellipticity(law, Vec3(0.5 * (l * l - 1.0), 0.0, 0.0)) > 0.0);
  Hyperelastic soft;
  soft.c10 = 1.0;
  soft.c01 = -0.3;
  CHECK(energy::ellipticity(soft, Vec3::Zero()) > 0.0);
  CHECK(energy::ellipticity(soft, Vec3(1.5, 1.5, 0.0)) <= 0.0);
  CHECK(!energy::response(soft, Vec3(-0.6, 0.0, 0.0)).possible);
}

}  // namespace test_hyperelastic
