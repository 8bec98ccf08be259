// Distances, barrier, friction and their derivatives; continuous collision detection; candidates against brute force.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <random>

#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "voile/contact/contact_set.hpp"

using namespace voile;
using namespace voile::contact;
using namespace voile::testing;

namespace {

using Four = std::array<Vec3, 4>;

Vec12 flat(const Four& x) {
  Vec12 v;
  for (int i = 0; i < 4; ++i) v.segment<3>(3 * i) = x[i];
  return v;
}

Four points(const Vec12& v) {
  Four x;
  for (int i = 0; i < 4; ++i) x[i] = v.segment<3>(3 * i);
  return x;
}

/// One pair in every case of its closest points.
struct Case {
  const char* name;
  PairKind kind;
  Four x;
  int free;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"over the face", PairKind::point_triangle, {Vec3(0.2, 0.25, 0.4), {0, 0, 0}, {1, 0.1, 0}, {0.1, 1, 0.2}}, 2},
      {"beside an edge", PairKind::point_triangle, {Vec3(0.5, -0.4, 0.3), {0, 0, 0}, {1, 0.1, 0}, {0.1, 1, 0.2}}, 1},
      {"beside the second edge", PairKind::point_triangle, {Vec3(0.9, 0.9, 0.3), {0, 0, 0}, {1, 0, 0}, {0, 1, 0.1}}, 1},
      {"beside the third edge", PairKind::point_triangle, {Vec3(-0.4, 0.5, 0.3), {0, 0, 0}, {1, 0, 0}, {0, 1, 0.1}}, 1},
      {"at a corner", PairKind::point_triangle, {Vec3(-0.3, -0.4, 0.3), {0, 0, 0}, {1, 0.1, 0}, {0.1, 1, 0.2}}, 0},
      {"crossing edges", PairKind::edge_edge, {Vec3(-0.5, 0, 0.3), {0.6, 0.1, 0.2}, {0, -0.6, 0}, {0.1, 0.7, 0}}, 2},
      {"end of the first", PairKind::edge_edge, {Vec3(0.3, 0, 0.3), {1.6, 0.1, 0.5}, {0, -0.6, 0}, {0.1, 0.7, 0}}, 1},
      {"end of the second", PairKind::edge_edge, {Vec3(-0.5, 0, 0.3), {0.6, 0.1, 0.2}, {0, 0.4, 0}, {0.1, 1.7, 0}}, 1},
      {"two ends", PairKind::edge_edge, {Vec3(0.5, 0, 0.3), {1.6, 0.1, 0.2}, {0, 0.4, 0}, {-0.4, 1.7, 0}}, 0},
      {"inside the edge", PairKind::point_edge, {Vec3(0.2, 0.5, 0.4), {0, 0, 0}, {1, 0.1, 0}, Vec3::Zero()}, 1},
      {"beyond the edge", PairKind::point_edge, {Vec3(1.7, 0.5, 0.4), {0, 0, 0}, {1, 0.1, 0}, Vec3::Zero()}, 0}};
  return all;
}

Vec12 distance_gradient(PairKind kind, const Four& x) {
  const Closest r = closest(kind, x);
  Vec12 g;
  for (int i = 0; i < 4; ++i) g.segment<3>(3 * i) = r.c[i] * r.w / r.distance;
  return g;
}

/// Central differences of a scalar and of a vector function of twelve coordinates.
template <class F>
Vec12 gradient_of(const F& f, const Vec12& x, double h) {
  Vec12 g;
  for (int k = 0; k < 12; ++k) g[k] = (f(x + h * Vec12::Unit(k)) - f(x - h * Vec12::Unit(k))) / (2.0 * h);
  return g;
}
template <class F>
Mat12 hessian_of(const F& gradient, const Vec12& x, double h) {
  Mat12 m;
  for (int k = 0; k < 12; ++k)
    m.col(k) = (gradient(x + h * Vec12::Unit(k)) - gradient(x - h * Vec12::Unit(k))) / (2.0 * h);
  return m;
}

Mat12 expand(const Mat5& h, const Motions& m) {
  Eigen::Matrix<double, 12, 5> q;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 5; ++k) q.block<3, 1>(3 * i, k) = m.weight[k][i] * m.frame[k];
  return q * h * q.transpose();
}

/// Two triangles of a sheet, not connected, or one above an obstacle's.
Surface two_triangles(const std::array<Vec3, 6>& x, bool obstacle) {
  mesh::MeshData d;
  d.source = "two triangles";
  d.positions.assign(x.begin(), x.begin() + (obstacle ? 3 : 6));
  d.triangles = {{0, 1, 2}};
  if (!obstacle) d.triangles.push_back({3, 4, 5});
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.1}, {"thing", 0.2}}, {});
  for (auto& row : s.rules)
    for (Rule& r : row) r.friction = 0.3;
  if (obstacle) append(s, 1, {x[3], x[4], x[5]}, {{0, 1, 2}}, {});
  return s;
}

ContactSet contact_of(const std::array<Vec3, 6>& x, bool obstacle) {
  Surface s = two_triangles(x, obstacle);
  const std::vector<char> owned(static_cast<std::size_t>(s.sheet_points), 1);
  ContactSet set(std::move(s), {{0, Vec3(0.1, 0.2, 1.0).normalized(), -0.35}}, {0.4, 7.0, 1e-3}, owned);
  return set;
}

struct OnPlate {
  ContactSet set;
  std::vector<Vec3> at;
  double force;  ///< by which the triangle is pressed off
};

/// A triangle above a large one, with friction 0.3.
OnPlate triangle_on_plate() {
  const std::array<Vec3, 6> x{Vec3(0.1, 0.1, 0.3), {0.6, 0.1, 0.3}, {0.1, 0.6, 0.3},
                              {-1, -1, 0},         {3, -1, 0},      {-1, 3, 0}};
  OnPlate r{contact_of(x, true), {x.begin(), x.end()}, 0.0};
  std::vector<Vec3> f(6, Vec3::Zero());
  r.set.planes().clear();
  (void)r.set.cover(r.at, r.at);
  r.set.add_gradient(r.at, f, ContactSet::normal);
  r.force = -(f[0] + f[1] + f[2])[2];
  REQUIRE(r.force > 0.0);
  return r;
}

void check_derivatives(ContactSet& set, std::vector<Vec3> x, Index sheet) {
  (void)set.cover(x, x);
  std::vector<Vec3> f(x.size(), Vec3::Zero());
  set.add_gradient(x, f);
  double size = 0.0;
  for (const Vec3& v : f) size = std::max(size, v.norm());
  REQUIRE(size > 0.0);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3 * sheet, 3 * sheet), positive = h;
  set.hessian(x, false, [&](Index a, Index b, const Mat3& k) { h.block<3, 3>(3 * a, 3 * b) += k; });
  set.hessian(x, true, [&](Index a, Index b, const Mat3& k) { positive.block<3, 3>(3 * a, 3 * b) += k; });
  const double step = 1e-6;
  for (Index i = 0; i < 3 * sheet; ++i) {
    std::vector<Vec3> lower(x.size(), Vec3::Zero()), upper = lower;
    double e[2];
    for (int s = 0; s < 2; ++s) {
      x[i / 3][i % 3] += s == 0 ? -step : 2.0 * step;
      e[s] = set.energy(x);
      set.add_gradient(x, s == 0 ? lower : upper);
    }
    x[i / 3][i % 3] -= step;
    CHECK((e[1] - e[0]) / (2.0 * step) == relative(f[i / 3][i % 3]).epsilon(1e-6).scale(size));
    for (Index j = 0; j < 3 * sheet; ++j)
      CHECK((upper[j / 3][j % 3] - lower[j / 3][j % 3]) / (2.0 * step) ==
            relative(h(j, i)).epsilon(1e-6).scale(h.cwiseAbs().maxCoeff()));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(positive);
  CHECK(eigen.eigenvalues().minCoeff() > -1e-9 * eigen.eigenvalues().maxCoeff());
}

}  // namespace

TEST_CASE("distance: first and second derivatives in every case of the closest points") {
  for (const Case& c : cases()) {
    CAPTURE(c.name);
    const Closest r = closest(c.kind, c.x);
    REQUIRE(r.free == c.free);
    const auto d = [&](const Vec12& x) { return closest(c.kind, points(x)).distance; };
    const auto g = [&](const Vec12& x) { return distance_gradient(c.kind, points(x)); };
    CHECK((gradient_of(d, flat(c.x), 1e-6) - g(flat(c.x))).norm() < 1e-8);
    Motions m;
    const Mat12 h = expand(distance_hessian(c.x, r, m), m);
    CHECK((hessian_of(g, flat(c.x), 1e-6) - h).norm() < 1e-7 * (1.0 + h.norm()));
  }
}

TEST_CASE("distance: closest points of degenerate and parallel figures") {
  CHECK(point_triangle({Vec3(0, 0, 1), {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}).distance == relative(1.0));
  CHECK(point_triangle({Vec3(0.5, 1, 0), {0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).distance == relative(1.0));
  CHECK(edge_edge({Vec3(0, 0, 1), {1, 0, 1}, {0.2, 0, 0}, {0.8, 0, 0}}).distance == relative(1.0));
  CHECK(edge_edge({Vec3(0, 0, 1), {1, 0, 1}, {2, 0, 0}, {3, 0, 0}}).distance == relative(std::sqrt(2.0)));
  CHECK(edge_edge({Vec3(0, 0, 1), {0, 0, 1}, {0, 0, 0}, {0, 0, 0}}).distance == relative(1.0));
}

TEST_CASE("barrier and mollifier: derivatives, and where they begin") {
  const double h = 1e-6;
  for (const double g : {0.05, 0.3, 0.7, 0.99}) {
    const Scalar2 b = barrier(g, 1.0), up = barrier(g + h, 1.0), down = barrier(g - h, 1.0);
    CHECK((up.value - down.value) / (2 * h) == relative(b.first).epsilon(1e-6));
    CHECK((up.first - down.first) / (2 * h) == relative(b.second).epsilon(1e-6));
    CHECK(b.first < 0.0);
    CHECK(b.second > 0.0);
  }
  CHECK(barrier(0.5, 1.0).first == relative(-1.19).epsilon(0.01));
  CHECK(barrier(1.0, 1.0).value == 0.0);
  CHECK(std::isinf(barrier(0.0, 1.0).value));
  const Four x{Vec3(0, 0, 0), {1, 0.2, 0.1}, {0.3, -1, 0.4}, {0.5, 1.1, 0.6}};
  Vec12 g;
  Mat12 k;
  (void)cross_squared(x, &g, &k);
  const auto value = [](const Vec12& v) { return cross_squared(points(v)); };
  const auto slope = [](const Vec12& v) {
    Vec12 d;
    (void)cross_squared(points(v), &d);
    return d;
  };
  CHECK((gradient_of(value, flat(x), 1e-6) - g).norm() < 1e-8 * g.norm());
  CHECK((hessian_of(slope, flat(x), 1e-6) - k).norm() < 1e-8 * k.norm());
  for (const double at : {0.2, 0.9, 1.5}) {
    const Scalar2 m = mollifier(at, 1.0);
    CHECK((mollifier(at + h, 1.0).value - mollifier(at - h, 1.0).value) / (2 * h) == relative(m.first).scale(1.0));
    CHECK((mollifier(at + h, 1.0).first - mollifier(at - h, 1.0).first) / (2 * h) == relative(m.second).scale(1.0));
  }
}

TEST_CASE("contact energy: gradient and Hessian against differences, with planes, mollifier and friction") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-0.3, 0.3);
  for (int k = 0; k < 40; ++k) {
    CAPTURE(k);
    std::array<Vec3, 6> x{Vec3(0, 0, 0),        {1, 0, 0},       {0.2, 1, 0},
                          Vec3(0.1, 0.1, 0.35), {1.1, 0.2, 0.4}, {0.3, 1.1, 0.42}};
    if (k % 2 == 1)  // edges within a degree of each other: the mollifier acts
      for (int i = 0; i < 3; ++i) x[i + 3] = x[i] + Vec3(0.3, 0.2, 0.4) + 0.01 * Vec3(u(random), u(random), u(random));
    else
      for (Vec3& p : x) p += 0.4 * Vec3(u(random), u(random), 0.3 * u(random));
    ContactSet set = contact_of(x, k % 4 >= 2);
    std::vector<Vec3> at(x.begin(), x.end());
    (void)set.cover(at, at);
    if (!std::isfinite(set.energy(at))) continue;
    check_derivatives(set, at, set.surface().sheet_points);
    // Friction from here, a little and a lot of slip away.
    for (const double move : {0.002, 0.05}) {
      set.lag_friction(at, at, 0.01);
      std::vector<Vec3> moved = at;
      for (Index i = 0; i < set.surface().sheet_points; ++i)
        moved[i] += move * Vec3(u(random), u(random), 0.1 * u(random));
      if (std::isfinite(set.energy(moved))) check_derivatives(set, moved, set.surface().sheet_points);
    }
  }
}

TEST_CASE("the barrier of two crossing edges counts for an eighth of the product of their lengths") {
  // Two long triangles whose longest sides cross at a distance; everything else is far apart.
  mesh::MeshData data;
  data.source = "crossed";
  data.positions = {Vec3(-1, 0, 0),      Vec3(1, 0, 0),      Vec3(0, 0.5, -2),
                    Vec3(0, -1.5, 0.05), Vec3(0, 1.5, 0.05), Vec3(0.5, 0, 2)};
  data.triangles = {{0, 1, 2}, {3, 4, 5}};
  const mesh::SurfaceMesh mesh(data);
  const double distance = 0.1, stiffness = 7.0;
  ContactSet set(make_surface(mesh, {{"sheet", 0.0}}, {}), {}, {distance, stiffness, 1e-3}, std::vector<char>(6, 1));
  const std::vector<Vec3>& x = data.positions;
  (void)set.cover(x, x);
  CHECK(set.energy(x) == relative(stiffness * 2.0 * 3.0 / 8.0 * barrier(0.05, distance).value).epsilon(1e-12));
}

TEST_CASE("friction: Coulomb's force beyond the slip, none at rest, opposed to the motion") {
  auto [set, at, normal] = triangle_on_plate();
  set.lag_friction(at, at, 1e-3);
  for (int i = 0; i < 3; ++i) at[i] += Vec3(0.01, 0.0, 0.0);
  std::vector<Vec3> f(6, Vec3::Zero());
  set.add_gradient(at, f, ContactSet::friction);
  const Vec3 total = f[0] + f[1] + f[2];
  CHECK(total[0] == relative(0.3 * normal));
  CHECK(std::abs(total[1]) < 1e-12 * normal);
}

TEST_CASE("friction: the secant where a slip has changed much since the last tangent, else the second derivative") {
  OnPlate plate = triangle_on_plate();
  ContactSet& set = plate.set;
  const std::vector<Vec3>& at = plate.at;
  const double force = 0.3 * plate.force, e = 1e-3;
  // Against a translation of the sheet along and across its slip.
  const auto stiffness = [&](double slip) {
    std::vector<Vec3> moved = at;
    for (int i = 0; i < 3; ++i) moved[i][0] += slip;
    set.follow_slips(moved);
    Mat3 sum = Mat3::Zero();
    set.hessian(moved, true, [&](Index, Index, const Mat3& k) { sum += k; });
    return Vec2(sum(0, 0), sum(1, 1));
  };
  const Vec2 normal = stiffness(0.0);  // edges that are nearly parallel
  const auto check = [&](double slip, double along, double across) {
    CAPTURE(slip);
    const Vec2 k = (stiffness(slip) - normal) / force;
    CHECK(k[0] == relative(along).scale(1.0 / e));
    CHECK(k[1] == relative(across).scale(1.0 / e));
  };
  set.lag_friction(at, at, e);
  check(0.5 * e, 1.0 / e, 1.5 / e);  // the first tangent of a step trusts the first guess
  check(10.0 * e, 0.1 / e, 0.1 / e);
  check(10.0 * e, 0.1 / e, 0.1 / e);  // assembled again at the same place
  check(12.5 * e, 0.0, 0.08 / e);
  check(0.8 * e, 1.2 / e, 1.2 / e);
  check(0.5 * e, 1.0 / e, 1.5 / e);
  set.lag_friction(at, at, e);
  check(10.0 * e, 0.0, 0.1 / e);
}

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
    switch (k / 2 % 8) {
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
    const double gap = closest(kind, x).distance;
    const double xi = k % 3 == 0 ? 0.5 * gap : 0.0;
    if (!(gap > xi + 1e-12)) continue;  // they touch already, but for round-off
    const double share = step_fraction(kind, x, p, xi);
    stopped += share < 1.0;
    // All the way to the share there is a gap left; the sheet has not passed through in between.
    for (int s = 1; s <= samples; ++s) {
      Four at;
      for (int i = 0; i < 4; ++i) at[i] = x[i] + (share * s / samples) * p[i];
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
    const double share = step_fraction(PairKind::point_triangle, x, p, 0.05);
    ++hits;
    CHECK(share <= high);
    CHECK(gap(share) > 0.0);
    CHECK(gap(share) < 0.2 * gap(0.0));
  }
  CHECK(hits > 20);
}

TEST_CASE("candidates: the grid finds what brute force finds, on any division over ranks") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  mesh::MeshData d = grid(9, 7, true, 0.2);
  for (Vec3& x : d.positions) x[2] = 0.3 * std::sin(9.0 * x[0]);
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.01}, {"ball", 0.5}, {"rod", 0.1}, {"floor", 0.02}}, {});
  append(s, 1, {Vec3(0.5, 0.5, 0.6)}, {}, {});
  append(s, 2, {Vec3(-0.2, 0.2, 0.2), Vec3(1.2, 0.9, 0.3)}, {}, {{0, 1}});
  append(s, 3, {Vec3(-5, -5, -0.3), Vec3(7, -5, -0.3), Vec3(0, 9, -0.3), Vec3(0.3, 0.3, -0.2)}, {{0, 1, 2}, {1, 2, 3}},
         {});
  std::vector<Box> boxes(static_cast<std::size_t>(s.points()));
  for (Index i = 0; i < s.points(); ++i) {
    boxes[i].include(s.rest[i]);
    boxes[i].include(s.rest[i] + 0.2 * Vec3(u(random), u(random), u(random)));
  }
  std::vector<Pair> together;
  for (int part = 0; part < 3; ++part) {
    std::vector<char> owned(static_cast<std::size_t>(s.sheet_points));
    for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = static_cast<int>(i) % 3 == part;
    const std::vector<Pair> fast = find_pairs(s, all_figures(s), boxes, owned, 0.05),
                            slow = find_pairs_by_force(s, boxes, owned, 0.05);
    REQUIRE(fast.size() == slow.size());
    REQUIRE(fast.size() > 100);
    for (std::size_t i = 0; i < fast.size(); ++i) {
      CHECK(fast[i].points == slow[i].points);
      CHECK(fast[i].kind == slow[i].kind);
    }
    together.insert(together.end(), fast.begin(), fast.end());
  }
  std::sort(together.begin(), together.end());
  together.erase(std::unique(together.begin(), together.end(),
                             [](const Pair& a, const Pair& b) { return a.points == b.points && a.kind == b.kind; }),
                 together.end());
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const std::vector<Pair> one = find_pairs(s, all_figures(s), boxes, all, 0.05);
  REQUIRE(one.size() == together.size());
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(one[i].points == together[i].points);
  // Only those of some points: of the sheet, of an obstacle, of all kinds.
  for (const double share : {0.0, 0.02, 0.3, 0.9}) {
    CAPTURE(share);
    std::vector<char> asked(boxes.size());
    for (char& a : asked) a = u(random) < share;
    std::vector<Pair> wanted = one;
    std::erase_if(wanted, [&](const Pair& p) {
      return std::none_of(p.points.begin(), p.points.end(), [&](Index i) { return i != no_index && asked[i]; });
    });
    const std::vector<Pair> some = find_pairs(s, all_figures(s), boxes, all, 0.05, asked);
    REQUIRE(some.size() == wanted.size());
    for (std::size_t i = 0; i < some.size(); ++i) CHECK(some[i].points == wanted[i].points);
  }
}

TEST_CASE("candidates kept over many small moves are those found at once") {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  mesh::MeshData d = grid(9, 7, true, 0.2);
  const mesh::SurfaceMesh mesh(d);
  const auto make = [&] {
    Surface s = make_surface(mesh, {{"sheet", 0.0}, {"ball", 0.2}, {"plate", 0.0}}, {});
    append(s, 1, {Vec3(0.5, 0.5, 0.3)}, {}, {});
    append(s, 2, {Vec3(-1, -1, -0.1), Vec3(3, -1, -0.1), Vec3(0, 3, -0.1)}, {{0, 1, 2}}, {});
    const std::vector<char> owned(static_cast<std::size_t>(s.sheet_points), 1);
    return ContactSet(std::move(s), {}, {0.02, 1e3, 1e-3}, owned);
  };
  ContactSet kept = make();
  std::vector<Vec3> x = kept.surface().rest;
  int found = 0;
  long contacts = 0;
  for (int k = 0; k < 60; ++k) {
    CAPTURE(k);
    std::vector<Vec3> to = x;
    // In turns a few points go far, all go a little, and all go far: into boxes and out of them.
    for (Vec3& p : to)
      p += (k % 3 == 0   ? (u(random) > 0.9 ? 0.1 : 0.0)
            : k % 3 == 1 ? 0.005
                         : 0.06) *
           Vec3(u(random), u(random), u(random));
    found += kept.cover(x, to);
    ContactSet fresh = make();
    (void)fresh.cover(to, to);
    const ContactState a = kept.state(to), b = fresh.state(to);
    CHECK(a.pairs == b.pairs);
    CHECK(a.gap == b.gap);
    contacts += b.pairs;
    x = std::move(to);
  }
  CHECK(found > 30);
  CHECK(contacts > 1000);
}

TEST_CASE("on long ways only what comes near at the same time is a candidate, and all of that") {
  // Two sheets that fly along together by twenty cells and meet on the way.
  mesh::MeshData d = grid(9, 7, true, 0.2);
  const auto half = static_cast<Index>(d.positions.size());
  const std::size_t count = d.triangles.size();
  for (Index v = 0; v < half; ++v) d.positions.push_back(d.positions[v] + Vec3(0.02, 0.03, 0.4));
  for (std::size_t t = 0; t < count; ++t) {
    const auto [a, b, c] = d.triangles[t];
    d.triangles.push_back({a + half, b + half, c + half});
  }
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.01}, {"plate", 0.0}}, {});
  append(s, 1, {Vec3(-9, -9, -0.3), Vec3(30, -9, -0.3), Vec3(0, 30, -0.3)}, {{0, 1, 2}}, {});
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const std::vector<Vec3> x = s.rest;
  for (const double meet : {0.35, 0.45}) {  // near misses, and through each other
    CAPTURE(meet);
    std::vector<Vec3> to = x;
    for (Index v = 0; v < s.sheet_points; ++v) to[v] += Vec3(3.0, 0.5, v < half ? 0.1 : 0.1 - meet);
    std::vector<Box> boxes(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      boxes[i].include(x[i]);
      boxes[i].include(to[i]);
    }
    double wanted = 1.0;
    const std::vector<Pair> slow = find_pairs_by_force(s, boxes, all, 0.02);
    for (const Pair& pair : slow) {
      std::array<Vec3, 4> at, way;
      for (int i = 0; i < 4; ++i) {
        at[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : x[pair.points[i]];
        way[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : Vec3(to[pair.points[i]] - at[i]);
      }
      wanted = contact::step_fraction(pair.kind, at, way, s.offset(pair.body_a, pair.body_b), wanted);
    }
    ContactSet set(s, {}, {0.02, 1e3, 1e-3}, all);
    CHECK(set.cover(x, to));
    CHECK(set.step_fraction(x, to) == relative(wanted).epsilon(1e-12));
    CHECK((wanted < 1.0) == (meet > 0.4));
    CHECK(set.candidates().pairs().size() < slow.size() / 4);
    // Afterwards they hold around a place again.
    CHECK(set.cover(to, to));
    CHECK_FALSE(set.cover(to, to));
    ContactSet fresh(s, {}, {0.02, 1e3, 1e-3}, all);
    (void)fresh.cover(to, to);
    CHECK(set.state(to).pairs == fresh.state(to).pairs);
  }
}

TEST_CASE("the list of near pairs misses none, wherever points go within its reach") {
  std::mt19937 random(29);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  mesh::MeshData d = grid(9, 7, true, 0.2);
  for (Vec3& x : d.positions) x[2] = 0.2 * std::sin(9.0 * x[0]);
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.01}, {"rod", 0.1}}, {});
  append(s, 1, {Vec3(-0.2, 0.2, 0.2), Vec3(1.2, 0.9, 0.3)}, {}, {{0, 1}});
  std::vector<Box> boxes(static_cast<std::size_t>(s.points()));
  for (Index i = 0; i < s.points(); ++i) boxes[i].include(s.rest[i]);
  for (Box& b : boxes) b.include(Box{b.low.array() - 0.2, b.high.array() + 0.2});
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const std::vector<Pair> pairs = find_pairs(s, all_figures(s), boxes, all, 0.05);
  const auto offset = [&](const Pair& p) { return p.share * s.offset(p.body_a, p.body_b); };
  const auto gap = [&](const Pair& p, const std::vector<Vec3>& x) {
    std::array<Vec3, 4> at;
    for (int i = 0; i < 4; ++i) at[i] = p.points[i] == no_index ? Vec3(Vec3::Zero()) : x[p.points[i]];
    return closest(p.kind, at).distance - offset(p);
  };
  NearList list;
  CHECK_FALSE(list.made());
  list.make(pairs, s.rest, 0.15, offset);
  long near = 0, listed = 0;
  for (int k = 0; k < 20; ++k) {
    CAPTURE(k);
    const double size = k % 2 == 0 ? 0.03 : 0.01;
    std::vector<Vec3> x = s.rest;
    for (Vec3& p : x) p += size * Vec3(u(random), u(random), u(random)).normalized();
    NearList::Moves moved;
    list.measure(all_figures(s).points, x, moved);
    REQUIRE(list.holds(moved, 0.15 - 2.01 * size));
    CHECK_FALSE(list.holds(moved, 0.15 - 1.99 * size));
    const double limit = 0.08;
    std::vector<const Pair*> given;
    list.for_each(pairs, moved, limit, [&](const Pair& p) { given.push_back(&p); });
    CHECK(std::is_sorted(given.begin(), given.end()));
    for (const Pair& p : pairs)
      if (gap(p, x) < limit) {
        CHECK(std::binary_search(given.begin(), given.end(), &p));
        ++near;
      }
    listed += static_cast<long>(given.size());
  }
  CHECK(near > 1000);
  CHECK(listed < static_cast<long>(20 * pairs.size()) / 2);  // and leaves out most
  list.forget();
  CHECK_FALSE(list.made());
}
