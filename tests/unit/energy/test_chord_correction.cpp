// One element of the corrected membrane: the tangents besides the exact one, which test_derivatives.cpp has.
#include "base/decompositions.hpp"
#include "energy/chord_correction.hpp"

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <numbers>

#include "../test_meshes.hpp"
#include "../test_model_kit.hpp"
#include "../test_relative.hpp"
#include "energy/chord_forms.hpp"
#include "energy/curvature.hpp"
#include "energy/membrane.hpp"

namespace test_chord_correction {

using namespace voile;
using namespace voile::testing;

namespace {

mesh::MeshData saddle() {
  return mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
    return Vec3(x[0], x[1], 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1] + 0.1 * x[0] * x[1]);
  });
}

/// A flat square of uneven cells.
mesh::MeshData uneven() {
  return square(Pattern::jittered, 6);
}

/// Rolled up about the y axis without stretch, tighter and tighter: angle a s + b s^2 at the arc length s.
Vec3 spiral(double s, double y) {
  constexpr int steps = 200;
  Vec3 x(0.0, y, 0.0);
  for (int i = 0; i < steps; ++i)  // Gauss's rule of two points
    for (const double g : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {
      const double at = s * (i + g) / steps, angle = at + 2.0 * at * at;
      x += s / (2.0 * steps) * Vec3(std::cos(angle), 0.0, std::sin(angle));
    }
  return x;
}

/// A triangle in the middle of a sheet, with points numbered as the mesh is.
struct Middle {
  mesh::SurfaceMesh mesh;
  std::vector<energy::Material> materials{isotropic(100.0, 0.3, 0.1)};
  mesh::PatchMesh patches{mesh, {}};
  energy::Sheet sheet;
  energy::MembraneTerm kernel;
  double area = 0.0;

  explicit Middle(double fraction, const mesh::MeshData& data = saddle())
      : mesh(data), sheet(patches, materials, energy::assign_materials(mesh, materials), options(fraction)) {
    kernel = energy::MembraneTerm(sheet);
    Index t = 0;
    const auto from_middle = [&](Index k) -> Vec2 {
      return (mesh.start_corner(k, 0) + mesh.start_corner(k, 1) + mesh.start_corner(k, 2)).head<2>() / 3.0 -
             Vec2(0.5, 0.5);
    };
    for (Index k = 1; k < mesh.triangle_count(); ++k)
      if (from_middle(k).norm() < from_middle(t).norm()) t = k;
    area = mesh.area(t);
    energy::CurvatureBuilder builder(sheet);
    const energy::BendingElement bending = energy::make_bending_element(sheet, t, builder.build(t));
    kernel.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), true);
    kernel.correct(sheet, energy::ChordForms(sheet).trace(t), t, bending, bending.points);
  }
  static energy::ElementOptions options(double fraction) {
    energy::ElementOptions o;
    o.membrane = energy::MembraneOperator::six_node_corrected;
    o.cst_fraction = fraction;
    return o;
  }
  [[nodiscard]] std::vector<Vec3> placed(const std::vector<Vec3>& u) const {
    std::vector<Vec3> x = mesh.positions();
    for (std::size_t v = 0; v < x.size(); ++v) x[v] += u[v];
    return x;
  }
  [[nodiscard]] Vec3 strain(const std::vector<Vec3>& u) const {
    const std::vector<Vec3> x = placed(u);
    return kernel.strain(0, {x.data(), u.data()});
  }
  /// By stencil positions.
  [[nodiscard]] Eigen::MatrixXd hessian(const std::vector<Vec3>& u, energy::Tangent tangent,
                                        const std::vector<Vec3>* previous = nullptr) const {
    const std::vector<Vec3> x = placed(u), before = placed(previous ? *previous : u);
    const int n = kernel.stencil_size(0);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    kernel.hessian(0, {x.data(), u.data(), before.data(), tangent},
                   [&](int i, int j, const Mat3& k) { h.block<3, 3>(3 * i, 3 * j) += k; });
    return h;
  }
  [[nodiscard]] std::vector<Vec3> moved(double size, unsigned seed) const {
    std::vector<Vec3> u;
    for (Index v = 0; v < mesh.vertex_count(); ++v) u.push_back(noise(size, seed)(v));
    return u;
  }
};

std::vector<Vec3> sum(std::vector<Vec3> a, double factor, const std::vector<Vec3>& b) {
  for (std::size_t v = 0; v < a.size(); ++v) a[v] += factor * b[v];
  return a;
}

/// d2E_r/dx_i dx_j of each strain, which is quadratic: the same number for x, y and z.
std::array<Eigen::MatrixXd, 3> second_derivatives(const Middle& m) {
  const int n = m.kernel.stencil_size(0);
  const Index* points = m.kernel.stencil(0);
  const std::vector<Vec3> none(static_cast<std::size_t>(m.mesh.vertex_count()), Vec3::Zero());
  const auto at = [&](int i, int j) {
    std::vector<Vec3> u = none;
    if (i >= 0) u[points[i]].z() += 0.1;
    if (j >= 0) u[points[j]].z() += 0.1;
    return m.strain(u);
  };
  std::array<Eigen::MatrixXd, 3> second;
  second.fill(Eigen::MatrixXd::Zero(n, n));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Vec3 change = (at(i, j) - at(i, -1) - at(-1, j) + at(-1, -1)) / 0.01;
      for (int r = 0; r < 3; ++r) second[r](i, j) = change[r];
    }
  return second;
}

}  // namespace

TEST_CASE(
    "the tangent with the linearised stress leaves out what is of second order in the step, curvatures included") {
  // With a fraction of 0 the strain is the mean one, with 1 that of the triangle.
  for (const double fraction : {0.0, 1.0}) {
    const Middle m(fraction);
    CHECK(m.kernel.stencil_size(0) == 12);
    const std::vector<Vec3> before = m.moved(0.02, 3), step = m.moved(0.05, 4), now = sum(before, 1.0, step);
    const Vec3 quadratic =
        0.5 * (m.strain(sum(before, 1.0, step)) + m.strain(sum(before, -1.0, step)) - 2.0 * m.strain(before));
    const Vec3 stress = m.area * (m.materials[0].membrane * quadratic);
    const Eigen::MatrixXd exact = m.hessian(now, energy::Tangent::exact),
                          linearised = m.hessian(now, energy::Tangent::linearised_stress, &before);
    const auto second = second_derivatives(m);
    Eigen::MatrixXd expected = exact;
    for (int i = 0; i < m.kernel.stencil_size(0); ++i)
      for (int j = 0; j < m.kernel.stencil_size(0); ++j)
        for (int r = 0; r < 3; ++r)
          expected.block<3, 3>(3 * i, 3 * j) -= stress[r] * second[r](i, j) * Mat3::Identity();
    CAPTURE(fraction);
    CHECK((exact - expected).norm() > 1e-3 * exact.norm());
    CHECK((linearised - expected).norm() < 1e-10 * exact.norm());
  }
}

TEST_CASE("a taut sheet resists the whole slope of a wave, of which the six-node membrane misses twice S:kk") {
  // w = sin(pi x) sin(pi y): the strains, which are quadratic in w, add up to the integral of 1/2 (w,x^2 + w,y^2).
  constexpr int n = 8;
  const double pi = std::numbers::pi;
  for (const Pattern pattern : {Pattern::diagonal, Pattern::jittered})
    for (const bool corrected : {false, true}) {
      const mesh::SurfaceMesh mesh(square(pattern, n));
      const std::vector<energy::Material> materials{isotropic(100.0, 0.3, 0.1)};
      const mesh::PatchMesh patches(mesh, {});
      energy::ElementOptions o = Middle::options(0.0);
      if (!corrected) o.membrane = energy::MembraneOperator::six_node;
      const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), o);
      energy::MembraneTerm kernel(sheet);
      energy::CurvatureBuilder builder(sheet);
      const energy::ChordForms forms(sheet);
      std::vector<Vec3> x = mesh.positions(), u(x.size(), Vec3::Zero());
      for (std::size_t v = 0; v < x.size(); ++v) u[v].z() = std::sin(pi * x[v][0]) * std::sin(pi * x[v][1]);
      for (std::size_t v = 0; v < x.size(); ++v) x[v] += u[v];
      double sum = 0.0;
      for (Index t = 0; t < mesh.triangle_count(); ++t) {
        kernel.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), true);
        const energy::BendingElement bending = energy::make_bending_element(sheet, t, builder.build(t));
        if (corrected) kernel.correct(sheet, forms.trace(t), t, bending, bending.points);
        sum += mesh.area(t) * kernel.strain(t, {x.data(), u.data()}).head<2>().sum();
      }
      const double error = sum / (pi * pi / 4.0) - 1.0;
      CAPTURE(error);
      if (corrected)
        CHECK(std::abs(error) < 2e-3);
      else  // 2 S:kk = (pi/n)^2/3 on even cells
        CHECK(error == relative(-pi * pi / (3.0 * n * n)).epsilon(0.2));
    }
}

TEST_CASE("the positive tangent of a bent and compressed element has no negative eigenvalue, the exact one has") {
  for (const double fraction : {0.0, 0.3, 1.0}) {
    const Middle m(fraction);
    for (const double stretch : {-0.1, 0.1}) {
      std::vector<Vec3> u = m.moved(0.02, 5);
      for (Index v = 0; v < m.mesh.vertex_count(); ++v) {
        const Vec3& x = m.mesh.positions()[v];
        u[v] += Vec3(stretch * x[0], -stretch * x[1], 0.5 * x[0] * x[0]);
      }
      const Eigen::VectorXd exact = eigenvalues(Eigen::MatrixXd(m.hessian(u, energy::Tangent::exact))),
                            positive = eigenvalues(Eigen::MatrixXd(m.hessian(u, energy::Tangent::positive)));
      CAPTURE(fraction);
      CAPTURE(stretch);
      CHECK(exact.minCoeff() < -1e-4 * exact.maxCoeff());
      CHECK(positive.minCoeff() > -1e-12 * positive.maxCoeff());
    }
  }
}

TEST_CASE(
    "the strain of a surface that bends without stretching is of fourth order in the cells, however its curvature "
    "varies") {
  for (const double fraction : {0.0, 1.0}) {
    const Middle m(fraction, uneven());
    const auto strain = [&](double size) {
      std::vector<Vec3> u;
      for (const Vec3& x : m.mesh.positions())
        u.push_back(spiral(size * (x[0] - 0.3), size * x[1]) / size - Vec3(x[0] - 0.3, x[1], 0.0));
      return m.strain(u).norm();
    };
    const double coarse = strain(0.4), fine = strain(0.2);
    CAPTURE(fraction);
    CAPTURE(coarse);
    CHECK(coarse > 1e-9);
    CHECK(std::log2(coarse / fine) > 3.7);  // 3 with one curvature per triangle, 2 with none
  }
}

TEST_CASE(
    "with the term of fourth order an arc has the bending energy of its curvature, to the fourth order in its angle") {
  // An even strip; cells of length 1 along the arc.
  const Middle m(0.0, mapped(square(Pattern::diagonal, 6), [](const Vec3& x) { return Vec3(6.0 * x); }));
  const double bending = m.materials[0].bending(0, 0);
  for (const double angle : {0.1, 0.2}) {
    std::vector<Vec3> u;
    for (const Vec3& x : m.mesh.positions())
      u.push_back(Vec3(std::sin(angle * x[0]) / angle, x[1], (1.0 - std::cos(angle * x[0])) / angle) - x);
    const std::vector<Vec3> x = m.placed(u);
    // The second difference of the arc, and what is left of the strain.
    const double difference = std::pow(2.0 * std::sin(0.5 * angle) / angle, 2) * angle;
    const double energy = m.kernel.energy(0, {x.data(), u.data()}) / m.area -
                          0.5 * m.strain(u).dot(m.materials[0].membrane * m.strain(u)) +
                          0.5 * bending * difference * difference;
    CAPTURE(angle);
    CHECK(energy == relative(0.5 * bending * angle * angle).epsilon(0.1 * std::pow(angle, 4)));
  }
}

}  // namespace test_chord_correction
