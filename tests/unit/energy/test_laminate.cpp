// Classical lamination theory: R.M. Jones, Mechanics of Composite Materials (2nd ed. 1999), chapter 4.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <numbers>

#include "energy/material.hpp"
#include "input/case.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_laminate {

using namespace voile;
using energy::laminate;
using energy::Ply;

namespace {

constexpr double right = std::numbers::pi / 2.0;

Mat3 ply() {
  return energy::orthotropic_membrane(3300.0, 1100.0, 0.25, 660.0, 1.0);
}

double difference(const Mat3& a, const Mat3& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

std::string case_with(const std::string& angles, const std::string& thicknesses) {
  return "[mesh]\nfile = \"a.geo\"\n[[material]]\ntype = \"laminate\"\nyoung_1 = 3300\nyoung_2 = 1100\n"
         "poisson_12 = 0.25\nshear_12 = 660\ndensity = 2\ndirection = [0, 1, 0]\nangles = " +
         angles + "\nply_thicknesses = " + thicknesses + "\n";
}

}  // namespace

TEST_CASE("two fused layers bend as the laminate of both, at free stretch; without bond as two sheets") {
  const double thick = 2e-3, thin = 1e-3, distance = 0.5 * (thick + thin);
  const Mat3 q = 1e6 * ply(), other = energy::rotated_stiffness(0.3 * q, 0.4);
  energy::Material fused, loose;
  fused.membrane = loose.membrane = q * thick;
  fused.bending = loose.bending = energy::bending_from_membrane(q * thick, thick);
  fused.areal_density = 0.2;
  energy::FusedLayer layer{other * thin, energy::bending_from_membrane(other * thin, thin), 0.05, distance};
  energy::fuse(fused, layer);
  layer.bond = 0.0;
  energy::fuse(loose, layer);
  // About the middle of the first layer; D - B A^-1 B does not depend on where that is.
  const Mat3 a = q * thick + other * thin, b = other * thin * distance;
  const Mat3 d = energy::bending_from_membrane(q * thick, thick) + energy::bending_from_membrane(other * thin, thin) +
                 other * thin * distance * distance;
  CHECK(difference(fused.membrane, a) < 1e-14);
  CHECK(difference(fused.bending, d - b * a.inverse() * b) < 1e-12);
  CHECK(fused.areal_density == doctest::Approx(0.25));
  CHECK(difference(loose.bending, d - other * thin * distance * distance) < 1e-12);
  // Two equal ones are the plate of twice the thickness.
  energy::Material two;
  two.membrane = q * thick;
  two.bending = energy::bending_from_membrane(q * thick, thick);
  energy::fuse(two, {two.membrane, two.bending, 0.0, thick});
  CHECK(difference(two.bending, energy::bending_from_membrane(q * 2.0 * thick, 2.0 * thick)) < 1e-12);
}

TEST_CASE("one ply is a plate, whatever it is cut into") {
  const Mat3 q = ply();
  for (const std::vector<Ply>& plies :
       {std::vector<Ply>{{0.0, 0.3}}, std::vector<Ply>{{0.0, 0.1}, {0.0, 0.1}, {0.0, 0.1}},
        std::vector<Ply>{{0.0, 0.05}, {0.0, 0.25}}}) {
    const energy::LaminateStiffness l = laminate(q, plies);
    CHECK(l.thickness == relative(0.3));
    CHECK(difference(l.membrane, 0.3 * q) < 1e-14);
    CHECK(difference(l.bending, 0.3 * 0.3 * 0.3 / 12.0 * q) < 1e-14);
    CHECK(l.coupling.cwiseAbs().maxCoeff() < 1e-14 * q.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("cross-ply 0/90/0: the outer plies bend, all of them stretch") {
  const Mat3 q = ply();
  const double h = 0.9, t = h / 3.0;
  const energy::LaminateStiffness l = laminate(q, {{0.0, t}, {right, t}, {0.0, t}});
  CHECK(l.membrane(0, 0) == relative(t * (2.0 * q(0, 0) + q(1, 1))));
  CHECK(l.membrane(1, 1) == relative(t * (2.0 * q(1, 1) + q(0, 0))));
  CHECK(l.membrane(2, 2) == relative(h * 660.0));
  // The middle ply holds 1/27 of h^3/12.
  const double i = h * h * h / 12.0;
  CHECK(l.bending(0, 0) == relative(i * (26.0 * q(0, 0) + q(1, 1)) / 27.0));
  CHECK(l.bending(1, 1) == relative(i * (26.0 * q(1, 1) + q(0, 0)) / 27.0));
  CHECK(l.bending(0, 1) == relative(i * q(0, 1)));
  CHECK(l.coupling.cwiseAbs().maxCoeff() < 1e-12 * l.membrane.cwiseAbs().maxCoeff());
}

TEST_CASE("turning a ply: quarter turns, isotropic invariance, Young's modulus off axis") {
  const Mat3 q = ply();
  Mat3 swapped = q;
  std::swap(swapped(0, 0), swapped(1, 1));
  CHECK(difference(energy::rotated_stiffness(q, right), swapped) < 1e-14);
  CHECK(difference(energy::rotated_stiffness(energy::rotated_stiffness(q, 0.4), -0.4), q) < 1e-14);
  const Mat3 isotropic = energy::isotropic_membrane(7.0, 0.3, 1.0);
  CHECK(difference(energy::rotated_stiffness(isotropic, 0.7), isotropic) < 1e-14);
  // 1/E_x = c^4/E1 + s^4/E2 + (1/G - 2 nu/E1) c^2 s^2
  const double angle = 0.5, c = std::cos(angle), s = std::sin(angle);
  const double compliance =
      std::pow(c, 4) / 3300.0 + std::pow(s, 4) / 1100.0 + (1.0 / 660.0 - 2.0 * 0.25 / 3300.0) * c * c * s * s;
  CHECK(energy::rotated_stiffness(q, angle).inverse()(0, 0) == relative(compliance).epsilon(1e-12));
  // Fibres turned towards axis 2 shear to the same side under tension along axis 1: Q16 > 0 for a positive angle.
  CHECK(energy::rotated_stiffness(q, angle)(0, 2) > 0.0);
}

TEST_CASE("a laminate in the case file") {
  const input::Case c = input::parse_case(case_with("[0, 90, 0]", "[0.3]"), "case.toml");
  const energy::LaminateStiffness l = laminate(ply(), {{0.0, 0.3}, {right, 0.3}, {0.0, 0.3}});
  CHECK(difference(c.materials.at(0).membrane, l.membrane) < 1e-14);
  CHECK(difference(c.materials.at(0).bending, l.bending) < 1e-14);
  CHECK(c.materials.at(0).areal_density == relative(2 * 0.9));
  const auto message = [](const std::string& angles, const std::string& thicknesses) -> std::string {
    try {
      (void)input::parse_case(case_with(angles, thicknesses), "case.toml");
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  CHECK(energy::couples(input::parse_case(case_with("[0, 90]", "[0.3]"), "case.toml").materials.at(0)));
  CHECK(energy::couples(input::parse_case(case_with("[45, -45]", "[0.3]"), "case.toml").materials.at(0)));
  CHECK(!energy::couples(c.materials.at(0)));
  CHECK(message("[0, 90, 0]", "[0.1, 0.2]").find("2 thicknesses for 3 plies") != std::string::npos);
  CHECK(message("[30, -30, -30, 30]", "[0.1]").empty());
}

}  // namespace test_laminate
