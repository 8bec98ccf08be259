// The camera holds all points, as near as it can, and looks from where it is asked to.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../test_case_kit.hpp"
#include "picture/camera.hpp"
#include "voile/errors.hpp"

namespace test_camera {

using namespace voile;
using namespace voile::picture;

TEST_CASE("what the camera must hold fills its frame and stays inside it") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (const char* name : {"three-quarter", "front", "top", "bottom", "35,-10"})
    for (const double aspect : {0.5, 1.0, 1.9}) {
      std::vector<Vec3> points;
      for (int i = 0; i < 200; ++i)
        points.emplace_back(5.0 + 2.0 * number(random), number(random), -3.0 + 0.5 * number(random));
      const Frame frame{0.1, 0.8, 0.2, 0.95};
      const Camera c = fit_camera(named_view(name, Vec3::UnitZ()), Vec3::UnitZ(), points, aspect, frame);
      double left = 1, right = 0, top = 1, bottom = 0;
      for (const Vec3& p : points) {
        const Vec3 at = c.project(p);
        CHECK(at.z() > 0.0);
        left = std::min(left, at.x());
        right = std::max(right, at.x());
        top = std::min(top, at.y());
        bottom = std::max(bottom, at.y());
      }
      CAPTURE(name);
      CHECK(left > frame.left - 1e-9);
      CHECK(right < frame.right + 1e-9);
      CHECK(top > frame.top - 1e-9);
      CHECK(bottom < frame.bottom + 1e-9);
      // One of both directions is full, and what is left of the other is the same on both sides.
      const double slack_x = left - frame.left, slack_y = top - frame.top;
      CHECK(std::min(std::abs(slack_x), std::abs(slack_y)) < 1e-9);
      CHECK(c.right.cross(c.up).dot(c.back) == doctest::Approx(1.0));
    }
}

TEST_CASE("rays go through the places where points are seen") {
  const Camera c =
      fit_camera(named_view("three-quarter", Vec3::UnitZ()), Vec3::UnitZ(), {{0, 0, 0}, {1, 2, 3}}, 1.5, {});
  const Vec3 p(0.3, 0.9, 1.0), at = c.project(p);
  CHECK((c.ray(at.x(), at.y()).normalized() - (p - c.eye).normalized()).norm() < 1e-12);
}

TEST_CASE("named views: the front looks along +y, the right side along -x, for other directions up too") {
  CHECK((named_view("front", Vec3::UnitZ()).back - Vec3(0, -1, 0)).norm() < 1e-12);
  CHECK((named_view("right", Vec3::UnitZ()).back - Vec3(1, 0, 0)).norm() < 1e-12);
  CHECK((named_view("top", Vec3::UnitZ()).back - Vec3(0, 0, 1)).norm() < 1e-12);
  CHECK((named_view("front", Vec3::UnitY()).back - Vec3(0, 0, 1)).norm() < 1e-12);
  CHECK(named_view("90,0", Vec3::UnitZ()).back.y() == doctest::Approx(1.0));
  CHECK_THROWS_AS((void)named_view("frnt", Vec3::UnitZ()), UserError);
  CHECK_THROWS_AS((void)named_view("10,100", Vec3::UnitZ()), UserError);
}

TEST_CASE("a camera can be given, and nothing to look at is no failure") {
  View view;
  view.eye = Vec3(0, 0, 5);
  view.target = Vec3(0, 0, 0);
  const Camera c = fit_camera(view, Vec3::UnitZ(), {{9, 9, 9}}, 1.0, {});
  CHECK(c.eye == Vec3(0, 0, 5));
  CHECK(c.project({0, 0, 0}).x() == doctest::Approx(0.5));
  const Camera empty = fit_camera(named_view("front", Vec3::UnitZ()), Vec3::UnitZ(), {}, 1.0, {});
  CHECK(empty.eye.allFinite());
}

}  // namespace test_camera
