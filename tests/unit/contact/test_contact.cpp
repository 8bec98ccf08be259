// Distances, barrier, friction and their derivatives; continuous collision detection; candidates against brute force.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <random>

#include "base/decompositions.hpp"
#include "contact/contact_set.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"

namespace test_contact {

using namespace voile;
using namespace voile::contact;
using namespace voile::testing;

namespace {

using Four = std::array<Vec3, 4>;

Four points(const Vec12& v) {
  Four x;
  for (int i = 0; i < 4; ++i) x[i] = v.segment<3>(3 * i);
  return x;
}

Vec12 flat(const Four& x) {
  Vec12 v;
  for (int i = 0; i < 4; ++i) v.segment<3>(3 * i) = x[i];
  return v;
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
  const Eigen::VectorXd e = eigenvalues(Eigen::MatrixXd(positive));
  CHECK(e.minCoeff() > -1e-9 * e.maxCoeff());
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

TEST_CASE("distance alone: that of the closest points, of figures anywhere, degenerate and parallel ones too") {
  const auto check = [](PairKind kind, const Four& x) {
    const double wanted = closest(kind, x).distance;
    CHECK(std::abs(distance(kind, x) - wanted) <= 1e-12 * (1.0 + wanted));
  };
  for (const Case& c : cases()) check(c.kind, c.x);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const Vec3 far(30.0, -20.0, 10.0);
  for (int k = 0; k < 3000; ++k) {
    Four x;
    for (Vec3& v : x) v = far + Vec3(place(random), place(random), place(random));
    if (k % 5 == 1) x[3] = x[2] + x[1] - x[0];  // parallel edges
    if (k % 5 == 2) x[3] = x[2];                // an edge, or two corners, in one place
    if (k % 5 == 3) x[3] = 0.5 * (x[1] + x[2]);
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge, PairKind::point_edge}) check(kind, x);
  }
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

}  // namespace test_contact
