// Continuous collision detection: bounds that are sharp, never later than the contact.
#include <doctest/doctest.h>

#include <random>

#include "contact/contact_set.hpp"
#include "test_relative.hpp"

namespace test_collision {

using namespace voile;
using namespace voile::contact;

namespace {

using Four = std::array<Vec3, 4>;

/// Figures x, whose points move by p, that are hard in one of several ways; 0 and from 8 on as they are.
template <class Vector>
void degenerate(int way, PairKind kind, Four& x, Four& p, const Vector& vector) {
  switch (way) {
    case 1:  // parallel edges, or a point over an edge
      x[1] = kind == PairKind::edge_edge ? Vec3(x[0] + (x[3] - x[2])) : x[1];
      p[1] = p[0];
      p[3] = p[2];
      break;
    case 2:  // everything in one plane
      for (int i = 0; i < 4; ++i) x[i][2] = p[i][2] = 0.0;
      break;
    case 3:  // tiny
      for (int i = 1; i < 4; ++i) x[i] = x[1] + 1e-6 * vector();
      break;
    case 4:  // a sliver
      x[3] = x[2] + 1e-9 * vector();
      break;
    case 5:  // aimed at a corner
      p[0] = 1.5 * (x[1] - x[0]);
      p[1].setZero();
      break;
    case 6:  // aimed at the middle of an edge
      p[0] = 1.5 * (0.5 * (x[2] + x[3]) - x[0]);
      p[2].setZero();
      p[3].setZero();
      break;
    case 7:  // near each other, sliding
      for (int i = 0; i < 4; ++i) p[i] = 0.3 * p[0] + 1e-3 * vector();
      break;
    default:
      break;
  }
}

}  // namespace

TEST_CASE("the distance along an axis is a lower bound, and sharp for figures across it") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  int apart = 0;
  for (int k = 0; k < 30000; ++k) {
    const PairKind kind = std::array{PairKind::point_triangle, PairKind::edge_edge, PairKind::point_edge}[k % 3];
    Four x;
    for (Vec3& v : x) v = Vec3(u(random), u(random), u(random));
    const double bound = axis_distance(kind, x);
    apart += bound > 0.0;
    CHECK(bound <= closest(kind, x).distance);
  }
  CHECK(apart > 3000);
  for (const double sign : {1.0, -1.0})
    for (int axis = 0; axis < 3; ++axis) {
      Four x{Vec3::Zero(), Vec3(-1, -1, -1), Vec3(2, -1, 1),
             Vec3(-1, 2, 0)};  // a point before a triangle, an axis apart
      for (int i = 1; i < 4; ++i) x[i][axis] = sign * 0.7;
      CHECK(axis_distance(PairKind::point_triangle, x) == relative(0.7));
    }
}

TEST_CASE("continuous collision detection is never later than the contact") {
#ifdef NDEBUG
  const int pairs = 1000000, samples = 24;
#else
  const int pairs = 20000, samples = 24;
#endif
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto vector = [&] { return Vec3(u(random), u(random), u(random)); };
  int stopped = 0, late = 0;
  for (int k = 0; k < pairs; ++k) {
    const PairKind kind = k % 2 == 0 ? PairKind::point_triangle : PairKind::edge_edge;
    Four x, p;
    for (int i = 0; i < 4; ++i) {
      x[i] = vector();
      p[i] = 2.0 * vector();
    }
    degenerate(k / 2 % 8, kind, x, p, vector);
    const double gap = closest(kind, x).distance;
    const double xi = k % 3 == 0 ? 0.5 * gap : 0.0;
    if (!(gap > xi + 1e-12)) continue;  // they touch already, but for round-off
    const double fraction = step_fraction(kind, x, p, xi);
    stopped += fraction < 1.0;
    // All the way to the fraction there is a gap left; the sheet has not passed through in between.
    for (int s = 1; s <= samples; ++s) {
      Four at;
      for (int i = 0; i < 4; ++i) at[i] = x[i] + (fraction * s / samples) * p[i];
      late += !(closest(kind, at).distance > xi);
    }
  }
  CHECK(late == 0);
  CHECK(stopped > pairs / 20);
}

TEST_CASE("continuous collision detection stops before the contact and only where little of the gap is left") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  int hits = 0;
  for (int k = 0; k < 2000; ++k) {
    Four x, p;
    for (int i = 0; i < 4; ++i) {
      x[i] = Vec3(u(random), u(random), u(random));
      p[i] = Vec3(u(random), u(random), u(random));
    }
    const auto gap = [&](double t) {
      Four at;
      for (int i = 0; i < 4; ++i) at[i] = x[i] + t * p[i];
      return point_triangle(at).distance - 0.05;
    };
    if (gap(0.0) < 0.2) continue;
    double first = 1.0;
    for (int s = 1; s <= 1000 && first == 1.0; ++s)
      if (gap(s * 1e-3) < 0.0) first = s * 1e-3;
    if (first == 1.0) continue;
    double low = first - 1e-3, high = first;
    for (int s = 0; s < 50; ++s) (gap(0.5 * (low + high)) < 0.0 ? high : low) = 0.5 * (low + high);
    const double fraction = step_fraction(PairKind::point_triangle, x, p, 0.05);
    ++hits;
    CHECK(fraction <= high);
    CHECK(gap(fraction) > 0.0);
    CHECK(gap(fraction) < 0.2 * gap(0.0));
  }
  CHECK(hits > 20);
}

}  // namespace test_collision
