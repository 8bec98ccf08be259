// Form finding against closed forms: catenoid and its collapse, a bubble, arcs of cables, unequal forces; cases with [form].
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>
#include <vector>

#include "base/mpi.hpp"
#include "setup/form.hpp"
#include "setup/form_finding.hpp"
#include "setup/garment.hpp"
#include "test_case_kit.hpp"

namespace test_form_finding {

using namespace voile;
using namespace voile::testing;
using setup::find_form;
using setup::FormProblem;
using setup::FormResult;

namespace {

/// Along global axis z in the surface, and across it [N/m].
std::function<Mat3(Index, const std::array<Vec3, 3>&)> constant_force(double along, double across) {
  return [=](Index, const std::array<Vec3, 3>& x) {
    const Vec3 n = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    if (along == across) return Mat3(along * (Mat3::Identity() - n * n.transpose()));
    const Vec3 e1 = (Vec3::UnitZ() - n[2] * n).normalized(), e2 = n.cross(e1);
    return Mat3(along * e1 * e1.transpose() + across * e2 * e2.transpose());
  };
}

/// A cylinder of radius 1 between held rings at -height/2 and height/2, of n x rows cells whose rows are turned by half a cell.
FormProblem rings(int n, double height) {
  FormProblem p;
  const int rows = static_cast<int>(std::lround(n * height / (2.0 * std::numbers::pi)));
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < n; ++i) {
      const double a = 2.0 * std::numbers::pi * (i + 0.5 * j) / n;
      p.places.emplace_back(std::cos(a), std::sin(a), height * (static_cast<double>(j) / rows - 0.5));
      const bool held = j == 0 || j == rows;
      p.held.push_back({held, held, held});
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < n; ++i) {
      const Index a = j * n + i, b = j * n + (i + 1) % n;
      p.triangles.push_back({a, b, a + n});
      p.triangles.push_back({b, b + n, a + n});
    }
  p.force = constant_force(100.0, 100.0);
  p.within = setup::largest_within;
  return p;
}

/// Largest distance of the radius from that of a surface of revolution.
template <class Radius>
double off(const FormResult& r, const Radius& radius) {
  double most = 0.0;
  for (const Vec3& x : r.places) most = std::max(most, std::abs(std::hypot(x[0], x[1]) - radius(x[2])));
  return most;
}

/// Neck of the catenoid that is stable: the larger root of a cosh(h/2a) = 1.
double neck_of(double height) {
  double a = 1.0;
  for (int k = 0; k < 500; ++k) a = 0.5 * a + 0.5 / std::cosh(height / 2.0 / a);
  return a;
}

FormProblem square(int n, bool corners_only) {
  FormProblem p;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      p.places.emplace_back(2.0 * i / n - 1.0, 2.0 * j / n - 1.0, 0.0);
      const bool x = i == 0 || i == n, y = j == 0 || j == n, held = corners_only ? x && y : x || y;
      p.held.push_back({held, held, held});
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      if ((i + j) % 2 == 0) {
        p.triangles.push_back({a, b, d});
        p.triangles.push_back({b, c, d});
      } else {
        p.triangles.push_back({a, b, c});
        p.triangles.push_back({a, c, d});
      }
    }
  p.force = constant_force(100.0, 100.0);
  p.within = setup::largest_within;
  return p;
}

}  // namespace

TEST_CASE("a soap film between two rings is a catenoid, of second order in the cells") {
  for (const double height : {0.4, 0.8, 1.2, 1.3}) {
    const double a = neck_of(height);
    const auto error = [&](int n) {
      const FormResult r = find_form(rings(n, height));
      REQUIRE(r.converged);
      return off(r, [&](double z) { return a * std::cosh(z / a); });
    };
    const double coarse = error(32), fine = error(64);
    INFO("height ", height, ": ", coarse, ", ", fine);
    CHECK(fine < 2e-3);
    if (height < 1.25) CHECK(std::log2(coarse / fine) > 1.8);
  }
}

TEST_CASE("beyond 1.3255 radii between the rings there is no film, and none is found") {
  const auto has_film = [](double height) { return find_form(rings(64, height)).converged; };
  CHECK(has_film(1.32));
  for (const double height : {1.33, 1.35, 1.4, 1.6, 2.5}) {
    const FormResult r = find_form(rings(64, height));
    CHECK(!r.converged);
    CHECK(r.collapsed != no_index);
  }
  for (const int n : {16, 32})
    for (const double height : {1.36, 1.4, 1.45, 1.6}) CHECK(!find_form(rings(n, height)).converged);
}

TEST_CASE("a force across that is half of that along: the meridian is a parabola") {
  // N1 k1 + N2 k2 = 0 across the surface: r r'' = (1 + r'^2)/2, so r = a + z^2/(4 a).
  const double height = 1.2, a = 0.5 + 0.5 * std::sqrt(1.0 - height * height / 4.0);
  const auto error = [&](int n) {
    FormProblem p = rings(n, height);
    p.force = constant_force(200.0, 100.0);
    p.within = 1.0;
    const FormResult r = find_form(p);
    REQUIRE(r.converged);
    return off(r, [&](double z) { return a + z * z / (4.0 * a); });
  };
  const double coarse = error(32), fine = error(64);
  INFO(coarse, " ", fine);
  CHECK(fine < 1e-3);
  CHECK(std::log2(coarse / fine) > 1.7);
}

TEST_CASE("Scherk's surface, and a plane that has been dented") {
  const auto scherk = [](const Vec3& x) { return std::log(std::cos(x[1]) / std::cos(x[0])); };
  std::vector<double> errors;
  for (const int n : {8, 16, 32}) {
    FormProblem p = square(n, false);
    for (Vec3& x : p.places) x[2] = scherk(x) + 0.2 * (1.0 - x[0] * x[0]) * (1.0 - x[1] * x[1]);
    const FormResult r = find_form(p);
    REQUIRE(r.converged);
    double most = 0.0;
    for (const Vec3& x : r.places) most = std::max(most, std::abs(x[2] - scherk(x)));
    errors.push_back(most);
  }
  INFO(errors[0], " ", errors[1], " ", errors[2]);
  CHECK(errors[2] < 2e-3);
  CHECK(std::log2(errors[1] / errors[2]) > 1.8);
  FormProblem p = square(8, false);
  for (std::size_t v = 0; v < p.places.size(); ++v)
    if (!p.held[v][0]) p.places[v] += Vec3(0.02, -0.01, 0.2);
  const FormResult r = find_form(p);
  double most = 0.0;
  for (const Vec3& x : r.places) most = std::max(most, std::abs(x[2]));
  CHECK(r.converged);
  CHECK(most < 1e-8);
}

TEST_CASE("a film under pressure is a sphere of radius 2 N/p, and cables are arcs of radius T/N") {
  FormProblem cap = square(16, false);
  // On a disc: the square's rings become circles.
  for (Vec3& x : cap.places) {
    const double side = x.cwiseAbs().maxCoeff(), radius = x.norm();
    if (radius > 0.0) x *= side / radius;
  }
  cap.pressure = 150.0;
  const double radius = 2.0 * 100.0 / cap.pressure;
  const FormResult bubble = find_form(cap);
  REQUIRE(bubble.converged);
  double top = 0.0;
  for (const Vec3& x : bubble.places) top = std::max(top, x[2]);
  CHECK(std::abs(top / (radius - std::sqrt(radius * radius - 1.0)) - 1.0) < 0.005);
  cap.pressure = 210.0;
  CHECK(!find_form(cap).converged);

  for (const double force : {500.0, 2000.0}) {
    const int n = 16;
    FormProblem p = square(n, true);
    for (Index i = 0; i < n; ++i)
      for (const auto& [a, b] : {std::pair<Index, Index>{i, i + 1},
                                 {n * (n + 1) + i, n * (n + 1) + i + 1},
                                 {i * (n + 1), (i + 1) * (n + 1)},
                                 {i * (n + 1) + n, (i + 1) * (n + 1) + n}})
        p.cables.push_back({{a, b}, force});
    const FormResult r = find_form(p);
    REQUIRE(r.converged);
    const double arc = force / 100.0, sag = arc - std::sqrt(arc * arc - 1.0);
    INFO("force ", force, ": ", 1.0 + r.places[n / 2][1], " of ", sag);
    CHECK(std::abs((1.0 + r.places[n / 2][1]) / sag - 1.0) < 0.01);
  }
}

TEST_CASE("three films meet at 120 degrees") {
  const std::array<Vec3, 3> far{Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.3, 0.9, 0.0)};
  const int n = 4, rows = 4;  // cells from the middle line to each far one, and along them
  FormProblem p;
  const Vec3 middle(0.2, 0.5, 0.0);
  const auto vertex = [&](int film, int i, int j) {
    return static_cast<Index>(j * (3 * n + 1) + (i == 0 ? 0 : 1 + film * n + i - 1));
  };
  for (int j = 0; j <= rows; ++j)
    for (int k = 0; k <= 3 * n; ++k) {
      const double along = k == 0 ? 0.0 : ((k - 1) % n + 1.0) / n;
      const bool held = along == 1.0;
      p.places.push_back((1.0 - along) * middle + along * far[k == 0 ? 0 : static_cast<std::size_t>((k - 1) / n)] +
                         static_cast<double>(j) / rows * Vec3::UnitZ());
      p.held.push_back({held, held, held || j == 0 || j == rows});
    }
  for (int film = 0; film < 3; ++film)
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < n; ++i) {
        const Index a = vertex(film, i, j), b = vertex(film, i + 1, j), c = vertex(film, i + 1, j + 1),
                    d = vertex(film, i, j + 1);
        p.triangles.push_back({a, b, c});
        p.triangles.push_back({a, c, d});
      }
  p.force = constant_force(100.0, 100.0);
  p.within = setup::largest_within;
  const FormResult r = find_form(p);
  REQUIRE(r.converged);
  Vec3 sum = Vec3::Zero();  // of unit vectors to the far lines: no force is left
  for (const Vec3& x : far) sum += (x - Vec3(r.places[0][0], r.places[0][1], 0.0)).normalized();
  CHECK(sum.norm() < 1e-7);
}

TEST_CASE("[form] in a case: every rank has the same form; mistakes name what is missing") {
  const std::string text =
      "[mesh]\nfile = \"" VOILE_SOURCE_FOLDER
      "/meshes/tube.geo\"\n"
      "parameters = {radius = 1.0, length = 0.8, n_axial = 6, n_circ = 24}\n[form]\n"
      "[[material]]\ntype = \"isotropic\"\nyoung = 1e9\npoisson = 0.3\nthickness = 1e-4\nprestress = [100, 100]\n"
      "[[support]]\ngroup = \"start\"\ntype = \"hinged\"\n[[support]]\ngroup = \"end\"\ntype = \"hinged\"\n";
  const auto mesh_of = [](const std::string& with) {
    return setup::case_mesh(PETSC_COMM_WORLD, input::parse_case(with, "case.toml"));
  };
  const mesh::SurfaceMesh mesh = mesh_of(text);
  double neck = 1.0, sum = 0.0;
  for (const Vec3& x : mesh.positions()) {
    neck = std::min(neck, std::hypot(x[1], x[2]));
    sum += x.squaredNorm();
  }
  CHECK(neck == doctest::Approx(neck_of(0.8)).epsilon(0.01));
  CHECK(mpi::max(PETSC_COMM_WORLD, sum) == sum);
  CHECK(
      has(error_of([&] { (void)mesh_of(replaced(text, "length = 0.8", "length = 1.5")); }), "[form]: no equilibrium"));
  const std::string end = "[[support]]\ngroup = \"end\"\ntype = \"hinged\"\n";
  const std::string one =
      replaced(replaced(text, end, ""), "type = \"hinged\"", "type = \"displacement\"\ncomponents = [\"x\", \"y\"]");
  CHECK(has(error_of([&] { (void)mesh_of(one); }), "nothing holds the piece"));
  CHECK(has(error_of([&] { (void)mesh_of(one); }), "m along z"));
  CHECK(has(error_of(replaced(text, "[100, 100]", "[-100, -100]")), "does not pull in all directions"));
  CHECK(
      has(error_of(replaced(text, "prestress = [100, 100]\n", "")), "[form]: the [[material]] of all other triangles"));
  CHECK(has(error_of(replaced(text, end, "[[support]]\ngroup = \"end\"\ntype = \"symmetry\"\n")), "give `normal`"));
  const std::string band = text + "[[spring]]\ntype = \"band\"\ngroup = \"end\"\nstiffness = 10\n";
  CHECK(has(error_of(band + "length = 1\n"), "give it `force` instead"));
  CHECK(has(error_of(band + "length = 1\nforce = 1\n"), "force: `length` is given too"));
}

}  // namespace test_form_finding
