// Lengths and areas of outlines against closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "pattern/curve.hpp"

namespace test_curve {

using namespace voile;
using pattern::Curve;
using std::numbers::pi;

namespace {

constexpr double tolerance = 1e-9;  // relative; what is asked for

double relative(double is, double should) {
  return std::abs(is - should) / std::abs(should);
}

/// Perimeter of an ellipse by its series in h = ((a-b)/(a+b))^2, an independent route to the elliptic integral.
double ellipse_perimeter(double a, double b) {
  const double h = std::pow((a - b) / (a + b), 2);
  double sum = 0.0, c = 1.0;  // binomial(1/2, n)
  for (int n = 0; n < 60; ++n) {
    sum += c * c * std::pow(h, n);
    c *= (0.5 - n) / (n + 1);
  }
  return pi * (a + b) * sum;
}

}  // namespace

TEST_CASE("lengths and areas of every kind of curve") {
  const Curve line = Curve::bezier({{1.0, 2.0}, {4.0, 6.0}});
  CHECK(line.length() == doctest::Approx(5.0).epsilon(1e-15));
  CHECK(line.area() == doctest::Approx(0.5 * (1.0 * 6.0 - 2.0 * 4.0)).epsilon(1e-14));
  const Curve parabola = Curve::bezier({{0.0, 0.0}, {0.5, 0.0}, {1.0, 1.0}});  // y = x^2
  CHECK(relative(parabola.length(), std::sqrt(5.0) / 2.0 + std::asinh(2.0) / 4.0) < tolerance);
  CHECK(relative(parabola.area(), 1.0 / 6.0) < tolerance);
  const Curve semicubical = Curve::bezier({{0.0, 0.0}, {0.0, 0.0}, {1.0 / 3.0, 0.0}, {1.0, 1.0}});  // (t^2, t^3)
  CHECK(relative(semicubical.length(), (13.0 * std::sqrt(13.0) - 8.0) / 27.0) < tolerance);
  CHECK(relative(semicubical.area(), 0.1) < tolerance);
  for (const double sweep : {0.3, -2.0, 2.0 * pi}) {
    const Curve arc = Curve::arc({3.0, -1.0}, 2.0 * Mat2::Identity(), 0.4, sweep);
    CHECK(relative(arc.length(), 2.0 * std::abs(sweep)) < tolerance);
    // The sector from the centre, and the triangle of the chord with the origin.
    const Vec2 c(3.0, -1.0), a = arc.start(), b = arc.end();
    const double sector = 0.5 * 4.0 * sweep, rest = 0.5 * (c[0] * (b - a)[1] - c[1] * (b - a)[0]);
    CHECK(relative(arc.area(), sector + rest) < tolerance);
  }
  Mat2 axes;
  axes << 0.3 * std::cos(0.7), -0.05 * std::sin(0.7), 0.3 * std::sin(0.7), 0.05 * std::cos(0.7);
  const Curve ellipse = Curve::arc({1.0, 1.0}, axes, 0.1, 2.0 * pi);
  CHECK(relative(ellipse.length(), ellipse_perimeter(0.3, 0.05)) < tolerance);
  CHECK(relative(ellipse.area(), pi * 0.3 * 0.05) < tolerance);
}

TEST_CASE("a cusp and a curve that goes back on itself keep their length") {
  // x = (t - 1/2)^2 on a line: there and back again.
  const Curve back = Curve::bezier({{0.25, 0.0}, {-0.25, 0.0}, {0.25, 0.0}});
  CHECK(relative(back.length(), 0.5) < 1e-8);
}

TEST_CASE("points at shares of the length") {
  const Curve c = Curve::bezier({{0.0, 0.0}, {0.0, 0.0}, {1.0 / 3.0, 0.0}, {1.0, 1.0}});
  const auto length_to = [](double t) { return (std::pow(4.0 + 9.0 * t * t, 1.5) - 8.0) / 27.0; };
  const std::vector<double> fractions{0.0, 0.01, 0.2, 0.5, 0.77, 1.0};
  const std::vector<double> t = c.parameters_at(fractions);
  for (std::size_t k = 0; k < fractions.size(); ++k)
    CHECK(std::abs(length_to(t[k]) / length_to(1.0) - fractions[k]) < tolerance);
  CHECK(Curve::bezier({{0.0, 0.0}, {2.0, 0.0}}).parameters_at({0.25}).front() == 0.25);
}

TEST_CASE(
    "thousands of nodes on a curve are found as few are: the watchdog ends what halves their intervals for ever") {
  constexpr int nodes = 4000;
  std::vector<double> fractions;
  for (int k = 0; k <= nodes; ++k) fractions.push_back(static_cast<double>(k) / nodes);
  const std::vector<double> of_arc = Curve::circle({0.0, 0.0}, {1.0, 0.0}, 1.0, true, true).parameters_at(fractions);
  for (std::size_t k = 0; k < fractions.size(); ++k) CHECK(std::abs(of_arc[k] - fractions[k]) < tolerance);
  const Curve c = Curve::bezier({{0.0, 0.0}, {1.0 / 3.0, 0.0}, {2.0 / 3.0, 1.0 / 3.0}, {1.0, 1.0}});  // (t, t^2)
  const auto length_to = [](double t) { return 0.25 * (2.0 * t * std::sqrt(1.0 + 4.0 * t * t) + std::asinh(2.0 * t)); };
  const std::vector<double> t = c.parameters_at(fractions);
  for (std::size_t k = 0; k < fractions.size(); ++k)
    CHECK(std::abs(length_to(t[k]) / length_to(1.0) - fractions[k]) < tolerance);
}

TEST_CASE("a circle through two points: four arcs") {
  const Vec2 a(0.0, 0.0), b(1.0, 0.0);
  const double r = 1.0, small = 2.0 * std::asin(0.5), large = 2.0 * pi - small;
  for (const bool is_large : {false, true})
    for (const bool counter : {false, true}) {
      const Curve c = Curve::circle(a, b, r, is_large, counter);
      CHECK((c.start() - a).norm() < 1e-14);
      CHECK((c.end() - b).norm() < 1e-14);
      CHECK(relative(c.length(), is_large ? large : small) < tolerance);
      // Counter-clockwise it bulges to the right of the way from a to b, that is below.
      CHECK((c.at(0.5)[1] < 0.0) == counter);
    }
}

}  // namespace test_curve
