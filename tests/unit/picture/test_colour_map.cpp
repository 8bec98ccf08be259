// Colour maps are uniform to the eye, scales are symmetric for signed numbers, ticks are round.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "picture/colour_map.hpp"

namespace test_colour_map {

using namespace voile;
using namespace voile::picture;

namespace {

/// Differences as seen between neighbouring entries: smallest over largest.
double uniformity(const ColourMap& map) {
  double least = 1e9, most = 0.0;
  for (int i = 0; i < 64; ++i) {
    const double d = (to_oklab(map(static_cast<float>(i + 1) / 64)) - to_oklab(map(static_cast<float>(i) / 64))).norm();
    least = std::min(least, d);
    most = std::max(most, d);
  }
  return least / most;
}

}  // namespace

TEST_CASE("colours go to OKLab and back, and to bytes and back") {
  for (const Bytes3 bytes : {Bytes3{0, 0, 0}, {255, 255, 255}, {12, 200, 99}, {255, 0, 0}}) {
    CHECK(to_bytes(from_bytes(bytes)) == bytes);
    CHECK((from_oklab(to_oklab(from_bytes(bytes))) - from_bytes(bytes)).norm() < 1e-4F);
  }
  CHECK(std::abs(to_oklab(Rgb(1, 1, 1))[0] - 1.0F) < 1e-4F);
}

TEST_CASE("equal steps of a number are equal steps to the eye") {
  CHECK(uniformity(ColourMap::sequential()) > 0.85);
  CHECK(uniformity(ColourMap::diverging()) > 0.8);
}

TEST_CASE("the sequential map becomes lighter all the way, the diverging one is lightest in the middle") {
  const ColourMap s = ColourMap::sequential(), d = ColourMap::diverging();
  for (int i = 0; i < 100; ++i) {
    const float a = static_cast<float>(i) / 100, b = static_cast<float>(i + 1) / 100;
    CHECK(to_oklab(s(b))[0] > to_oklab(s(a))[0]);
    if (b <= 0.5F) CHECK(to_oklab(d(b))[0] > to_oklab(d(a))[0]);
    CHECK(std::abs(to_oklab(d(a))[0] - to_oklab(d(1.0F - a))[0]) < 0.03F);
  }
  CHECK(s(-1.0F) == s(0.0F));
  CHECK(s(2.0F) == s(1.0F));
  CHECK(s(std::numeric_limits<float>::quiet_NaN()) != s(0.0F));
}

TEST_CASE("signed numbers have a scale symmetric about zero") {
  const ColourScale s = make_scale(-1.0, 3.0);
  CHECK(s.low == -3.0);
  CHECK(s.place(0.0) == doctest::Approx(0.5));
  const ColourScale positive = make_scale(-1e-9, 3.0);
  CHECK(positive.low == -1e-9);
  CHECK(make_scale(2.0, 2.0).place(2.0) == 0.0F);
}

TEST_CASE("ticks are round numbers inside the range") {
  CHECK(ticks(1.0, 1.0000000000000002, 6).size() == 1);
  const auto t = ticks(-0.013, 0.021, 6);
  REQUIRE(t.size() == 7);
  CHECK(t.front().first == doctest::Approx(-0.01));
  CHECK(t.front().second == "-0.010");
  CHECK(t[2].second == "0.000");
  CHECK(ticks(0.0, 5e6, 5)[1].second == "1e+06");
  CHECK(ticks(1.0, 1.0, 5).size() == 1);
  const auto near = ticks(-4.905e-6, -4.901e-6, 4);
  REQUIRE(near.size() > 2);
  CHECK(near[0].second == "-4.905e-06");
  CHECK(near[0].second != near[1].second);
}

}  // namespace test_colour_map
