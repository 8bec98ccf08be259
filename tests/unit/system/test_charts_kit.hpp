// Panels, answers and slopes for tests of charts.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <numbers>

#include "mesh/panels.hpp"
#include "test_model_kit.hpp"

namespace voile::testing::charts {

struct Motion {
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

/// In the plane z = const, or anywhere.
inline Motion random_motion(unsigned seed, bool in_plane) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  const double angle = std::numbers::pi * d(random);
  const Vec3 axis = in_plane ? Vec3(Vec3::UnitZ()) : Vec3(Vec3(d(random), d(random), d(random)).normalized());
  const double x = d(random), y = d(random), z = d(random);
  return {Eigen::AngleAxisd(angle, axis).toRotationMatrix(), Vec3(x, y, in_plane ? 0.0 : z)};
}

/// Rest corners: those of the positions in d, each moved with its chart. chart_of(t): its number.
inline mesh::MeshData cut(mesh::MeshData d, const std::function<int(Index)>& chart_of, bool in_plane) {
  for (Index t = 0; t < static_cast<Index>(d.triangles.size()); ++t) {
    const Motion m = random_motion(101u + static_cast<unsigned>(chart_of(t)), in_plane);
    std::array<Vec3, 3> corners;
    for (int i = 0; i < 3; ++i) corners[i] = m.turn * d.positions[d.triangles[t][i]] + m.shift;
    d.rest.push_back(corners);
  }
  return d;
}

/// Everything that a model answers at a state: residual, tangent along a vector, mass, energies, fields.
struct Answers {
  std::vector<Vec3> residual, tangent, mass;
  std::vector<double> energies;
  system::TriangleFields fields;
};

inline Answers ask(system::Model& model, const std::function<Vec3(Index)>& state) {
  const petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                         r = model.dofs().create_vector();
  Answers all;
  set_displacement(model, a, state);
  set_displacement(model, d, noise(1.0, 77));
  model.conditions().set_load_factor(0.7);
  model.unbalanced_force(a, r);
  all.residual = per_vertex(model, r);
  model.assemble_tangent(a, {.kind = energy::Tangent::exact, .mass = 0.3});
  VOILE_PETSC(MatMult(model.tangent().matrix(), d, r));
  all.tangent = per_vertex(model, r);
  all.mass = per_vertex(model, model.potential().constant().mass());
  const system::Energies e = system::energies(model, a);
  all.energies = {e.membrane, e.bending, e.external, e.springs};
  all.fields = model.triangle_fields(a);
  return all;
}

template <class Values>
double difference(const Values& a, const Values& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if constexpr (std::is_same_v<Values, std::vector<double>>) {
      largest = std::max(largest, std::abs(a[i] - b[i]));
      scale = std::max(scale, std::abs(b[i]));
    } else {
      largest = std::max(largest, (a[i] - b[i]).norm());
      scale = std::max(scale, b[i].norm());
    }
  }
  if (!b.empty()) REQUIRE(scale > 0.0);
  return b.empty() ? 0.0 : largest / scale;
}

/// Newton's method in load steps until nothing moves any more.
inline std::vector<Vec3> equilibrium(system::Model& model) {
  const petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector(),
                         da = model.dofs().create_vector();
  for (int step = 1; step <= 8; ++step) {
    model.conditions().set_load_factor(step / 8.0);
    model.conditions().enforce(a);
    for (int i = 0; i < 8; ++i) {
      model.residual(a, r);
      model.assemble_tangent(a, {.kind = energy::Tangent::exact});
      VOILE_PETSC(VecScale(r, -1.0));
      solve_linear(model, r, da, PCLU);
      VOILE_PETSC(VecAXPY(a, 1.0, da));
    }
    if (step == 8) CHECK(norm(da) < 1e-12 * norm(a));
  }
  return per_vertex(model, a);
}

/// A sheet of length 2 pi radius and height 1, nx x ny cells, of jittered vertices. Closed: its ends share vertices.
/// rest: flat, (arc, y); positions: f of these.
inline mesh::MeshData sheet(int nx, int ny, double radius, double jitter, bool closed,
                            const std::function<Vec3(const Vec2&)>& f) {
  mesh::MeshData d;
  d.source = "tube";
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-jitter, jitter);
  const double length = 2.0 * std::numbers::pi * radius;
  std::vector<Vec2> place;
  for (int j = 0; j <= ny; ++j) {
    std::vector<Vec2> row;
    for (int i = 0; i < nx; ++i) {
      const double dx = noise(random), dy = noise(random);
      row.emplace_back(length * (i + (j > 0 && j < ny ? dx : 0.0)) / nx, (j + (j > 0 && j < ny ? dy : 0.0)) / ny);
    }
    row.emplace_back(row.front() + Vec2(length, 0.0));
    place.insert(place.end(), row.begin(), row.end());
  }
  const auto vertex = [&](int i, int j) { return static_cast<Index>(closed ? j * nx + i % nx : j * (nx + 1) + i); };
  d.positions.resize(static_cast<std::size_t>((closed ? nx : nx + 1) * (ny + 1)));
  const auto at = [&](int i, int j) { return place[static_cast<std::size_t>(j * (nx + 1) + i)]; };
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i < (closed ? nx : nx + 1); ++i) d.positions[vertex(i, j)] = f(at(i, j));
  const auto add = [&](std::array<std::array<int, 2>, 3> ij) {
    mesh::Triangle t{};
    std::array<Vec3, 3> rest;
    for (int k = 0; k < 3; ++k) {
      t[k] = vertex(ij[k][0], ij[k][1]);
      const Vec2 p = at(ij[k][0], ij[k][1]);
      rest[k] = Vec3(p[0], p[1], 0.0);
    }
    d.triangles.push_back(t);
    d.rest.push_back(rest);
  };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      add({{{i, j}, {i + 1, j}, {i + 1, j + 1}}});
      add({{{i, j}, {i + 1, j + 1}, {i, j + 1}}});
    }
  return d;
}

inline std::function<Vec3(const Vec2&)> rolled(double radius) {
  return [=](const Vec2& p) { return Vec3(radius * std::cos(p[0] / radius), radius * std::sin(p[0] / radius), p[1]); };
}

inline system::ModelInput free_sheet(double poisson) {
  system::ModelInput in;
  in.materials = {isotropic(100.0, poisson, 0.02, 1.0)};
  return in;
}

/// Relative errors of force against energy and of tangent against force, at a random state; `h`: step of the differences over `size`.
struct Slopes {
  double force, tangent;
};

inline Slopes slopes(system::Model& model, double size, double h = 1e-4) {
  const petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                         r = model.dofs().create_vector(), moved = model.dofs().create_vector(),
                         kd = model.dofs().create_vector(), r2 = model.dofs().create_vector();
  set_displacement(model, a, noise(size, 3));
  set_displacement(model, d, noise(size, 4));
  model.conditions().enforce(a);
  model.dofs().clear_fixed(d);
  model.residual(a, r);
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatMult(model.tangent().matrix(), d, kd));
  model.dofs().clear_fixed(kd);
  const auto at = [&](double step, Vec to) { VOILE_PETSC(VecWAXPY(to, step, d, a)); };
  // Fourth-order differences: the energy is a polynomial of degree 4, but for the normals.
  const auto slope = [&](const std::function<double(double)>& f) {
    return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
  };
  Slopes s{};
  const double exact = dot(r, d);
  REQUIRE(std::abs(exact) > 0.0);
  model.potential().count_from(a);
  s.force = std::abs(slope([&](double step) {
                       at(step, moved);
                       return model.energy(moved);
                     }) -
                     exact) /
            std::abs(exact);
  VOILE_PETSC(VecZeroEntries(r2));
  for (const auto& [step, weight] : {std::pair{h, 8.0}, {-h, -8.0}, {2.0 * h, -1.0}, {-2.0 * h, 1.0}}) {
    at(step, moved);
    model.residual(moved, r);
    model.dofs().clear_fixed(r);
    VOILE_PETSC(VecAXPY(r2, weight / (12.0 * h), r));
  }
  const double scale = norm(kd);
  REQUIRE(scale > 0.0);
  VOILE_PETSC(VecAXPY(r2, -1.0, kd));
  s.tangent = norm(r2) / scale;
  return s;
}

}  // namespace voile::testing::charts
