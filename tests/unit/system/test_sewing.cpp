// Seams in a model: a weld leaves no trace in a flat sheet; the springs that close one; what contact leaves alone.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

#include "energy/seam.hpp"
#include "mesh/weld.hpp"
#include "solve/newton.hpp"
#include "system/contact.hpp"
#include "system/seam_tension.hpp"
#include "system/sewing_springs.hpp"
#include "test_model_kit.hpp"

namespace test_sewing {

using namespace voile;
using namespace voile::testing;

namespace {

/// The unit square in two panels, cut along the vertical line of vertices next to x = 0.5; charts apart.
mesh::MeshData two_panels(int cells) {
  mesh::MeshData all = square(Pattern::diagonal, cells);
  const double cut = 0.5;
  const auto n = all.positions.size();
  all.seams = {{"middle", {}, {}}};
  std::vector<Index> twin(n, no_index);
  for (std::size_t v = 0; v < n; ++v)
    if (std::abs(all.positions[v][0] - cut) < 1e-9) {
      twin[v] = static_cast<Index>(all.positions.size());
      all.seams[0].pairs.push_back({static_cast<Index>(v), twin[v]});
      all.seams[0].lengths.push_back(1.0 / (cells + 1));
      all.positions.push_back(all.positions[v]);
    }
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
  for (mesh::Triangle& t : all.triangles) {
    const Vec3 centre = (all.positions[t[0]] + all.positions[t[1]] + all.positions[t[2]]) / 3.0;
    const bool right = centre[0] > cut;
    std::array<Vec3, 3> rest;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 x = all.positions[t[i]];
      rest[i] = right ? Vec3(turn * x + Vec3(3.0, 1.0, 0.0)) : x;
      if (right && twin[t[i]] != no_index) t[i] = twin[t[i]];
    }
    all.rest.push_back(rest);
  }
  all.groups.clear();
  all.vertex_tags.clear();
  return all;
}

system::ModelInput input() {
  system::ModelInput in;
  in.materials = {isotropic(1e6, 0.3, 0.01, 1.0)};
  return in;
}

}  // namespace

TEST_CASE("a seam across a flat sheet is invisible: energy and forces are those of the whole sheet") {
  const mesh::MeshData open = two_panels(12);
  const std::vector<double> mass(open.positions.size(), 1.0);
  const mesh::Welded w = mesh::weld(open, {"middle"}, open.positions, mass);
  mesh::MeshData plain = w.data;
  plain.rest.clear();
  const mesh::SurfaceMesh sewn(w.data), whole(plain);
  REQUIRE(sewn.has_charts());
  REQUIRE(sewn.component_count() == 1);
  system::Model a(PETSC_COMM_WORLD, sewn, input()), b(PETSC_COMM_WORLD, whole, input());
  const auto bent = [&](Index v) {
    const Vec3& x = whole.positions()[v];
    return Vec3(0.01 * x[0] * x[1], -0.005 * x[0], 0.1 * std::sin(3.0 * x[0]) * std::cos(2.0 * x[1]));
  };
  petsc::VecHandle ua = a.dofs().create_vector(), ub = b.dofs().create_vector(), fa = a.dofs().create_vector(),
                   fb = b.dofs().create_vector();
  set_displacement(a, ua, bent);
  set_displacement(b, ub, bent);
  const system::Energies ea = system::energies(a, ua), eb = system::energies(b, ub);
  CHECK(ea.bending == doctest::Approx(eb.bending).epsilon(1e-9));
  CHECK(ea.membrane == doctest::Approx(eb.membrane).epsilon(1e-9));
  a.unbalanced_force(ua, fa);
  b.unbalanced_force(ub, fb);
  const std::vector<Vec3> ga = per_vertex(a, fa), gb = per_vertex(b, fb);
  double largest = 0.0, difference = 0.0;
  for (std::size_t v = 0; v < ga.size(); ++v) {
    largest = std::max(largest, gb[v].norm());
    difference = std::max(difference, (ga[v] - gb[v]).norm());
  }
  CHECK(difference < 1e-8 * largest);
}

TEST_CASE("springs of a seam only pull, get shorter in time, and their derivatives are right") {
  mesh::MeshData open = two_panels(4);
  for (const auto& [v, w] : open.seams[0].pairs) open.positions[w] = open.positions[v] + Vec3(0.1, 0, 0);
  const mesh::SurfaceMesh mesh(open);
  system::ModelInput in = input();
  in.sewing = {{"all"}, 100.0, 0.5, 1e6, 1.0};
  system::Model model(PETSC_COMM_WORLD, mesh, std::move(in));
  petsc::VecHandle u = model.dofs().create_vector();
  const double stiffness = 100.0 * 5.0 / 5.0;  // over the whole seam of 1 m
  for (const auto& [time, length] : {std::pair{0.0, 0.1}, {1.1, 0.05}, {1.2, 0.0}, {5.0, 0.0}}) {
    model.set_time(time);
    const double tight = time < 1.2 ? 1.0 : time < 2.0 ? 1.0 : 128.0;  // one that has no length gets stiffer
    CHECK(system::energies(model, u).springs ==
          doctest::Approx(0.5 * tight * stiffness * std::pow(0.1 - length, 2)).epsilon(1e-6));
  }
  model.set_time(1.23);
  CHECK(system::energies(model, u).springs == doctest::Approx(0.5 * 2.0 * stiffness * 0.1 * 0.1).epsilon(1e-6));
  model.set_time(1.1);  // nearer than that nothing pushes
  set_displacement(model, u, [&](Index v) {
    const bool twin =
        std::any_of(open.seams[0].pairs.begin(), open.seams[0].pairs.end(), [&](const auto& p) { return p[1] == v; });
    return Vec3(twin ? -0.08 : 0.0, 0.0, 0.0);
  });
  CHECK(system::energies(model, u).springs == 0.0);
}

TEST_CASE("a slider closes a seam along itself, and pulls nothing before it comes") {
  mesh::MeshData open = two_panels(4);
  mesh::Seam& seam = open.seams[0];
  for (const auto& [v, w] : seam.pairs) {
    open.positions[w] = open.positions[v] + Vec3(0.1, 0, 0);
    seam.stations.push_back(open.positions[v][1]);
  }
  const mesh::SurfaceMesh mesh(open);
  system::ModelInput in = input();
  in.sewing = {{"all"}, 1e6, 0.5, 2.0, 1.0, 6.0, {{"mid*", 2.0}, {"other", 7.0}}};
  system::Model model(PETSC_COMM_WORLD, mesh, std::move(in));
  const petsc::VecHandle u = model.dofs().create_vector();
  const system::SewingSprings& springs = *model.potential().sewing();
  // Far beyond l0 a spring stores its force times its excess: 2 N/m along 0.1 m less what it has shortened.
  for (const double time : {1.0, 1.15, 1.3, 1.5}) {
    double expected = 0.0;
    for (std::size_t k = 0; k < seam.pairs.size(); ++k)
      expected += 2.0 * seam.lengths[k] * std::clamp(0.5 * (time - 1.0 - seam.stations[k] / 2.0), 0.0, 0.1);
    model.set_time(time);
    CHECK(system::energies(model, u).springs == doctest::Approx(expected).epsilon(1e-3));
  }
  // The last pair is at 1 m: 0.5 s of the slider and 0.2 s of its spring.
  CHECK(springs.largest_force(1.7) == 2.0);
  CHECK(springs.largest_force(1.8) == doctest::Approx(4.0));
}

TEST_CASE("the force of seams that stay open rises when their springs have no length any more, up to a bound") {
  mesh::MeshData open = two_panels(4);
  for (const auto& [v, w] : open.seams[0].pairs) open.positions[w] = open.positions[v] + Vec3(0.1, 0, 0);
  const mesh::SurfaceMesh mesh(open);
  system::ModelInput in = input();
  in.sewing = {{"all"}, 1e6, 0.5, 2.0, 1.0, 6.0};
  system::Model model(PETSC_COMM_WORLD, mesh, std::move(in));
  const petsc::VecHandle u = model.dofs().create_vector();
  const system::SewingSprings& springs = *model.potential().sewing();
  CHECK(springs.largest_force(0.0) == 2.0);
  CHECK(springs.largest_force(1.2) == 2.0);  // closed after 0.2 s
  CHECK(springs.largest_force(1.3) == doctest::Approx(4.0));
  CHECK(springs.rises(1.3));
  CHECK(springs.largest_force(5.0) == 6.0);
  CHECK_FALSE(springs.rises(5.0));
  // Far beyond l0 the energy is the force times the distance.
  for (const double time : {1.2, 1.3, 5.0}) {
    model.set_time(time);
    CHECK(system::energies(model, u).springs == doctest::Approx(0.1 * springs.largest_force(time)).epsilon(1e-3));
  }
}

TEST_CASE("a spring of a seam pulls with its stiffness at first, and never with more than its force") {
  energy::SeamTerm seam;
  seam.add({0, 1}, 100.0, 2.0, 0.3, true);
  std::array<Vec3, 2> x{Vec3::Zero(), Vec3::Zero()};
  energy::Configuration c;
  c.x = x.data();
  const auto force = [&](double length) {
    x[1] = Vec3(0, length, 0);
    double f = 0.0;
    seam.gradient(0, c, [&](int a, const Vec3& part) { f += a == 1 ? part[1] : 0.0; });
    return f;
  };
  CHECK(force(0.0) == 0.0);
  CHECK(force(0.29) == 0.0);
  CHECK(force(0.3001) == doctest::Approx(0.01).epsilon(1e-4));
  CHECK(force(0.32) == doctest::Approx(2.0 / std::sqrt(2.0)));
  CHECK(force(100.0) < 2.0);
  CHECK(force(100.0) > 1.999);
  seam.set(0, 0.0, 1e4, 2.0);
  CHECK(force(1e-6) == doctest::Approx(0.01).epsilon(1e-4));
  CHECK(force(1.0) < 2.0);
}

TEST_CASE("a spring of a seam: derivatives by differences") {
  energy::SeamTerm spring;
  spring.add({0, 1}, 7.0, 1.5, 0.3, true);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (int k = 0; k < 40; ++k) {
    if (k == 20) spring.set(0, 0.0, 9.0, 1.5);
    std::array<Vec3, 2> x;
    for (Vec3& p : x) p = Vec3(uniform(random), uniform(random), uniform(random));
    if (std::abs((x[1] - x[0]).norm() - 0.3) < 1e-3) continue;
    energy::Configuration c;
    c.x = x.data();
    std::array<Vec3, 2> g{Vec3::Zero(), Vec3::Zero()};
    spring.gradient(0, c, [&](int a, const Vec3& f) { g[static_cast<std::size_t>(a)] += f; });
    Mat3 h = Mat3::Zero();
    spring.hessian(0, c, [&](int a, int b, const Mat3& block) {
      if (a == 1 && b == 1) h += block;
    });
    const double e = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const double at = x[1][i];
      const auto gradient = [&] {
        Vec3 f = Vec3::Zero();
        spring.gradient(0, c, [&](int a, const Vec3& part) { f += a == 1 ? part : Vec3(Vec3::Zero()); });
        return f;
      };
      x[1][i] = at + e;
      const double high = spring.energy(0, c);
      const Vec3 gh = gradient();
      x[1][i] = at - e;
      const double low = spring.energy(0, c);
      const Vec3 gl = gradient();
      x[1][i] = at;
      CHECK(std::abs((high - low) / (2.0 * e) - g[1][i]) < 1e-7);
      const double excess = (x[1] - x[0]).norm() - (k < 20 ? 0.3 : 0.0), linear = 1.5 / (k < 20 ? 7.0 : 9.0);
      const double exact = (gh[i] - gl[i]) / (2.0 * e);
      if (excess < linear)
        CHECK(((gh - gl) / (2.0 * e) - h.col(i)).norm() < 1e-6);
      else
        CHECK(h(i, i) > exact - 1e-6);  // the secant is stiffer
    }
  }
}

TEST_CASE("figures that share a seam's vertex are no pair of contact; others near it are") {
  mesh::MeshData open = two_panels(4);
  for (const auto& [v, w] : open.seams[0].pairs) open.positions[w] = open.positions[v] + Vec3(1e-4, 0, 0);
  system::ModelInput in = input();
  in.contact.active = true;
  in.contact.options.distance = 1e-2;
  const mesh::SurfaceMesh mesh(open);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle u = model.dofs().create_vector();
  CHECK(system::report(model.contact()->scene(), u).pairs == 0);
  open.seams.clear();  // now they are strangers
  const mesh::SurfaceMesh strangers(open);
  system::Model other(PETSC_COMM_WORLD, strangers, in);
  CHECK(system::report(other.contact()->scene(), u).pairs > 0);
}

TEST_CASE("tension of a seam, open or welded, is the traction across it in any homogeneous state") {
  mesh::MeshData open = two_panels(6);
  std::vector<std::array<Index, 2>> order = open.seams[0].pairs;
  const auto lower = [&](const auto& a, const auto& b) { return open.positions[a[0]][1] < open.positions[b[0]][1]; };
  std::sort(order.begin(), order.end(), lower);
  mesh::Group line{mesh::seam_group("middle"), 1, {}, {}, {}};
  for (const std::size_t side : {0, 1})
    for (std::size_t i = 0; i < order.size(); ++i) {
      line.vertices.push_back(order[i][side]);
      if (i > 0) line.segments.push_back({order[i - 1][side], order[i][side]});
    }
  std::sort(line.vertices.begin(), line.vertices.end());
  open.groups.push_back(line);
  const std::vector<double> mass(open.positions.size(), 1.0);
  // Sides that carry a traction, too; then free ones, where it is the same at every vertex.
  Mat3 general = Mat3::Identity();
  general.topLeftCorner<2, 2>() << 1.04, 0.03, -0.02, 0.98;
  const Mat3 uniaxial = Vec3(std::sqrt(1.0 + 2.0 * 0.05), std::sqrt(1.0 - 2.0 * 0.3 * 0.05), 1.0).asDiagonal();
  for (const bool welded : {false, true})
    for (const bool free : {false, true}) {
      const Mat3 f =
          Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).toRotationMatrix() * (free ? uniaxial : general);
      // E = (F'F - 1)/2, N = A E, traction F N e1 over the rest length, across the line that F e2 lies along.
      const Mat3 strain = 0.5 * (f.transpose() * f - Mat3::Identity());
      const Vec3 n = isotropic(1e6, 0.3, 0.01).membrane * Vec3(strain(0, 0), strain(1, 1), 2.0 * strain(0, 1));
      const Vec3 along = f.col(1).normalized(), across = (f.col(0) - along * along.dot(f.col(0))).normalized();
      const double exact = across.dot(f * Vec3(n[0], n[2], 0.0));
      const mesh::SurfaceMesh mesh(welded ? mesh::weld(open, {"middle"}, open.positions, mass).data : open);
      system::Model model(PETSC_COMM_WORLD, mesh, input());
      petsc::VecHandle u = model.dofs().create_vector();
      set_displacement(model, u, [&](Index v) { return Vec3(f * mesh.positions()[v] - mesh.positions()[v]); });
      const system::TriangleFields fields = model.triangle_fields(u);
      if (mpi::rank(PETSC_COMM_WORLD) != 0) continue;
      std::vector<Vec3> places;
      for (const Vec3& x : mesh.positions()) places.emplace_back(f * x);
      const system::SeamTension t =
          system::seam_tension(model.discretisation().sheet(), mesh.group(line.name, 1), fields.membrane_force, places);
      CHECK(mesh.group(line.name, 1).segments.size() == (welded ? 1 : 2) * (order.size() - 1));
      CHECK(t.length == doctest::Approx(1.0).epsilon(1e-12));
      CHECK(t.mean == doctest::Approx(exact).epsilon(1e-9));
      // Where borders pull, the ends differ; of a welded line by as much one way as the other.
      CHECK((t.error < 1e-9 * t.mean) == (free || welded));
      if (free) CHECK(t.largest == doctest::Approx(exact).epsilon(1e-9));
    }
}

}  // namespace test_sewing
