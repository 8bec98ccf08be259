// Periodic edges: derivatives, cells cut anywhere, motions without force, one answer on all ranks, mistakes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "system/constraints.hpp"
#include "system/rigid_motions.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_periodic {

using namespace voile;
using namespace voile::testing;
using system::PeriodicPair;

namespace {

constexpr int nx = 5, ny = 24;  // ranks do not see all of it
const Vec3 period_x(1.0, 0.0, 0.3), period_y(0.3, 4.8, 0.0);

int wrapped(int i, int n) {
  return ((i % n) + n) % n;
}
int periods(int i, int n) {
  return (i - wrapped(i, n)) / n;
}

/// A corrugated sheet that repeats itself along x, and on request along y, cut at one of its columns and rows.
struct Cell {
  mesh::MeshData data;
  std::vector<std::array<int, 2>> at;  ///< column and row of each vertex

  Cell(int column, int row, bool both, bool uneven = true) {
    data.source = "cell";
    for (int j = row; j <= row + ny; ++j)
      for (int i = column; i <= column + nx; ++i) {
        at.push_back({i, j});
        const int a = wrapped(i, nx), b = both ? wrapped(j, ny) : j;
        const double s = a + (uneven ? 0.3 : 0.0) * std::sin(3.0 * a + 2.0 * b),
                     t = b + (uneven ? 0.3 : 0.0) * std::cos(2.0 * a - 5.0 * b);
        data.positions.emplace_back((s / nx + periods(i, nx)) * period_x +
                                    (t / ny + (both ? periods(j, ny) : 0)) * period_y +
                                    (uneven ? 0.1 : 0.0) * std::sin(1.7 * a) * std::cos(b) * Vec3::UnitZ());
      }
    const auto vertex = [&](int i, int j) { return static_cast<Index>((j - row) * (nx + 1) + i - column); };
    for (int j = row; j < row + ny; ++j)
      for (int i = column; i < column + nx; ++i) {
        const Index a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
        const bool turned = (wrapped(i, nx) + 2 * wrapped(j, ny)) % 3 == 0;
        data.triangles.push_back(turned ? mesh::Triangle{a, b, d} : mesh::Triangle{a, b, c});
        data.triangles.push_back(turned ? mesh::Triangle{b, c, d} : mesh::Triangle{a, c, d});
      }
    const auto group = [&](const char* name, int count, const auto& of) {
      mesh::Group g{name, 1, {}, {}, {}};
      for (int k = 0; k <= count; ++k) g.vertices.push_back(of(k));
      for (int k = 0; k < count; ++k) g.segments.push_back({of(k), of(k + 1)});
      data.groups.push_back(g);
    };
    group("left", ny, [&](int k) { return vertex(column, row + k); });
    group("right", ny, [&](int k) { return vertex(column + nx, row + k); });
    group("bottom", nx, [&](int k) { return vertex(column + k, row); });
    group("top", nx, [&](int k) { return vertex(column + k, row + ny); });
  }
};

PeriodicPair pair(const char* from, const char* to, bool free) {
  PeriodicPair p;
  p.from = from;
  p.to = to;
  p.held = {!free, !free, !free};
  return p;
}

system::ModelInput input(bool both, bool free = true,
                         energy::BendingOperator bending = energy::BendingOperator::edge_slope) {
  system::ModelInput in;
  in.element.bending = bending;
  in.materials = {isotropic(100.0, 0.3, 0.2, 1.0)};
  in.periodic = {pair("left", "right", free)};
  if (both) in.periodic.push_back(pair("bottom", "top", free));
  return in;
}

const Vec3 stretch_x(0.1, -0.05, 0.07), stretch_y(0.02, 0.08, -0.1);

/// Periodic noise, and differences.
std::function<Vec3(Index)> motion(const Cell& cell, bool both, double size, double stretch, unsigned seed = 3) {
  const auto random = noise(size, seed);
  return [=, &cell](Index v) {
    const auto [i, j] = cell.at[static_cast<std::size_t>(v)];
    const int b = both ? wrapped(j, ny) : j;
    return Vec3(random(100 * wrapped(i, nx) + b) + stretch * periods(i, nx) * stretch_x +
                (both ? stretch * periods(j, ny) * stretch_y : Vec3(Vec3::Zero())));
  };
}

}  // namespace

TEST_CASE("forces of periodic sheets derive from the energy, and the tangent from the forces") {
  for (const bool both : {false, true})
    for (const bool clamped : {false, true})
      for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle}) {
        if (both && clamped) continue;
        CAPTURE(both);
        CAPTURE(clamped);
        CAPTURE(static_cast<int>(bending));
        const Cell cell(0, 0, both);
        const mesh::SurfaceMesh mesh(cell.data);
        system::ModelInput in = input(both, !clamped, bending);
        if (clamped) in.supports = {support("bottom", system::Support::Kind::clamped)};
        in.loads = {load(system::Load::Kind::gravity, "", Vec3(0.3, -0.1, -1.0)),
                    load(system::Load::Kind::line, "right", Vec3(0.1, 0.2, 0.3))};
        if (!clamped) in.periodic[0].force = Vec3(0.2, -0.1, 0.3);
        system::Model model(PETSC_COMM_WORLD, mesh, in);
        model.conditions().set_load_factor(0.7);
        petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
        set_displacement(model, a, motion(cell, both, 0.02, 1.0));
        set_displacement(model, d, motion(cell, both, 1.0, 5.0, 7));
        model.dofs().clear_fixed(d);
        check_potential(model, a, d, 1e-6);
      }
}

TEST_CASE("displacements of a periodic sheet come back as they were") {
  const Cell cell(0, 0, true);
  const mesh::SurfaceMesh mesh(cell.data);
  system::Model model(PETSC_COMM_WORLD, mesh, input(true));
  petsc::VecHandle a = model.dofs().create_vector();
  const auto u = motion(cell, true, 0.1, 1.0);
  set_displacement(model, a, u);
  const std::vector<Vec3> found = per_vertex(model, a);
  double wrong = 0.0;
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    wrong = std::max(wrong, (found[static_cast<std::size_t>(v)] - u(v)).norm());
  CHECK(wrong < 1e-15);
}

TEST_CASE("what a periodic sheet stores does not depend on where the cell is cut") {
  enum class Sides { periodic, free, held };
  for (const Sides sides : {Sides::periodic, Sides::free, Sides::held})
    for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle}) {
      const bool both = sides == Sides::periodic, held = sides == Sides::held;
      CAPTURE(static_cast<int>(sides));
      CAPTURE(static_cast<int>(bending));
      std::vector<double> membrane, bent;
      for (const std::array<int, 2>& cut : {std::array{0, 0}, std::array{2, 0}, std::array{-1, both ? 3 : 0}}) {
        // At free edges of uneven meshes fits depend on the order of triangles, with or without a period.
        const Cell cell(cut[0], cut[1], both, both);
        const mesh::SurfaceMesh mesh(cell.data);
        system::ModelInput in = input(both, !held, bending);
        if (held)
          in.supports = {support("bottom", system::Support::Kind::clamped),
                         support("top", system::Support::Kind::symmetry)};
        system::Model model(PETSC_COMM_WORLD, mesh, in);
        petsc::VecHandle a = model.dofs().create_vector();
        set_displacement(model, a, motion(cell, both, 0.02, 1.0));
        const system::Energies e = system::energies(model, a);
        membrane.push_back(e.membrane);
        bent.push_back(e.bending);
      }
      CHECK(bent[0] > 0.0);
      for (std::size_t k = 1; k < membrane.size(); ++k) {
        CHECK(membrane[k] == relative(membrane[0]).epsilon(1e-12));
        CHECK(bent[k] == relative(bent[0]).epsilon(1e-12));
      }
    }
}

TEST_CASE("a rigid motion of a periodic sheet leaves no force, and only a free difference lets it turn") {
  const Cell cell(0, 0, false);
  const mesh::SurfaceMesh mesh(cell.data);
  system::Model model(PETSC_COMM_WORLD, mesh, input(false));
  const Mat3 r = Eigen::AngleAxisd(2.5, Vec3(0.3, 1.0, -0.2).normalized()).toRotationMatrix();
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) { return Vec3((r - Mat3::Identity()) * mesh.positions()[v]); });
  model.unbalanced_force(a, f);
  CHECK(norm(f) < 1e-11 * 20.0);  // of the membrane stiffness [N]
  CHECK(std::abs(model.energy(a)) < 1e-11);
  const auto motions = [&](bool free) {
    const system::Model other(PETSC_COMM_WORLD, mesh, input(false, free));
    const auto pieces = system::free_pieces(mesh, other.discretisation().constraints(), {});
    REQUIRE(pieces.size() == 1);
    return std::array{pieces[0].translations, pieces[0].rotations};
  };
  CHECK(motions(true) == std::array{3, 3});
  CHECK(motions(false) == std::array{3, 1});  // about the period
}

TEST_CASE("a cell that is stretched has the same stress everywhere") {
  mesh::MeshData data = square(Pattern::jittered, 6);
  const mesh::SurfaceMesh mesh(data);
  system::ModelInput in = input(true, false);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
  Mat3 gradient = Mat3::Zero();
  gradient << 0.1, 0.05, 0.0, 0.02, -0.03, 0.0, 0.0, 0.0, 0.0;
  set_displacement(model, a, [&](Index v) { return Vec3(gradient * mesh.positions()[v]); });
  model.unbalanced_force(a, r);
  // The force that holds a difference is the stress times the width, P e_x: energy over stretch.
  std::vector<double> held = system::periodic_values(model.discretisation(), a, r);
  model.dofs().clear_fixed(r);
  CHECK(norm(r) < 1e-13 * 20.0);
  mpi::broadcast(PETSC_COMM_WORLD, held);
  const auto energy_at = [&](const Mat3& g) {
    set_displacement(model, a, [&](Index v) { return Vec3(g * mesh.positions()[v]); });
    return model.energy(a);
  };
  constexpr double h = 1e-6;
  for (int pair = 0; pair < 2; ++pair)
    for (int k = 0; k < 2; ++k) {
      Mat3 up = gradient, down = gradient;
      up(k, pair) += h;
      down(k, pair) -= h;
      const auto at = static_cast<std::size_t>(6 * pair + k);
      CHECK(held[at] == doctest::Approx(gradient(k, pair)));
      CHECK(held[at + 3] == relative((energy_at(up) - energy_at(down)) / (2.0 * h)).epsilon(1e-7));
    }
}

TEST_CASE("periodic sheets are the same on all ranks as on one") {
  for (const bool both : {false, true}) {
    const Cell cell(0, 0, both);
    const mesh::SurfaceMesh mesh(cell.data);
    const auto answer = [&](MPI_Comm comm) {
      system::ModelInput in = input(both, both);
      if (!both) in.supports = {support("bottom", system::Support::Kind::clamped)};
      in.loads = {load(system::Load::Kind::line, "right", Vec3(0.1, 0.2, 0.3))};
      in.loads.emplace_back();
      in.loads.back().kind = system::Load::Kind::follower_pressure;
      in.loads.back().magnitude = 0.4;
      system::Model model(comm, mesh, in);
      model.conditions().set_load_factor(0.7);
      petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                       r = model.dofs().create_vector();
      set_displacement(model, a, motion(cell, both, both ? 0.02 : 0.3, 1.0));  // clamps are folded over
      set_displacement(model, d, motion(cell, both, 1.0, 5.0, 7));
      std::vector<double> all;
      const auto take = [&](Vec v) {
        std::vector<double> part = model.dofs().gather_forces(v);
        mpi::broadcast(comm, part);
        all.insert(all.end(), part.begin(), part.end());
      };
      model.residual(a, r);
      take(r);
      model.assemble_tangent(a, {.kind = energy::Tangent::exact});
      VOILE_PETSC(MatMult(model.tangent().matrix(), d, r));
      take(r);
      const system::BlockMatrix mass = model.potential().constant().consistent_mass();
      VOILE_PETSC(MatMult(mass.mat(), d, r));
      take(r);
      std::vector<double> moments = model.triangle_fields(a).bending_moment;
      mpi::broadcast(comm, moments);
      CHECK(moments.size() == 3 * static_cast<std::size_t>(mesh.triangle_count()));
      all.insert(all.end(), moments.begin(), moments.end());
      all.push_back(model.energy(a));
      return all;
    };
    check_ranks_agree(answer);
  }
}

TEST_CASE("the mass of a periodic sheet is that of its vertices") {
  const Cell cell(0, 0, true);
  const mesh::SurfaceMesh mesh(cell.data);
  system::Model model(PETSC_COMM_WORLD, mesh, input(true));
  petsc::VecHandle v = model.dofs().create_vector(), mv = model.dofs().create_vector();
  const auto u = motion(cell, true, 1.0, 2.0);
  set_displacement(model, v, u);
  double twice = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (const Index i : mesh.triangles()[t])
      for (const Index j : mesh.triangles()[t]) twice += mesh.area(t) / 12.0 * (i == j ? 2.0 : 1.0) * u(i).dot(u(j));
  const system::BlockMatrix mass = model.potential().constant().consistent_mass();
  VOILE_PETSC(MatMult(mass.mat(), v, mv));
  CHECK(dot(mv, v) == relative(twice).epsilon(1e-12));
}

TEST_CASE("forces on vertices of a periodic sheet do the work of all their displacements") {
  const Cell cell(0, 0, true);
  const mesh::SurfaceMesh mesh(cell.data);
  system::ModelInput in = input(true);
  in.loads = {load(system::Load::Kind::line, "right", Vec3(0.1, 0.2, 0.3)),
              load(system::Load::Kind::area, "", Vec3(-0.4, 0.3, 0.1))};
  in.periodic[1].force = Vec3(0.5, -0.2, 0.7);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  model.conditions().set_load_factor(1.0);
  const auto u = motion(cell, true, 0.1, 1.0);
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                   none = model.dofs().create_vector();
  set_displacement(model, a, u);
  std::vector<double> forces(static_cast<std::size_t>(model.dofs().unknowns()), 0.0);
  double work = in.periodic[1].force.dot(stretch_y);
  Vec3 sum = Vec3::Zero();
  for (const system::Load& l : in.loads)
    system::spread(model.discretisation(), l, [&](Index v, const Vec3& on) {
      for (int k = 0; k < 3; ++k) forces[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(k)] += on[k];
      work += on.dot(u(v));
      sum += on;
    });
  model.unbalanced_force(none, f);
  CHECK(-dot(f, a) == relative(work).epsilon(1e-12));
  model.dofs().scatter_forces(forces, f);
  CHECK(dot(f, a) == relative(work - in.periodic[1].force.dot(stretch_y)).epsilon(1e-12));
  std::vector<double> all = model.dofs().gather_forces(f);
  mpi::broadcast(PETSC_COMM_WORLD, all);
  for (std::size_t i = 0; i < all.size(); ++i) sum[static_cast<Eigen::Index>(i % 3)] -= all[i];
  CHECK(sum.norm() < 1e-12);
}

TEST_CASE("a sheet without periodic edges has one sheet") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 3));
  system::ModelInput in = input(false);
  in.periodic.clear();
  const system::Model model(PETSC_COMM_WORLD, mesh, in);
  CHECK(&model.discretisation().element_sheet() == &model.discretisation().sheet());
}

TEST_CASE("a support may hold less of a vertex than of the one that it repeats") {
  const Cell cell(0, 0, false);
  const mesh::SurfaceMesh mesh(cell.data);
  system::ModelInput in = input(false, false);
  in.supports = {support("bottom", system::Support::Kind::displacement),
                 support("left", system::Support::Kind::displacement)};
  in.supports[0].components = {true, false, true};
  in.supports[1].components = {false, true, false};
  CHECK_NOTHROW(system::Model(PETSC_COMM_WORLD, mesh, in));
  in.supports[1].group = "right";
  CHECK_THROWS_AS(system::Model(PETSC_COMM_WORLD, mesh, in), UserError);
}

TEST_CASE("what no periodic edges can be is refused by name") {
  Cell cell(0, 0, false);
  const auto refused = [&](const system::ModelInput& in, const std::string& text) {
    CAPTURE(text);
    std::string message;
    try {
      const mesh::SurfaceMesh mesh(cell.data);
      system::Model model(PETSC_COMM_WORLD, mesh, in);
    } catch (const UserError& e) {
      message = e.what();
    }
    CAPTURE(message);
    CHECK(message.find("[[periodic]]") != std::string::npos);
    CHECK(message.find(text) != std::string::npos);
  };
  system::ModelInput in = input(false);
  in.periodic[0].from = "nowhere";
  refused(in, "there is no curve group 'nowhere'");
  in = input(false);
  in.periodic[0].to = "top";
  refused(in, "has 25 vertices and 'top' has 6");
  in = input(true);
  refused(in, "lies ");  // not periodic along y
  in = input(false);
  in.periodic.push_back(in.periodic[0]);
  refused(in, "belongs to the pair 'left', 'right' too");
  in = input(false, false);
  in.supports = {support("right", system::Support::Kind::hinged)};
  refused(in, "otherwise than the vertex that it repeats");
  in = input(false, true);
  in.supports = {support("bottom", system::Support::Kind::hinged)};
  refused(in, "prescribe that component of `difference`");
  in = input(false, false);
  in.supports = {support("bottom", system::Support::Kind::hinged)};
  in.periodic[0].difference = Vec3(0.1, 0.0, 0.0);
  refused(in, "is not that of the vertex it repeats and `difference`");
  in = input(false);
  in.supports = {support("left", system::Support::Kind::clamped)};
  refused(in, "holds the slope of the edge");
  cell.data.groups[1].vertices.back() = cell.data.groups[0].vertices.back();
  cell.data.groups[1].segments.pop_back();
  std::sort(cell.data.groups[1].vertices.begin(), cell.data.groups[1].vertices.end());
  refused(input(false), "is on both curves");
  cell = Cell(0, 0, false);
  cell.data.groups[1].segments.pop_back();
  refused(input(false), "has no image in 'right'");
  cell = Cell(0, 0, false);
  cell.data.positions[static_cast<std::size_t>(cell.data.groups[1].vertices[2])] += Vec3(0.0, 1e-3, 0.0);
  refused(input(false), "of 'left', moved by (1, ");
}

}  // namespace test_periodic
