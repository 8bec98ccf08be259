// Fields from mesh to mesh, momentum, and wanted sizes.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>

#include "adapt/transfer.hpp"
#include "test_adapt_kit.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_adapt_transfer {

using namespace voile;
using namespace voile::testing;
using adapt::Interpolation;

namespace {

constexpr double pi = std::numbers::pi;

std::vector<double> lumped(const mesh::SurfaceMesh& m) {
  std::vector<double> mass(static_cast<std::size_t>(m.vertex_count()), 0.0);
  for (Index t = 0; t < m.triangle_count(); ++t)
    for (Index v : m.triangles()[t]) mass[v] += m.area(t) / 3.0;
  return mass;
}

Vec3 quadratic(const Vec3& x) {
  return {1 + x[0] - 2 * x[1] + x[0] * x[0] - x[0] * x[1], 0.5 * x[1] * x[1] - x[0], 3 * x[0] * x[1] + x[1] - 2};
}

std::vector<Vec3> field_of(const mesh::SurfaceMesh& m, const std::function<Vec3(const Vec3&)>& f) {
  std::vector<Vec3> values;
  for (const Vec3& x : m.positions()) values.push_back(f(x));
  return values;
}

double largest_error(const std::vector<Vec3>& values, const mesh::MeshData& at,
                     const std::function<Vec3(const Vec3&)>& f) {
  double worst = 0.0;
  for (std::size_t v = 0; v < values.size(); ++v) worst = std::max(worst, (values[v] - f(at.positions[v])).norm());
  return worst;
}

double kinetic(const std::vector<double>& mass, const std::vector<Vec3>& v) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) sum += 0.5 * mass[i] * v[i].squaredNorm();
  return sum;
}

}  // namespace

TEST_CASE("transfer: quadratic fields exactly, linear ones by the linear interpolant, kept vertices bit by bit") {
  for (const Pattern p : {Pattern::jittered, Pattern::gmsh, Pattern::diagonal, Pattern::union_jack}) {
    const mesh::SurfaceMesh m(square(p, 9));
    const RestSurface rest(m);
    const Remeshed r = remeshed(m, rest, sizes(m, [](const Vec3& x) { return 0.03 + 0.15 * x[1]; }));
    const auto field = field_of(m, quadratic);
    for (const Interpolation kind : {Interpolation::smooth, Interpolation::smoother}) {
      const auto values = adapt::transfer(m, r, field, kind);
      CAPTURE(name_of(p));
      CHECK(largest_error(values, r.mesh, quadratic) < 1e-10);
      for (std::size_t v = 0; v < values.size(); ++v)
        if (r.kept[v] != no_index) CHECK(values[v] == field[r.kept[v]]);
    }
    CHECK(largest_error(adapt::transfer(m, r, field, Interpolation::linear), r.mesh, quadratic) > 1e-4);
    const auto linear = [](const Vec3& x) { return Vec3(x[0] - 2 * x[1], 3, 1 + x[1]); };
    CHECK(largest_error(adapt::transfer(m, r, field_of(m, linear), Interpolation::linear), r.mesh, linear) < 1e-13);
  }
}

TEST_CASE("a velocity that jumps makes no peaks at new vertices, and quadratics are not touched") {
  const mesh::SurfaceMesh m(square(Pattern::gmsh, 9));
  const RestSurface rest(m);
  const Remeshed r = remeshed(m, rest, sizes(m, [](const Vec3&) { return 0.04; }));
  const auto hit = [](const Vec3& x) { return Vec3(0, 0, x[0] < 0.5 ? -4.0 : 0.0); };
  const auto field = field_of(m, hit);
  const auto beyond = [&](Interpolation kind) {
    double most = 0.0;
    for (const Vec3& v : adapt::transfer(m, r, field, kind)) most = std::max({most, v[2], -4.0 - v[2]});
    return most;
  };
  CHECK(r.mesh.positions.size() > 2 * field.size());
  // By at most a quarter of the differences around it, where cubics alone overshoot by more.
  CHECK(beyond(Interpolation::smoother) <= 1.0);
  CHECK(beyond(Interpolation::smoother) > 0.0);
  // Velocities without any course: linearly, give or take a quarter of what differs.
  const auto rough = noise(1.0, 7);
  std::vector<Vec3> speeds;
  for (Index i = 0; i < m.vertex_count(); ++i) speeds.push_back(rough(i));
  const auto linear = adapt::transfer(m, r, speeds, Interpolation::linear),
             v = adapt::transfer(m, r, speeds, Interpolation::smoother);
  double worst = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) worst = std::max(worst, (v[i] - linear[i]).norm());
  CHECK(worst <= 0.25 * 2.0 * std::sqrt(3.0));
  CHECK(worst > 0.1);
}

TEST_CASE("transfer is exact across seams of charts that are turned and shifted") {
  mesh::MeshData d = square(Pattern::jittered, 8);
  const Mat3 turn = Eigen::AngleAxisd(1.9, Vec3::UnitZ()).toRotationMatrix();
  // Panels from the places of the triangles: four, of which two are turned and one has another scale of shift.
  for (const mesh::Triangle& t : d.triangles) {
    const Vec3 c = (d.positions[t[0]] + d.positions[t[1]] + d.positions[t[2]]) / 3;
    const bool turned = (c[0] < 0.5) != (c[1] < 0.5);
    d.rest.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& x = d.positions[t[i]];
      d.rest.back()[i] = turned ? Vec3(turn * x + Vec3(4, 0, 0)) : Vec3(x + Vec3(c[0] < 0.5 ? 0 : 2, 0, 0));
    }
  }
  const mesh::SurfaceMesh m(d);
  const RestSurface rest(m);
  const Remeshed r = remeshed(m, rest, sizes(m, [](const Vec3& x) { return 0.04 + 0.1 * x[0]; }));
  CHECK(r.counts.smoothed > 0);
  for (const Interpolation kind : {Interpolation::smooth, Interpolation::smoother})
    CHECK(largest_error(adapt::transfer(m, r, field_of(m, quadratic), kind), r.mesh, quadratic) < 1e-10);
}

TEST_CASE("what is equal along a line stays so at new vertices on it") {
  const mesh::SurfaceMesh m(square(Pattern::jittered, 8));
  const RestSurface rest(m);
  const Remeshed r = remeshed(m, rest, sizes(m, [](const Vec3&) { return 0.04; }));
  // A shape that leaves the plane x = 0 with a slope that varies along it.
  const auto f = [](const Vec3& x) {
    return Vec3(std::sin(3 * x[0]) * std::cos(5 * x[1]), x[1], std::cos(4 * x[1]) * x[0]);
  };
  const auto values = adapt::transfer(m, r, field_of(m, f), Interpolation::smooth);
  Index on_line = 0;
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (r.mesh.positions[v][0] != 0.0) continue;
    CHECK(values[v][0] == 0.0);
    CHECK(values[v][2] == 0.0);
    ++on_line;
  }
  CHECK(on_line > 16);
}

TEST_CASE("momentum is that of the old mesh to round-off, also where vertices are held") {
  const mesh::SurfaceMesh m(square(Pattern::gmsh, 8));
  const RestSurface rest(m);
  const Remeshed r = remeshed(m, rest, sizes(m, [](const Vec3& x) { return 0.03 + 0.1 * x[0]; }));
  const mesh::SurfaceMesh after(r.mesh);
  const auto wave = [](const Vec3& x) { return Vec3(std::sin(7 * x[0]), 2 + std::cos(9 * x[1]), x[0] * x[1] - 1); };
  const auto bent = [](const Vec3& x) { return Vec3(x[0], x[1], 0.3 * std::sin(4 * x[0])); };
  const auto mass = lumped(m), new_mass = lumped(after);
  const auto places = field_of(m, bent), velocity = field_of(m, wave);
  const auto new_places = field_of(after, bent);
  const adapt::Motion old_motion{mass, places, velocity};
  const adapt::Momentum before = adapt::momentum(old_motion);
  for (const bool hold : {false, true}) {
    std::vector<char> held;
    if (hold)
      for (const Vec3& x : after.positions()) held.push_back(x[0] == 0.0);
    auto v = adapt::transfer(m, r, velocity, Interpolation::smoother);
    const auto carried = v;
    adapt::conserve_momentum(old_motion, new_mass, new_places, held, v);
    const adapt::Momentum now = adapt::momentum({new_mass, new_places, v});
    CHECK((now.linear - before.linear).norm() < 1e-12 * before.linear.norm());
    CHECK((now.angular - before.angular).norm() < 1e-12 * (before.linear.norm() + before.angular.norm()));
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (hold && held[i]) CHECK(v[i] == carried[i]);
      CHECK((v[i] - carried[i]).norm() < 0.02);
    }
  }
  // All points on a line: nothing turns about it, and nothing divides by zero.
  const std::vector<double> two{1.0, 1.0};
  const std::vector<Vec3> line{{0, 0, 0}, {1, 0, 0}}, speed{{1, 2, 3}, {0, 1, 0}};
  std::vector<Vec3> v{{0, 0, 0}, {0, 0, 0}};
  adapt::conserve_momentum({two, line, speed}, two, line, {}, v);
  CHECK((v[0] + v[1] - speed[0] - speed[1]).norm() < 1e-12);
}

TEST_CASE("kinetic energy is added by one factor on what is not rigid: momentum and held vertices stay") {
  const mesh::SurfaceMesh m(square(Pattern::gmsh, 8));
  const auto mass = lumped(m);
  const std::vector<Vec3>& places = m.positions();
  const auto start =
      field_of(m, [](const Vec3& x) { return Vec3(1 + x[1], -2 * x[0], std::sin(7 * x[0] + 3 * x[1])); });
  for (const bool hold : {false, true}) {
    std::vector<char> held;
    if (hold)
      for (const Vec3& x : places) held.push_back(x[0] == 0.0);
    const adapt::Momentum before = adapt::momentum({mass, places, start});
    const double energy = kinetic(mass, start);
    for (const double wanted : {0.01, -0.01}) {
      auto v = start;
      const double factor = adapt::add_kinetic_energy(mass, places, held, {wanted * energy, 0.1}, v);
      CHECK((factor > 1.0) == (wanted > 0.0));
      CHECK(kinetic(mass, v) / energy - 1.0 == relative(wanted).epsilon(1e-9));
      const adapt::Momentum now = adapt::momentum({mass, places, v});
      CHECK((now.linear - before.linear).norm() < 1e-12 * before.linear.norm());
      CHECK((now.angular - before.angular).norm() < 1e-12 * before.linear.norm());
      for (std::size_t i = 0; i < held.size(); ++i)
        if (held[i]) CHECK(v[i] == start[i]);
    }
    auto v = start;
    CHECK(adapt::add_kinetic_energy(mass, places, held, {energy, 0.05}, v) == relative(1.05));
    v = start;
    CHECK(adapt::add_kinetic_energy(mass, places, held, {-2.0 * energy, 1.0}, v) == doctest::Approx(0.0));
    CHECK(adapt::add_kinetic_energy(mass, places, held, {energy, 0.0}, v) == 1.0);
  }
  // A rigid motion has nothing to change, nor has what stands still.
  auto rigid = field_of(m, [](const Vec3& x) -> Vec3 { return Vec3(1, 0, 0) + Vec3(0, 1, 2).cross(x); });
  const auto same = rigid;
  const double factor = adapt::add_kinetic_energy(mass, places, {}, {1.0, 0.1}, rigid);
  CHECK(factor == 1.0);
  for (std::size_t i = 0; i < same.size(); ++i) CHECK((rigid[i] - same[i]).norm() < 1e-12);
  std::vector<Vec3> still(same.size(), Vec3::Zero());
  CHECK(adapt::add_kinetic_energy(mass, places, {}, {1.0, 0.1}, still) == 1.0);
}

TEST_CASE("a wave of eight edges keeps its kinetic energy through 20 remeshings") {
  const double h = 1.0 / 24;
  const auto wave = [](const Vec3& x) { return Vec3(0, 0, std::sin(2 * pi * 3 * x[0]) * std::cos(2 * pi * x[1])); };
  mesh::SurfaceMesh m(square(Pattern::gmsh, 24));
  const RestSurface rest(m);
  auto v = field_of(m, wave);
  const double before = kinetic(lumped(m), v);
  Index changed = 0;
  for (int k = 0; k < 20; ++k) {
    // A fine spot that wanders.
    const Vec3 spot(0.5 + 0.4 * std::cos(k), 0.5 + 0.4 * std::sin(2.0 * k), 0);
    const Remeshed r = remeshed(
        m, rest, sizes(m, [&](const Vec3& x) { return std::min(1.1 * h, 0.5 * h + 0.08 * (x - spot).norm()); }));
    const mesh::SurfaceMesh after(r.mesh);
    const auto mass = lumped(m), new_mass = lumped(after);
    auto next = adapt::transfer(m, r, v, Interpolation::smoother);
    adapt::conserve_momentum({mass, m.positions(), v}, new_mass, after.positions(), {}, next);
    changed += static_cast<Index>(std::count(r.kept.begin(), r.kept.end(), no_index));
    m = after;
    v = next;
  }
  const double ratio = kinetic(lumped(m), v) / before;
  CAPTURE(ratio);
  CAPTURE(changed);
  CHECK(changed > 3500);
  CHECK(ratio > 0.98);
  CHECK(ratio < 1.02);
  CHECK(largest_error(v, m.data(), wave) < 0.1);
}

TEST_CASE("sizes: angle over curvature, bounds, growth, curved edges") {
  const mesh::SurfaceMesh m(square(Pattern::diagonal, 20));
  adapt::SizeOptions o;
  o.angle = 0.25;
  o.smallest = 0.01;
  o.largest = 0.2;
  o.growth = 0.3;
  const auto nt = static_cast<std::size_t>(m.triangle_count()), nv = static_cast<std::size_t>(m.vertex_count());
  // A cylinder of radius 2: h = 0.5, above the largest. Radius 0.4: 0.1. Radius 0.01: the smallest.
  for (const auto& [radius, h] : {std::pair{2.0, 0.2}, std::pair{0.4, 0.1}, std::pair{0.01, 0.01}})
    for (const double size : adapt::size_field(m, m.positions(), std::vector<double>(nt, 1 / (radius * radius)), {}, o))
      CHECK(size == relative(h).epsilon(1e-12));
  // One curved triangle: seen at its vertices by its fraction of the area, and growing away from them.
  std::vector<double> squared(nt, 0.0);
  squared[410] = 400.0;
  auto h = adapt::size_field(m, m.positions(), squared, {}, o);
  for (Index v : m.triangles()[410]) CHECK(h[v] == relative(0.25 / std::sqrt(400.0 / 6)).epsilon(1e-9));
  double steepest = 0.0;
  for (Index t = 0; t < m.triangle_count(); ++t)
    for (int i = 0; i < 3; ++i) {
      const Index a = m.triangles()[t][i], b = m.triangles()[t][(i + 1) % 3];
      steepest = std::max(steepest, std::abs(h[a] - h[b]) / (m.positions()[a] - m.positions()[b]).norm());
    }
  CHECK(steepest == relative(0.3).epsilon(1e-9));
  CHECK(*std::max_element(h.begin(), h.end()) == relative(0.2).epsilon(1e-12));
  // A bound lowers below the smallest, and grows out.
  std::vector<double> bound(nv, INFINITY);
  bound[0] = 0.005;
  h = adapt::size_field(m, m.positions(), std::vector<double>(nt, 0.0), bound, o);
  CHECK(h[0] == 0.005);
  CHECK(h[1] == relative(0.005 + 0.3 / 20).epsilon(1e-9));
  CHECK_THROWS_AS(static_cast<void>(adapt::size_field(m, m.positions(), {1.0}, {}, o)), InternalError);
  // A ring: R/10 on both edges.
  const mesh::SurfaceMesh ring(mapped(grid(40, 4, false, 0.0), [](const Vec3& x) {
    const double a = pi * x[0], r = 1 + x[1];
    return Vec3(r * std::cos(a), r * std::sin(a), 0);
  }));
  o.largest = 1.0;
  o.growth = 10.0;
  h = adapt::size_field(ring, ring.positions(),
                        std::vector<double>(static_cast<std::size_t>(ring.triangle_count()), 0.0), {}, o);
  CHECK(h[20] == relative(0.1).epsilon(1e-9));           // the middle of the inner edge
  CHECK(h[4 * 41 + 20] == relative(0.2).epsilon(1e-9));  // and of the outer
  CHECK(h[2 * 41 + 20] > 0.5);
}

TEST_CASE("sizes for an error: the same in every cell, and in all what is wanted") {
  const mesh::SurfaceMesh m(square(Pattern::union_jack, 20));
  // Three times as much on the right, falling with the square of the edge.
  std::vector<double> density;
  for (Index t = 0; t < m.triangle_count(); ++t) density.push_back(0.5 + m.rest_corner(t, 0).x());
  double whole = 0.0;
  for (Index t = 0; t < m.triangle_count(); ++t) whole += m.area(t) * density[t];
  const double edge = std::sqrt(4.0 * m.area(0) / std::sqrt(3.0)), stored = 20.0;
  for (const double fraction : {0.5, 1.0, 2.0}) {
    const std::vector<double> h = adapt::sizes_for_error(m, density, stored, fraction * whole / stored);
    double after = 0.0, least = 1e300, most = 0.0;
    for (Index t = 0; t < m.triangle_count(); ++t) {
      double size = 0.0;
      for (Index v : m.triangles()[t]) size += h[v] / 3.0;
      const double error = density[t] * std::pow(size / edge, 2);
      after += m.area(t) * error;
      least = std::min(least, error * size * size);
      most = std::max(most, error * size * size);
    }
    CHECK(after == relative(fraction * whole).epsilon(0.02));
    CHECK(most < 1.2 * least);  // means at the vertices
  }
  // No more than half at once; nothing where nothing is wrong or stored.
  for (const double h : adapt::sizes_for_error(m, density, stored, 1e-6 * whole / stored))
    CHECK(h == relative(0.5 * edge).epsilon(1e-12));
  for (const double h : adapt::sizes_for_error(m, density, 0.0, 0.1)) CHECK(std::isinf(h));
  density.assign(density.size(), 0.0);
  for (const double h : adapt::sizes_for_error(m, density, stored, 0.1)) CHECK(std::isinf(h));
}

TEST_CASE("match: shares and percentiles") {
  const mesh::SurfaceMesh m(square(Pattern::diagonal, 10));
  const auto nv = static_cast<std::size_t>(m.vertex_count());
  CHECK(adapt::match(m, std::vector<double>(nv, 0.05)).too_long == relative(1.0).epsilon(1e-9));
  CHECK(adapt::match(m, std::vector<double>(nv, 0.3)).too_short == relative(1.0).epsilon(1e-9));
  // Inside, edges of a vertex are (4 + 2 sqrt 2)/6 = 1.14 sides long on the mean, in corners as little as one.
  const auto of_sides = [&](double ratio) { return adapt::match(m, std::vector<double>(nv, 0.1138 / ratio)); };
  CHECK(of_sides(1.55).too_long > 0.6);
  CHECK(of_sides(1.45).too_long == 0.0);
  CHECK(of_sides(0.48).too_short > 0.6);
  CHECK(of_sides(0.58).too_short == 0.0);
  const adapt::SizeMatch match = adapt::match(m, std::vector<double>(nv, 0.1));
  CHECK(match.too_long + match.too_short == 0.0);
  CHECK(match.p1 == relative(1.0).epsilon(1e-9));
  CHECK(match.p99 == relative(std::sqrt(2.0)).epsilon(1e-9));
  // On the left half sizes are a third: only the right half counts.
  std::vector<double> size(nv, 0.1);
  std::vector<char> counted(nv, 1);
  for (std::size_t v = 0; v < nv; ++v)
    if (m.positions()[v].x() < 0.55) std::tie(size[v], counted[v]) = std::pair(0.1 / 3.0, char{0});
  CHECK(adapt::match(m, size).p99 > 4.0);
  CHECK(adapt::match(m, size, counted).p1 == relative(1.0).epsilon(1e-9));
  CHECK(adapt::match(m, size, counted).p99 == relative(std::sqrt(2.0)).epsilon(1e-9));
  CHECK(adapt::match(m, size, std::vector<char>(nv, 0)).p99 == 0.0);
}

}  // namespace test_adapt_transfer
