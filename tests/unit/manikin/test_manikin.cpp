// The product's own bodies: girths as asked for, sound surfaces, motions that begin at rest.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "extent.hpp"
#include "geometry/implicit_surface.hpp"
#include "geometry/intersections.hpp"
#include "geometry/winding.hpp"
#include "manikin/figure.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_manikin {

using namespace voile;
using namespace voile::manikin;

namespace {

Measurements body(double height, double bust, double waist, double hip, double inseam, double arms) {
  return {height, bust, waist, hip, inseam, arms};
}

/// Euler's number of a closed surface: 2 per piece, less 2 per handle.
long euler(const geometry::TriangleSoup& s) {
  return static_cast<long>(s.positions.size()) - static_cast<long>(3 * s.triangles.size() / 2) +
         static_cast<long>(s.triangles.size());
}

double least_distance_of_legs(const std::vector<Vec3>& rest, const std::vector<Vec3>& now, double below) {
  double least = 1.0;
  for (std::size_t i = 0; i < rest.size(); ++i)
    for (std::size_t j = 0; j < rest.size(); ++j)
      if (rest[i].x() > 0.0 && rest[j].x() < 0.0 && rest[i].z() < below && rest[j].z() < below)
        least = std::min(least, (now[i] - now[j]).norm());
  return least;
}

const Figure& usual_figure() {
  static const Figure figure = make_figure({}, Kind::figure, 0.05);
  return figure;
}

/// A body takes minutes with sanitizers: no test makes one there.
const doctest::skip skipped(extent(false, true));

}  // namespace

TEST_CASE("an implicit surface: corners on it, closed, outwards") {
  const auto ball = [](const Vec3& p) { return (p - Vec3(0.1, 0.2, 0.3)).norm() - 0.5; };
  const geometry::TriangleSoup s = geometry::implicit_surface(ball, {Vec3(0.1, 0.1, 0.3), 2.0, 0.1, 0.005});
  CHECK(geometry::is_closed(s.triangles));
  CHECK(euler(s) == 2);
  double worst = 0.0, volume = 0.0;
  for (const Vec3& p : s.positions) worst = std::max(worst, std::abs(ball(p)));
  for (const mesh::Triangle& t : s.triangles)
    volume += s.positions[t[0]].dot(s.positions[t[1]].cross(s.positions[t[2]])) / 6.0;
  CHECK(worst < 1e-9);
  CHECK(volume == relative(4.0 / 3.0 * std::numbers::pi * 0.125).epsilon(0.03));
  CHECK_THROWS_AS((void)geometry::implicit_surface(ball, {Vec3(2.0, 0.0, 0.0), 4.0, 0.1, 0.005}), InternalError);
}

TEST_CASE("a tape spans hollows") {
  // A square with a notch.
  CHECK(hull_perimeter({{0, 0}, {1, 0}, {1, 1}, {0.5, 0.2}, {0, 1}}) == relative(4.0).epsilon(1e-14));
}

TEST_CASE("manikins of many measurements are sound, have their girths, and move without intersecting themselves" *
          skipped) {
  const double pi = std::numbers::pi;
  const std::array bodies{body(1.74, 0.88, 0.68, 0.94, 0.80, 0.44), body(1.60, 0.80, 0.60, 0.88, 0.72, pi / 12.0),
                          body(1.70, 1.20, 1.15, 1.25, 0.75, 0.44), usual_measurements(Person::man, 1.80),
                          usual_measurements(Person::child, 0.74),  usual_measurements(Person::child, 1.46)};
  for (const Measurements& m : bodies)
    for (const Kind kind : {Kind::figure, Kind::form}) {
      CAPTURE(m.height);
      const Figure f = make_figure(m, kind, 0.045 * std::min(1.0, m.height / 1.3));
      const geometry::TriangleSoup& s = f.surface;
      const Levels& l = f.shape.levels();
      CHECK(tape_girth(s, l.bust) == relative(m.bust).epsilon(0.003));
      CHECK(tape_girth(s, l.waist) == relative(m.waist).epsilon(0.003));
      CHECK(tape_girth(s, l.hip) == relative(m.hip).epsilon(0.003));
      CHECK(geometry::is_closed(s.triangles));
      CHECK(euler(s) == 2);
      CHECK(geometry::winding_number(Vec3(0.0, 0.0, l.waist), s.positions, s.triangles) == relative(1.0).epsilon(1e-9));
      double low = 1.0, high = 0.0;
      for (const Vec3& p : s.positions) {
        low = std::min(low, p.z());
        high = std::max(high, p.z());
      }
      CHECK(std::abs(low) < 0.01);
      if (kind == Kind::figure) CHECK(high == relative(m.height).epsilon(0.01));
      if (kind == Kind::form) continue;
      for (const Motion motion : {Motion::walk, Motion::turn, Motion::run, Motion::lift, Motion::sit}) {
        CAPTURE(static_cast<int>(motion));
        MotionOptions o = usual_motion(motion, m.inseam);
        o.seconds = 2.0;
        o.frames_per_second = 12.5;
        const auto all = frames(f, o);
        REQUIRE(all.size() == 26);
        double legs = 1.0, feet = 1.0;
        for (const auto& frame : all) {
          CHECK(geometry::intersecting_triangles(frame, s.triangles).empty());
          legs = std::min(legs, least_distance_of_legs(s.positions, frame, m.inseam - 0.05));
          for (const Vec3& p : frame) feet = std::min(feet, p.z());
        }
        CHECK(legs > 0.01);
        CHECK(feet > low - 1e-9);
      }
    }
}

TEST_CASE("a figure walks from standing, without a jerk, and gets along" * skipped) {
  const Figure& f = usual_figure();
  MotionOptions o;
  o.frames_per_second = 200.0;
  o.seconds = 3.0;
  const auto all = frames(f, o);
  double first = 0.0, jump = 0.0, change = 0.0, rest = 0.0;
  for (std::size_t v = 0; v < f.surface.positions.size(); ++v) {
    rest = std::max(rest, (all[0][v] - f.surface.positions[v]).norm());
    first = std::max(first, (all[1][v] - all[0][v]).norm() * 200.0);
    for (std::size_t k = 1; k + 1 < all.size(); ++k)
      change = std::max(change, (all[k + 1][v] - 2.0 * all[k][v] + all[k - 1][v]).norm() * 200.0 * 200.0);
    for (std::size_t k = 0; k + 1 < all.size(); ++k) jump = std::max(jump, (all[k + 1][v] - all[k][v]).norm() * 200.0);
  }
  CHECK(rest < 1e-12);
  CHECK(first < 1e-3);   // [m/s]
  CHECK(jump < 4.0);     // feet [m/s]
  CHECK(change < 80.0);  // [m/s^2]; a velocity that jumps by 1 m/s would be 200
  Vec3 moved = Vec3::Zero();
  for (std::size_t v = 0; v < f.surface.positions.size(); ++v) moved += all.back()[v] - all[0][v];
  moved /= static_cast<double>(f.surface.positions.size());
  CHECK(moved.y() == relative(-(3.0 - 0.4)).epsilon(0.05));
}

TEST_CASE("a figure that turns ends where it was asked to face" * skipped) {
  const Figure& f = usual_figure();
  MotionOptions o;
  o.motion = Motion::turn;
  o.angle = 0.5 * std::numbers::pi;
  const auto all = frames(f, o);
  double worst = 0.0;
  for (std::size_t v = 0; v < f.surface.positions.size(); ++v) {
    const Vec3& x = f.surface.positions[v];
    worst = std::max(worst, (all.back()[v] - Vec3(-x.y(), x.x(), x.z())).norm());
  }
  CHECK(worst < 1e-9);
}

TEST_CASE("a figure sits down on the height of its knees, with its feet where they were" * skipped) {
  const Figure& f = usual_figure();
  const auto all = frames(f, usual_motion(Motion::sit));
  const Joints& j = f.shape.joints();
  double feet = 0.0, fall = 0.0;
  for (std::size_t v = 0; v < f.surface.positions.size(); ++v) {
    const Vec3& x = f.surface.positions[v];
    if (x.z() < 0.02) feet = std::max(feet, (all.back()[v] - x).norm());
    if (x.z() > f.shape.levels().top - 0.05) fall = x.z() - all.back()[v].z();
  }
  CHECK(feet < 1e-9);
  CHECK(fall > 0.8 * (j.hip.z() - j.knee.z()));
  CHECK(fall < j.hip.z() - j.knee.z());
}

TEST_CASE("a figure lifts its left arm alone, to the angle asked for" * skipped) {
  const Figure& f = usual_figure();
  const auto all = frames(f, usual_motion(Motion::lift));
  const Joints& j = f.shape.joints();
  double other = 0.0, highest = 0.0, lowest = 9.0;
  for (std::size_t v = 0; v < f.surface.positions.size(); ++v) {
    const Vec3 &x = f.surface.positions[v], &end = all.back()[v];
    if (x.x() < 0.0) other = std::max(other, (end - x).norm());
    if (end.x() < j.shoulder.x() + 0.20) continue;  // the arm beyond the shoulder is horizontal now
    highest = std::max(highest, end.z());
    lowest = std::min(lowest, end.z());
  }
  CHECK(other < 1e-9);
  CHECK(0.5 * (highest + lowest) == relative(j.shoulder.z()).epsilon(0.01));
  CHECK(highest - lowest < 0.12);
}

TEST_CASE("children have the girths of their height, and their heads") {
  const Measurements small = usual_measurements(Person::child, 0.92), tall = usual_measurements(Person::child, 1.64);
  CHECK(small.bust == relative(0.54).epsilon(1e-12));
  CHECK(tall.hip == relative(0.875).epsilon(1e-12));
  const auto head = [](const Measurements& m) { return (Levels(m).top - Levels(m).chin) / m.height; };
  CHECK(head(small) > 0.19);
  CHECK(head(tall) < 0.13);
}

TEST_CASE("measurements and motions out of bounds are refused by name") {
  const auto message = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  Measurements m;
  m.waist = 68.0;
  CHECK(message([&] { check(m); }).find("waist = 68") != std::string::npos);
  m = {};
  m.inseam = 1.2;
  CHECK(message([&] { check(m); }).find("inseam") != std::string::npos);
  m = {};
  m.arm_angle = 0.0;
  CHECK(message([&] { check(m); }).find("arms") != std::string::npos);
  m = {};
  m.bust = std::nan("");
  CHECK(message([&] { check(m); }).find("bust") != std::string::npos);
  CHECK(message([&] { check(usual_measurements(Person::child, 0.6)); }).find("height of a child") != std::string::npos);
  if (extent(false, true)) return;
  MotionOptions fast = usual_motion(Motion::run);
  fast.speed = 6.0;
  CHECK(message([&] { (void)frames(usual_figure(), fast); }).find("speed = 6") != std::string::npos);
  CHECK(message([&] { (void)make_figure({}, Kind::form, 0.5); }).find("size") != std::string::npos);
}

}  // namespace test_manikin
