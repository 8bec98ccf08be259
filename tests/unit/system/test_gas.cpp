// A gas in a volume: derivatives, volume, the part of low rank in solutions and counts, and what encloses nothing.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>

#include "base/decompositions.hpp"
#include "solve/newton.hpp"
#include "system/gas.hpp"
#include "system/gas_surface.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_gas {

using namespace voile;
using namespace voile::testing;

namespace {

/// An octahedron whose triangles are divided `times` times and laid on an ellipsoid, without those above height `cut`.
mesh::MeshData ellipsoid(int times, double cut = 2.0) {
  mesh::MeshData d;
  d.source = "ellipsoid";
  d.positions = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitX(), -Vec3::UnitY(), -Vec3::UnitZ()};
  d.triangles = {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
  for (int k = 0; k < times; ++k) {
    std::map<std::pair<Index, Index>, Index> middle;
    const auto between = [&](Index a, Index b) {
      const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(d.positions.size()));
      if (fresh) d.positions.push_back((d.positions[a] + d.positions[b]).normalized());
      return at->second;
    };
    std::vector<mesh::Triangle> finer;
    for (const mesh::Triangle& t : d.triangles) {
      const Index a = between(t[0], t[1]), b = between(t[1], t[2]), c = between(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    d.triangles = finer;
  }
  std::erase_if(d.triangles, [&](const mesh::Triangle& t) {
    return (d.positions[t[0]] + d.positions[t[1]] + d.positions[t[2]])[2] / 3.0 > cut;
  });
  std::vector<Index> number(d.positions.size(), no_index);
  std::vector<Vec3> kept;
  for (mesh::Triangle& t : d.triangles)
    for (Index& v : t) {
      if (number[v] == no_index) {
        number[v] = static_cast<Index>(kept.size());
        kept.push_back(d.positions[v].cwiseProduct(Vec3(1.0, 1.2, 0.8)) + Vec3(0.3, -0.2, 5.0));
      }
      v = number[v];
    }
  d.positions = kept;
  return d;
}

system::Load gas(double pressure, double exponent = 1.3) {
  system::Load l;
  l.kind = system::Load::Kind::gas;
  l.magnitude = pressure;
  l.ambient = 5.0;
  l.exponent = exponent;
  return l;
}

system::ModelInput sheet(std::vector<system::Load> loads) {
  system::ModelInput input;
  input.materials = {isotropic(20.0, 0.3, 0.05, 1.0)};
  input.loads = std::move(loads);
  return input;
}

}  // namespace

TEST_CASE("the force of a gas is the derivative of its energy, and its tangent that of the force") {
  for (const double cut : {2.0, 0.3}) {
    CAPTURE(cut);
    const mesh::SurfaceMesh mesh(ellipsoid(2, cut));
    for (const double exponent : {0.0, 1.0, 1.4}) {
      system::Model model(PETSC_COMM_WORLD, mesh, sheet({gas(3.0, exponent)}));
      model.conditions().set_load_factor(0.7);
      petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
      set_displacement(model, a, noise(0.05, 3));
      set_displacement(model, d, noise(1.0, 4));
      check_potential(model, a, d);
      CHECK(model.tangent().change().columns.size() == (cut > 1.0 ? 0u : 6u) + (exponent > 0.0 ? 1u : 0u));
    }
  }
}

TEST_CASE(
    "of a gas that has leaked, too, the force is the derivative of the energy, and its tangent that of the force") {
  const mesh::SurfaceMesh mesh(ellipsoid(2, 0.3));
  for (const double exponent : {1.0, 1.4}) {
    system::Load leaky = gas(3.0, exponent);
    leaky.leak_area = 1e-3;
    system::Model model(PETSC_COMM_WORLD, mesh, sheet({leaky}));
    model.conditions().set_load_factor(0.7);
    model.conditions().restore_leaks({0.8, 0.0});
    petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
    const system::GasState rest = model.conditions().gases()[0].at(model.potential().configuration(a));
    CHECK(rest.pressure == relative(7.1 * std::pow(0.8, exponent) - 5.0).epsilon(1e-12));
    CHECK(std::abs(rest.energy) < 1e-12);
    set_displacement(model, a, noise(0.05, 3));
    set_displacement(model, d, noise(1.0, 4));
    check_potential(model, a, d);
    CHECK_THROWS_AS(model.conditions().restore_leaks({0.8, 0.0, 1.0, 0.0}), UserError);
    CHECK(model.conditions().leaks() == std::vector<double>{0.8, 0.0});
  }
}

TEST_CASE("a vessel empties and fills as the closed form has it, and no more once the pressures are equal") {
  // At constant temperature x = p/p_a obeys x' = -k sqrt(x (x - 1)), k = A/V sqrt(2 p_a/r): 2x - 1 = cosh(C - k t).
  const system::LeakyGas air{1e5, 1.5e5, 1.0, 2.0, 1e-3, 1.2};
  const double k = 1e-3 / 2.0 * std::sqrt(2e5 / 1.2), whole = std::acosh(2.0);
  for (const double part : {0.1, 0.5, 0.9, 0.999}) {
    const double exact = 0.5 * (1.0 + std::cosh(whole * (1.0 - part))) / 1.5;
    double content = 1.0;
    for (int i = 0; i < 50; ++i) content = system::content_after(air, content, 2.0, part * whole / k / 50);
    CHECK(content == relative(exact).epsilon(1e-9));
    CHECK(system::content_after(air, 1.0, 2.0, part * whole / k) == relative(exact).epsilon(1e-6));
  }
  CHECK(system::content_after(air, 1.0, 2.0, 1.1 * whole / k) == relative(1.0 / 1.5).epsilon(1e-12));
  CHECK(system::content_after(air, 1.0 / 1.5, 2.0, 1.0) == relative(1.0 / 1.5).epsilon(1e-12));
  // Air at p_a flows in with y = sqrt(1 - x), y' = -k/2.
  const system::LeakyGas thin{1e5, 0.8e5, 1.0, 2.0, 1e-3, 1.2};
  const double y = std::sqrt(0.2) - 0.5 * k * 0.3;
  CHECK(system::content_after(thin, 1.0, 2.0, 0.3) == relative((1.0 - y * y) / 0.8).epsilon(1e-12));
  CHECK(system::content_after(air, 1.0, 2.0, 0.0) == 1.0);
}

TEST_CASE("what a gas could still do falls by its work, and by its leak") {
  for (const double exponent : {1.0, 1.4}) {
    const system::LeakyGas air{1e5, 1.5e5, exponent, 2.0, 1e-3, 1.2};
    const double volume = 2.3, content = 0.9, h = 1e-5;
    const double pressure = 1.5e5 * std::pow(content * 2.0 / volume, exponent);
    const double slope =
        (system::available_work(air, content, volume + h) - system::available_work(air, content, volume - h)) /
        (2.0 * h);
    CHECK(slope == relative(1e5 - pressure).epsilon(1e-6));
    CHECK(std::abs(system::available_work(air, content, content * 2.0 * std::pow(1.5, 1.0 / exponent))) < 1e-9);
    CHECK(system::available_work(air, content, volume) > system::available_work(air, 0.85, volume));
  }
  const system::LeakyGas air{1e5, 1.5e5, 1.0, 2.0, 1e-3, 1.2};
  CHECK(system::available_work(air, 1.0, 2.0) == relative(2e5 * (1.5 * std::log(1.5) - 0.5)).epsilon(1e-12));
}

TEST_CASE("a gas pushes a rigid group: forces from the energy, tangent from the forces") {
  mesh::MeshData data = ellipsoid(2);
  mesh::Group lid;
  lid.name = "lid";
  lid.dimension = 2;
  for (Index t = 0; t < static_cast<Index>(data.triangles.size()); ++t) {
    const mesh::Triangle& corners = data.triangles[t];
    if (std::any_of(corners.begin(), corners.end(), [&](Index v) { return data.positions[v].z() < 5.3; })) continue;
    lid.triangles.push_back(t);
    lid.vertices.insert(lid.vertices.end(), corners.begin(), corners.end());
  }
  std::sort(lid.vertices.begin(), lid.vertices.end());
  lid.vertices.erase(std::unique(lid.vertices.begin(), lid.vertices.end()), lid.vertices.end());
  REQUIRE(lid.triangles.size() > 3);
  data.groups.push_back(lid);
  const mesh::SurfaceMesh mesh(std::move(data));
  system::ModelInput input = sheet({gas(3.0)});
  system::RigidGroup group;
  group.group = "lid";
  input.rigid = {group};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  model.conditions().set_load_factor(0.7);
  petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
  set_displacement(model, a, noise(0.05, 3));
  set_displacement(model, d, noise(1.0, 4));
  model.dofs().scatter_bodies({0.1, -0.2, 0.15, 0.3, -0.2, 0.25, -0.1, 0.0, 0.0}, a);
  model.dofs().scatter_bodies({0.4, 0.7, -0.3, 0.5, -0.6, 0.2, 0.8, 0.0, 0.0}, d);
  for (const Vec v : {static_cast<Vec>(a), static_cast<Vec>(d)}) model.dofs().clear_fixed(v);
  check_potential(model, a, d);
}

TEST_CASE("volume and pressure of a gas") {
  const mesh::SurfaceMesh closed(ellipsoid(3)), open(ellipsoid(3, 0.0));
  for (const mesh::SurfaceMesh* mesh : {&closed, &open}) {
    system::Model model(PETSC_COMM_WORLD, *mesh, sheet({gas(3.0)}));
    model.conditions().set_load_factor(0.5);
    petsc::VecHandle a = model.dofs().create_vector();
    const auto state = [&] { return model.conditions().gases()[0].at(model.potential().configuration(a)); };
    const system::GasState start = state();
    const double whole = 4.0 / 3.0 * std::numbers::pi * 1.2 * 0.8;
    CHECK(start.volume == relative(mesh == &closed ? whole : 0.5 * whole).epsilon(0.05));
    CHECK(start.pressure == relative(1.5));
    // A turn changes nothing; twice the size is eight times the volume.
    set_displacement(model, a, [&](Index v) {
      const Vec3& x = mesh->positions()[v];
      return Vec3(2.0 * (Eigen::AngleAxisd(1.0, Vec3(1.0, 2.0, 3.0).normalized()) * x) + Vec3(1.0, 2.0, 3.0) - x);
    });
    CHECK(state().volume == relative(8.0 * start.volume));
    CHECK(state().pressure == relative(6.5 * std::pow(8.0, -1.3) - 5.0));
    const double work = 6.5 / 0.3 * (1.0 - std::pow(8.0, -0.3)) - 5.0 * 7.0;
    CHECK(state().energy == relative(-work * start.volume));
  }
}

TEST_CASE("solutions and negative eigenvalues take in what a gas adds") {
  if (mpi::size(PETSC_COMM_WORLD) > 1) return;
  for (const double pressure : {-4.0, 3.0}) {
    const mesh::SurfaceMesh mesh(ellipsoid(1, 0.5));
    system::ModelInput input = sheet({gas(pressure)});
    system::Spring ground;
    ground.kind = system::Spring::Kind::area;
    ground.stiffness = 0.3;
    input.springs = {ground};
    system::Model model(PETSC_COMM_WORLD, mesh, std::move(input));
    model.conditions().set_load_factor(1.0);
    solve::Newton newton(model);
    petsc::VecHandle a = model.dofs().create_vector(), b = model.dofs().create_vector(),
                     x = model.dofs().create_vector(), product = model.dofs().create_vector();
    set_displacement(model, a, noise(0.1, 5));
    set_displacement(model, b, noise(1.0, 6));
    const long found = newton.negative_eigenvalues(a);
    Eigen::MatrixXd full = dense_tangent(model);
    const system::LowRankChange& change = model.tangent().change();
    Eigen::MatrixXd columns(full.rows(), static_cast<Eigen::Index>(change.columns.size()));
    for (std::size_t k = 0; k < change.columns.size(); ++k)
      columns.col(static_cast<Eigen::Index>(k)) =
          Eigen::Map<const Eigen::VectorXd>(petsc::ReadArray(change.columns[k]).data(), full.rows());
    full += columns * change.weights * columns.transpose();
    CHECK(found == (eigenvalues(full).array() < 0.0).count());
    REQUIRE(newton.linear_solver().solve(b, x));
    model.tangent().multiply(x, product);
    VOILE_PETSC(VecAXPY(product, -1.0, b));
    CHECK(norm(product) < 1e-9 * norm(b));
  }
}

TEST_CASE("what encloses no gas is refused") {
  const auto refusal = [](const mesh::MeshData& d, const system::Load& load) {
    try {
      const mesh::SurfaceMesh mesh(d);
      (void)system::gas_surface(mesh, load);
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(refusal(ellipsoid(1), gas(1.0)).empty());
  CHECK(refusal(square(Pattern::diagonal, 3), gas(1.0)).find("encloses no volume") != std::string::npos);
  mesh::MeshData two = ellipsoid(1), more = ellipsoid(1);
  const auto count = static_cast<Index>(two.positions.size());
  for (const Vec3& x : more.positions) two.positions.push_back(x + Vec3(5.0, 0.0, 0.0));
  for (const mesh::Triangle& t : more.triangles) two.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  CHECK(refusal(two, gas(1.0)).find("several parts") != std::string::npos);
  // A flat sheet over a box; one that hangs into it by more than the box has.
  system::Load box = gas(1.0);
  box.added_volume = 0.5;
  CHECK(refusal(square(Pattern::diagonal, 3), box).empty());
  const auto sagging = mapped(square(Pattern::diagonal, 8), [](const Vec3& x) {
    return Vec3(x[0], x[1], -8.0 * x[0] * (1.0 - x[0]) * x[1] * (1.0 - x[1]) * 16.0);
  });
  CHECK(refusal(sagging, box).find("normals must point away") != std::string::npos);
}

}  // namespace test_gas
