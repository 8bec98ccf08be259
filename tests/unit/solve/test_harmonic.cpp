// Frequency response: one degree of freedom in closed form, a model against its own dense matrices, and effective masses.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/mpi.hpp"
#include "solve/direct_response.hpp"
#include "solve/modal_basis.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"

namespace test_harmonic {

using namespace voile;
using namespace voile::testing;
using Complex = std::complex<double>;

namespace {

constexpr double circle = 2.0 * std::numbers::pi;

Eigen::MatrixXd one(double x) {
  return Eigen::MatrixXd::Constant(1, 1, x);
}

/// Frequency 3 Hz, unit mass and force.
solve::ReducedSystem oscillator(double damping) {
  const double omega = circle * 3.0;
  return {one(omega * omega), damping > 0.0 ? one(damping) : Eigen::MatrixXd(), Eigen::VectorXd::Ones(1), one(1.0)};
}

/// A plate with two edges supported, pulled in its plane, with a mass on a corner's edge.
struct Plate {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  Plate() : mesh(data()), model(PETSC_COMM_WORLD, mesh, input()), a(model.dofs().create_vector()) {}
  static mesh::MeshData data() {
    mesh::MeshData d = grid(4, 3, true, 0.0);
    add_square_groups(d);
    return d;
  }
  static system::ModelInput input() {
    system::ModelInput in;
    in.materials = {isotropic(2e9, 0.3, 0.01, 20.0)};
    in.materials[0].bending_damping = 2e-4;
    in.materials[0].viscous_time = 1e-5;
    in.supports = {support("left", system::Support::Kind::clamped)};
    in.loads = {load(system::Load::Kind::line, "right", Vec3(30.0, 10.0, 20.0))};
    in.masses = {{"right", 1.5}};
    return in;
  }
};

Eigen::MatrixXd dense(const system::Model& model, Mat m) {
  const auto n = static_cast<Eigen::Index>(model.dofs().unknowns());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, n);
  PetscInt first = 0, last = 0;
  VOILE_PETSC(MatGetOwnershipRange(m, &first, &last));
  for (PetscInt i = first; i < last; ++i) {
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    VOILE_PETSC(MatGetRow(m, i, &count, &columns, &values));
    for (PetscInt k = 0; k < count; ++k) all(i, columns[k]) = values[k];
    VOILE_PETSC(MatRestoreRow(m, i, &count, &columns, &values));
  }
  return all;
}

Eigen::VectorXd dense(Vec v) {
  PetscInt n = 0;
  VOILE_PETSC(VecGetSize(v, &n));
  const petsc::ReadArray in(v);
  return Eigen::Map<const Eigen::VectorXd>(in.data(), n);
}

}  // namespace

TEST_CASE("one degree of freedom follows its closed form, by a ratio or by a damping") {
  const double zeta = 0.02, omega = circle * 3.0;
  for (const bool by_ratio : {true, false}) {
    const solve::ReducedResponse r(oscillator(by_ratio ? 0.0 : 2.0 * zeta * omega),
                                   by_ratio ? std::vector<double>{zeta} : std::vector<double>{});
    CHECK(r.frequencies()[0] == relative(3.0).epsilon(1e-14));
    CHECK(r.ratios()[0] == relative(zeta).epsilon(1e-12));
    for (const double f : {0.0, 1.0, 2.99, 3.0, 10.0}) {
      const double w = circle * f;
      const Complex exact = 1.0 / Complex(omega * omega - w * w, 2.0 * zeta * omega * w);
      CHECK(std::abs(r.at(f)[0] - exact) < 1e-13 * std::abs(exact));
    }
    CHECK(std::arg(r.at(3.0)[0]) == relative(-0.5 * std::numbers::pi).epsilon(1e-9));
  }
}

TEST_CASE("white noise on one degree of freedom has the exact mean squares") {
  const double s = 0.7, omega = circle * 3.0;
  for (const double zeta : {0.5, 0.02, 1e-4}) {
    const solve::ReducedResponse r(oscillator(0.0), {zeta});
    const solve::SpectralDensity white{{1e-9, 3e5}, {s, s}};
    const Eigen::VectorXd mean = solve::mean_squares(r, white, [&](double f) {
      Eigen::VectorXcd h(2);
      h << r.at(f)[0], Complex(0.0, circle * f) * r.at(f)[0];
      return h;
    });
    CHECK(mean[0] == relative(s / (8.0 * zeta * std::pow(omega, 3))).epsilon(1e-9));
    CHECK(mean[1] == relative(s / (8.0 * zeta * omega)).epsilon(1e-4));  // the band ends where 1/f^2 is not yet small
  }
}

TEST_CASE("a spectral density is straight in double logarithmic scale and zero outside its table") {
  const solve::SpectralDensity s{{1.0, 10.0, 100.0}, {2.0, 200.0, 200.0}};
  CHECK(s.at(0.99) == 0.0);
  CHECK(s.at(101.0) == 0.0);
  CHECK(s.at(3.0) == relative(18.0).epsilon(1e-12));
  CHECK(s.at(50.0) == relative(200.0).epsilon(1e-12));
  CHECK(s.at(100.0) == relative(200.0).epsilon(1e-12));
}

TEST_CASE("direct solution and modes agree with dense matrices") {
  Plate plate;
  const solve::MassMatrix mass(plate.model, plate.a, system::Mass::consistent);
  system::DynamicsOptions options;
  options.mass_damping = 0.4;
  options.bending_damping = 1e-4;
  options.viscous_time = 3e-5;
  const petsc::MatHandle damping = solve::damping_matrix(plate.model, plate.a, options, mass);
  REQUIRE(damping);
  const solve::DirectResponse direct(plate.model, plate.a, mass, damping);
  const petsc::VecHandle force = plate.model.dofs().create_vector(), x = plate.model.dofs().create_vector(),
                         y = plate.model.dofs().create_vector();
  plate.model.load_direction(plate.a, force);
  plate.model.dofs().clear_fixed(force);
  const solve::EigenResult r = solve::vibration_modes(plate.model, plate.a, 12, mass.mat());
  const solve::ModalBasis basis = solve::modal_basis(plate.model, plate.a, r.modes, mass, damping, force);
  CHECK(basis.vectors.size() > 15);  // damping is not in proportion
  CHECK(basis.fewer < basis.vectors.size());
  system::DynamicsOptions in_proportion;
  in_proportion.mass_damping = 0.4;
  const petsc::MatHandle by_mass = solve::damping_matrix(plate.model, plate.a, in_proportion, mass);
  // Of the modes nothing is new; of the three corrections the next ones, twice.
  CHECK(solve::modal_basis(plate.model, plate.a, r.modes, mass, by_mass, force).vectors.size() == 21);
  if (mpi::size(PETSC_COMM_WORLD) > 1) return;
  plate.model.assemble_tangent(plate.a, {.kind = energy::Tangent::exact});
  const Eigen::MatrixXd k = dense(plate.model, plate.model.tangent().matrix()), m = dense(plate.model, mass.mat()),
                        c = dense(plate.model, damping);
  solve::ReducedSystem reduced = basis.system;
  reduced.rows.resize(k.rows(), static_cast<Eigen::Index>(basis.vectors.size()));
  for (std::size_t i = 0; i < basis.vectors.size(); ++i)
    reduced.rows.col(static_cast<Eigen::Index>(i)) = dense(basis.vectors[i]);
  CHECK((reduced.rows.transpose() * m * reduced.rows -
         Eigen::MatrixXd::Identity(reduced.rows.cols(), reduced.rows.cols()))
            .norm() < 1e-9);
  const solve::ReducedResponse response(reduced, {}), fewer(reduced.first(12), {});
  for (const double part : {0.0, 0.3, 1.0, 2.3}) {
    const double f = part * r.modes[0].value, w = circle * f;
    const Eigen::MatrixXcd system = (k - w * w * m).cast<Complex>() + Complex(0.0, w) * c;
    const Eigen::VectorXcd exact = system.partialPivLu().solve(dense(force).cast<Complex>());
    direct.solve(w, force, 0.0, x, y);
    CHECK((dense(x) + Complex(0.0, 1.0) * dense(y) - exact).norm() < 1e-9 * exact.norm());
    CHECK((response.at(f) - exact).norm() < 1e-6 * exact.norm());
    if (part == 0.0) CHECK((response.at(f) - exact).norm() < 1e-9 * exact.norm());
    CHECK((fewer.at(f) - exact).norm() > 1e-5 * exact.norm());  // what the corrections are for
  }
}

TEST_CASE("effective masses of all modes are all that moves freely; translations weigh the whole mass") {
  for (const system::Mass kind : {system::Mass::consistent, system::Mass::lumped}) {
    Plate plate;
    const solve::MassMatrix mass(plate.model, plate.a, kind);
    const system::RigidInertia inertia = system::rigid_inertia(plate.model, plate.a, kind);
    CHECK(inertia.mass == relative(20.0 + 4 * 1.5).epsilon(1e-12));
    CHECK(inertia.centre[0] == relative((20.0 * 0.5 + 6.0) / 26.0).epsilon(1e-12));
    const int free = 3 * 20 - 3 * 4;
    const solve::EigenResult r = solve::vibration_modes(plate.model, plate.a, free, mass.mat());
    REQUIRE(static_cast<int>(r.modes.size()) == free);
    const auto parts = solve::participation(r.modes, mass.mat(), inertia);
    std::array<double, 6> sum{};
    for (const solve::Participation& p : parts)
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += p.effective[i];
    if (mpi::size(PETSC_COMM_WORLD) > 1) {
      CHECK(sum[0] < inertia.mass);
      continue;
    }
    Eigen::MatrixXd m = dense(plate.model, mass.mat());
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      if (m(i, i) == 0.0) m(i, i) = 1.0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const Eigen::VectorXd f = dense(inertia.force[i]);
      CHECK(sum[i] == relative(f.dot(m.lu().solve(f))).epsilon(1e-8));
    }
  }
}

}  // namespace test_harmonic
