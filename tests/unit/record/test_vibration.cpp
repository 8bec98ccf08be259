// Vibrations: von Mises's stress of complex amplitudes, random stresses, what supports bear, and the root of a covariance.
#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "base/mpi.hpp"
#include "record/response.hpp"
#include "record/response_rows.hpp"
#include "record/stresses.hpp"
#include "record/support_forces.hpp"
#include "solve/direct_response.hpp"
#include "solve/modal_basis.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"

namespace test_vibration {

using namespace voile;
using namespace voile::testing;
using Complex = std::complex<double>;

namespace {

constexpr double circle = 2.0 * std::numbers::pi;

system::ModelInput plate() {
  system::ModelInput in;
  in.materials = {isotropic(2e9, 0.3, 0.01, 20.0)};
  in.materials[0].bending_damping = 2e-4;
  in.materials[0].viscous_time = 1e-5;
  in.supports = {support("left", system::Support::Kind::clamped)};
  in.loads = {load(system::Load::Kind::line, "right", Vec3(30.0, 10.0, 20.0)),
              load(system::Load::Kind::gravity, "", Vec3(0.0, 0.0, -1.0))};
  in.masses = {{"right", 1.5}, {"left", 0.5}};
  return in;
}

Vec3 sum_of(const system::Model& model, Vec f) {
  const std::vector<double> all = model.dofs().gather_forces(f);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < all.size(); ++i) sum[static_cast<Eigen::Index>(i % 3)] += all[i];
  return sum;
}

}  // namespace

TEST_CASE("von Mises's stress of complex amplitudes is the largest of a cycle") {
  const Eigen::Vector3cd s(Complex(3.0, -1.0), Complex(-2.0, 0.5), Complex(0.7, 2.0));
  double largest = 0.0;
  for (int i = 0; i < 3600; ++i) {
    const Complex turn = std::polar(1.0, circle * i / 3600.0);
    const Vec3 now = (s * turn).real();
    largest = std::max(largest, record::von_mises(now));
    CHECK(record::von_mises_parts(now.cast<Complex>()).norm() == relative(record::von_mises(now)).epsilon(1e-12));
  }
  CHECK(record::largest_von_mises(s) == relative(largest).epsilon(1e-6));
}

TEST_CASE(
    "the covariance of an oscillator under white noise is exact, and displacement and velocity are uncorrelated") {
  const double zeta = 0.02, omega = circle * 3.0, s = 0.7;
  const Eigen::MatrixXd k = Eigen::MatrixXd::Constant(1, 1, omega * omega);
  const solve::ReducedResponse r({k, {}, Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Ones(1, 1)}, {zeta});
  const solve::SpectralDensity white{{1e-9, 3e5}, {s, s}};
  const Eigen::MatrixXd c = solve::covariance(r, white, [&](double f) {
    Eigen::VectorXcd h(2);
    h << r.coordinates(f)[0], Complex(0.0, circle * f) * r.at(f)[0];
    return h;
  });
  CHECK(c(0, 0) == relative(s / (8.0 * zeta * std::pow(omega, 3))).epsilon(1e-9));
  CHECK(c(1, 1) == relative(s / (8.0 * zeta * omega)).epsilon(1e-4));
  CHECK(std::abs(c(0, 1)) < 1e-12 * std::sqrt(c(0, 0) * c(1, 1)));
  CHECK(c(0, 1) == c(1, 0));
}

TEST_CASE("the root of a covariance is exact in each row by itself") {
  Eigen::MatrixXd a = Eigen::MatrixXd::Random(4, 4);
  const Eigen::Vector4d size(1.0, 1e-9, 1e-5, 0.0);
  const Eigen::MatrixXd m = size.asDiagonal() * Eigen::MatrixXd(a * a.transpose()) * size.asDiagonal();
  const Eigen::MatrixXd w = record::root_of(m);
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j < 4; ++j)
      CHECK(std::abs((w * w.transpose())(i, j) - m(i, j)) < 1e-13 * std::sqrt(m(i, i) * m(j, j)) + 1e-300);
}

TEST_CASE("supports bear what moves the mass, less the loads, with damping of all kinds and either mass") {
  for (const system::Mass kind : {system::Mass::consistent, system::Mass::lumped}) {
    mesh::MeshData data = grid(4, 3, true, 0.0);
    add_square_groups(data);
    const mesh::SurfaceMesh mesh(data);
    system::Model model(PETSC_COMM_WORLD, mesh, plate());
    const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                           x = model.dofs().create_vector(), y = model.dofs().create_vector();
    const solve::MassMatrix mass(model, a, kind);
    system::DynamicsOptions options;
    options.mass_damping = 0.4;
    options.bending_damping = 1e-4;
    options.viscous_time = 3e-5;
    const petsc::MatHandle damping = solve::damping_matrix(model, a, options, mass);
    model.load_direction(a, f);
    model.dofs().clear_fixed(f);
    const double omega = 40.0;
    solve::DirectResponse(model, a, mass, damping).solve(omega, f, 0.0, x, y);
    record::SupportForces forces(model, a, options, mass);
    const record::SupportForces::Rows p = forces.of(x), q = forces.of(y);
    const Vec3 loads(30.0, 10.0, 20.0 - 20.0);  // of an edge of 1 m, and the weight of 20 kg; masses weigh in besides
    const Vec3 real = sum_of(model, p.stiffness) - omega * omega * sum_of(model, p.inertia) -
                      omega * sum_of(model, q.damping) + sum_of(model, forces.of_loads());
    const Vec3 imaginary =
        sum_of(model, q.stiffness) - omega * omega * sum_of(model, q.inertia) + omega * sum_of(model, p.damping);
    const system::RigidInertia inertia = system::rigid_inertia(model, a, kind);
    for (std::size_t k = 0; k < 3; ++k) {
      double u = 0.0, v = 0.0;  // mass times displacement, of what moves
      VOILE_PETSC(VecDot(inertia.force[k], x, &u));
      VOILE_PETSC(VecDot(inertia.force[k], y, &v));
      const auto i = static_cast<Eigen::Index>(k);
      const double load = loads[i] - (k == 2 ? 6.0 + 2.0 : 0.0), size = 30.0;
      if (mpi::rank(PETSC_COMM_WORLD) != 0) continue;
      CHECK(std::abs(real[i] + load + omega * omega * u + 0.4 * omega * v) < 1e-7 * size);
      CHECK(std::abs(imaginary[i] + omega * omega * v - 0.4 * omega * u) < 1e-7 * size);
    }
  }
}

}  // namespace test_vibration
