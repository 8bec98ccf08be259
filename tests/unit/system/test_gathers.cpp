// Gathers: rest lengths beside a seam of unequal sides, what they leave alone, and how they are drawn in.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "energy/sheet.hpp"
#include "mesh/gathers.hpp"
#include "mesh/weld.hpp"
#include "test_charts_kit.hpp"
#include "test_model_kit.hpp"

namespace test_gathers {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::charts;

namespace {

constexpr int cells = 12;

/// A yoke, 1 wide, and above it a ruffle `ratio` times as wide, both half as high; cells of 1/12 of either width, or divided
/// into `fine` each way. They lie flat as they are cut.
mesh::MeshData yoke_and_ruffle(double ratio, double jitter = 0.0, int fine = 1) {
  const int around = fine * cells, rows = around / 2;
  const double step = 1.0 / around;
  mesh::MeshData d;
  d.source = "ruffle";
  mesh::Group line{mesh::seam_group("gather"), 1, {}, {}, {}};
  d.seams = {{"gather", {}, {}}};
  Index first[2];
  for (const int piece : {0, 1}) {
    const double width = piece == 0 ? 1.0 : ratio;
    mesh::MeshData part = mapped(grid(around, rows, true, jitter, 3), [&](const Vec3& x) {
      return Vec3(width * x[0], piece == 0 ? rows * step * (x[1] - 1.0) : 0.2 + ratio * rows * step * x[1], 0.0);
    });
    first[piece] = static_cast<Index>(d.positions.size());
    mesh::Group whole{piece == 0 ? "yoke" : "ruffle", 2, {}, {}, {}};
    for (const mesh::Triangle& t : part.triangles) {
      whole.triangles.push_back(static_cast<Index>(d.triangles.size()));
      d.triangles.push_back({t[0] + first[piece], t[1] + first[piece], t[2] + first[piece]});
      d.rest.push_back({part.positions[t[0]], part.positions[t[1]], part.positions[t[2]]});
    }
    for (std::size_t v = 0; v < part.positions.size(); ++v)
      whole.vertices.push_back(first[piece] + static_cast<Index>(v));
    d.positions.insert(d.positions.end(), part.positions.begin(), part.positions.end());
    d.groups.push_back(whole);
  }
  std::array<std::vector<Index>, 2> sides;
  for (Index v = 0; v < static_cast<Index>(d.positions.size()); ++v) {
    if (v < first[1] && std::abs(d.positions[v][1]) < 1e-9) sides[0].push_back(v);
    if (v >= first[1] && std::abs(d.positions[v][1] - 0.2) < 1e-9) sides[1].push_back(v);
  }
  for (std::vector<Index>& side : sides) {
    std::sort(side.begin(), side.end(), [&](Index v, Index w) { return d.positions[v][0] < d.positions[w][0]; });
    REQUIRE(static_cast<int>(side.size()) == around + 1);
    for (std::size_t i = 0; i + 1 < side.size(); ++i) line.segments.push_back({side[i], side[i + 1]});
    line.vertices.insert(line.vertices.end(), side.begin(), side.end());
  }
  for (std::size_t i = 0; i < sides[0].size(); ++i) {
    d.seams[0].pairs.push_back({sides[0][i], sides[1][i]});
    d.seams[0].lengths.push_back(0.5 * step * (1.0 + ratio));
  }
  std::sort(line.vertices.begin(), line.vertices.end());
  d.groups.push_back(line);
  return d;
}

mesh::MeshData welded(const mesh::MeshData& open) {
  std::vector<Vec3> places = open.positions;
  for (const auto& [v, w] : open.seams[0].pairs) places[w] = places[v];
  return mesh::weld(open, {"gather"}, places, std::vector<double>(places.size(), 1.0)).data;
}

double side_length(const mesh::SurfaceMesh& m, Index t, int s) {
  return (m.rest_corner(t, (s + 1) % 3) - m.rest_corner(t, (s + 2) % 3)).norm();
}

double longest_side(const mesh::SurfaceMesh& m, Index t) {
  return std::max({side_length(m, t, 0), side_length(m, t, 1), side_length(m, t, 2)});
}

system::ModelInput fabric(double gather_from) {
  system::ModelInput in = free_sheet(0.3);
  in.seams = {{"gather", 1.0, 0.0, gather_from}};
  return in;
}

system::ModelInput sewing(double gather_from) {
  system::ModelInput in = fabric(gather_from);
  in.sewing = {{"all"}, 1e-3, 0.5, 1e-3, 1.0};
  return in;
}

constexpr double usual = 1.25, never = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("gathered: the seam is as long as its shorter side, neighbours agree, what is far away stays") {
  for (const double ratio : {1.5, 2.0, 3.0})
    for (const bool is_welded : {false, true}) {
      const mesh::MeshData open = yoke_and_ruffle(ratio, 0.2);
      const mesh::SurfaceMesh cut(is_welded ? welded(open) : open);
      const std::optional<mesh::Gathered> gathered = mesh::gathered(cut, {{"gather", usual}});
      REQUIRE(gathered);
      CHECK(gathered->seams == std::vector<std::string>{"gather"});
      const mesh::SurfaceMesh drawn(gathered->mesh);
      for (const mesh::Segment& e : cut.group(mesh::seam_group("gather"), 1).segments)
        for (const Index t : cut.triangles_of_vertex(e[0]))
          if (const int s = cut.side_of(t, e[0], e[1]); s >= 0)
            CHECK(side_length(drawn, t, s) == doctest::Approx(1.0 / cells).epsilon(1e-12));
      Index changed = 0;
      for (Index t = 0; t < cut.triangle_count(); ++t) {
        const bool is_yoke = t < static_cast<Index>(cut.triangle_count() / 2);
        bool is_same = true;
        for (int s = 0; s < 3; ++s) {
          is_same = is_same && side_length(drawn, t, s) == side_length(cut, t, s);
          CHECK(side_length(drawn, t, s) <= side_length(cut, t, s) * (1.0 + 1e-12));
          if (cut.neighbour(t, s) == no_index) continue;
          CHECK(drawn.chart_join(t, s).stretch == doctest::Approx(1.0).epsilon(1e-9));
        }
        if (is_yoke) CHECK(is_same);
        changed += is_same ? 0 : 1;
        CHECK(drawn.rest_normal(t).dot(cut.rest_normal(t)) > 1.0 - 1e-12);
        const double y = (cut.rest_corner(t, 0)[1] + cut.rest_corner(t, 1)[1] + cut.rest_corner(t, 2)[1]) / 3.0 - 0.2;
        if (y > 4.0 * ratio / cells) CHECK(is_same);
      }
      CHECK(changed > 2 * cells);
    }
}

TEST_CASE("gathered: a finer mesh, open or welded, gathers the same fabric where the first one has said how wide") {
  const double ratio = 2.0, width = 3.0 * 0.5 * std::sqrt(3.0) * ratio / cells,
               gathers_away = 0.5 * ratio * 0.5 * width;
  const mesh::SurfaceMesh first(yoke_and_ruffle(ratio));
  const std::vector<system::SeamRule> general{{"", 0.5, 0.01, usual}},
      own{{"", 1.0, 0.0, never}, {"gather", 0.5, 0.01, usual}};
  for (const std::vector<system::SeamRule>& given : {general, own}) {
    const std::vector<system::SeamRule> rules = system::with_gather_widths(given, first);
    REQUIRE(rules.size() == 2);
    CHECK(rules[0].gather_width == 0.0);
    CHECK(rules[1].seam == "gather");
    CHECK(rules[1].bending == 0.5);
    CHECK(rules[1].allowance == 0.01);
    CHECK(rules[1].gather_width == doctest::Approx(width).epsilon(1e-12));
    for (const int fine : {1, 2, 4})
      for (const bool is_welded : {false, true}) {
        const mesh::MeshData open = yoke_and_ruffle(ratio, 0.0, fine);
        const mesh::SurfaceMesh cut(is_welded ? welded(open) : open);
        const auto lost = [&](const std::vector<mesh::Gather>& seams) {
          const mesh::SurfaceMesh drawn(mesh::gathered(cut, seams)->mesh);
          double area = 0.0;
          for (Index t = 0; t < cut.triangle_count(); ++t) area += cut.area(t) - drawn.area(t);
          return area;
        };
        CHECK(lost(system::gathers(cut, {rules, {"all"}})) == doctest::Approx(gathers_away).epsilon(0.05));
        if (fine > 1) CHECK(lost({{"gather", usual}}) < 0.6 * gathers_away);
      }
  }
  CHECK(system::with_gather_widths(general, mesh::SurfaceMesh(yoke_and_ruffle(1.2))).size() == 1);
  CHECK(system::with_gather_widths({{"", 1.0, 0.0, never}}, first).size() == 1);
}

TEST_CASE("gathered: nothing where the sides are alike, where it is not wanted, or no seam of that name") {
  const mesh::SurfaceMesh eased(yoke_and_ruffle(1.2)), ruffle(yoke_and_ruffle(2.0));
  CHECK_FALSE(mesh::gathered(eased, {{"gather", usual}}));
  CHECK(mesh::gathered(eased, {{"gather", 1.0 + 1e-9}}));
  CHECK_FALSE(mesh::gathered(ruffle, {{"other", usual}}));
  CHECK_FALSE(mesh::gathered(ruffle, {}));
  const std::vector<system::SeamRule> rules{{"", 1.0, 0.0, usual}, {"gather", 1.0, 0.0, never}};
  CHECK(system::gathers(ruffle, {rules, {"all"}}).empty());
  CHECK(system::gathers(ruffle, {{rules[0]}, {"all"}}).size() == 1);
  CHECK(system::gathers(ruffle, {{rules[0]}, {}}).empty());  // open, and nobody pulls
  CHECK(system::gathers(mesh::SurfaceMesh(welded(yoke_and_ruffle(2.0))), {{rules[0]}, {}}).size() == 1);
}

TEST_CASE("gathered: triangles that would become slim give way, and stay triangles") {
  mesh::MeshData d = yoke_and_ruffle(3.0);
  // The apex of a cell on the seam far to the side: lengths of 1/12, and two that differ by more than that.
  for (Index v = 0; v < static_cast<Index>(d.positions.size()); ++v) {
    const Vec3 x = d.positions[v];
    if (x[1] < 0.3 || x[1] > 0.6) continue;
    const Vec3 moved = x + Vec3(0.5, 0.0, 0.0);
    for (std::size_t t = 0; t < d.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i)
        if (d.triangles[t][i] == v) d.rest[t][i] = moved;
    d.positions[v] = moved;
  }
  const mesh::SurfaceMesh cut(d);
  const std::optional<mesh::Gathered> gathered = mesh::gathered(cut, {{"gather", usual}});
  REQUIRE(gathered);
  const mesh::SurfaceMesh drawn(gathered->mesh);
  for (Index t = 0; t < cut.triangle_count(); ++t) {
    const double longest = longest_side(drawn, t);
    const double own = 2.0 * cut.area(t) / std::pow(longest_side(cut, t), 2);
    CHECK(2.0 * drawn.area(t) > std::min(0.1, 0.98 * own) * longest * longest);
    CHECK(drawn.rest_normal(t)[2] > 0.0);
  }
}

TEST_CASE("gathers weigh and are loaded as the fabric is cut") {
  const mesh::SurfaceMesh mesh(welded(yoke_and_ruffle(2.5)));
  system::ModelInput in = fabric(usual), flat = fabric(never);
  for (system::ModelInput* i : {&in, &flat}) {
    i->materials[0].areal_density = 0.3;
    i->loads = {load(system::Load::Kind::gravity, "", Vec3(0, 0, -9.81)),
                load(system::Load::Kind::area, "ruffle", Vec3(1, 0, 0))};
  }
  system::Model gathers(PETSC_COMM_WORLD, mesh, in), cut(PETSC_COMM_WORLD, mesh, flat);
  CHECK(gathers.discretisation().gathered_seams().size() == 1);
  const std::vector<Vec3> a = per_vertex(gathers, gathers.potential().constant().mass()),
                          b = per_vertex(cut, cut.potential().constant().mass());
  Vec3 total = Vec3::Zero();
  for (std::size_t v = 0; v < a.size(); ++v) {
    CHECK(a[v] == b[v]);
    total += a[v];
  }
  CHECK(total[0] == doctest::Approx(0.3 * (0.5 + 0.5 * 2.5 * 2.5)).epsilon(1e-12));
  const petsc::VecHandle u = gathers.dofs().create_vector(), w = cut.dofs().create_vector();
  set_displacement(gathers, u, [](Index) { return Vec3(1, 0, 1); });
  set_displacement(cut, w, [](Index) { return Vec3(1, 0, 1); });
  for (system::Model* m : {&gathers, &cut}) m->conditions().set_load_factor(1.0);
  CHECK(system::energies(gathers, u).external == doctest::Approx(system::energies(cut, w).external).epsilon(1e-12));
}

TEST_CASE("gathers are drawn in: no energy where they begin, derivatives, the same on any number of ranks") {
  const mesh::SurfaceMesh mesh(yoke_and_ruffle(2.0, 0.2));
  for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::cst}) {
    system::ModelInput in = sewing(usual);
    in.element.membrane = membrane;
    system::Model model(PETSC_COMM_WORLD, mesh, in), alone(PETSC_COMM_SELF, mesh, in);
    const petsc::VecHandle u = model.dofs().create_vector(), a = alone.dofs().create_vector();
    const double scale = model.discretisation().materials()[0].membrane(0, 0);
    double before = 0.0;
    for (const double time : {0.0, 1.0, 1.5, 2.0, 3.0, 9.0}) {
      model.set_time(time);
      alone.set_time(time);
      const double energy = system::energies(model, u).membrane;
      if (time <= 1.0) CHECK(energy < 1e-20 * scale);
      if (time == 1.5) CHECK(energy > 1e-4 * scale);
      CHECK(energy >= before);
      before = energy;
      CHECK(energy == doctest::Approx(system::energies(alone, a).membrane).epsilon(1e-12));
      CHECK(model.potential().drawn_in() >= 0.0);
    }
    CHECK(model.potential().drawn_in() == 1.0);
    model.set_time(2.0);
    const Slopes s = slopes(model, 0.02);
    CHECK(s.force < 1e-8);
    CHECK(s.tangent < 1e-8);
  }
}

TEST_CASE("gathered rows have no strain as a sector of a ring, which is their rest shape") {
  // c(y) = k + (1 - k) y/w is the circumference of a ring at the radius y + k w/(1 - k), over what it was.
  constexpr double ratio = 2.0, k = 1.0 / ratio, step = ratio / cells;
  const double width = 3.0 * 0.5 * std::sqrt(3.0) * step, inner = k * width / (1.0 - k);
  const mesh::SurfaceMesh mesh(yoke_and_ruffle(ratio));
  const auto ring = [&](Index v) {
    const Vec3& x = mesh.positions()[v];
    if (x[1] < 0.1) return Vec3(Vec3::Zero());
    const double angle = x[0] * (1.0 - k) / width, radius = x[1] - 0.2 + inner;
    return Vec3(Vec3(radius * std::sin(angle), radius * std::cos(angle), 0.0) - x);
  };
  const auto strain = [&](double gather_from) {
    system::Model model(PETSC_COMM_WORLD, mesh, sewing(gather_from));
    model.set_time(9.0);
    const petsc::VecHandle u = model.dofs().create_vector();
    set_displacement(model, u, ring);
    const system::TriangleFields fields = model.triangle_fields(u);
    double most = 0.0;
    for (const Index t : mesh.group("ruffle").triangles) {
      bool is_first = true;
      for (int i = 0; i < 3; ++i) is_first = is_first && mesh.rest_corner(t, i)[1] < 0.2 + 1.1 * step;
      for (std::size_t i = 0; i < 3 && is_first && !fields.membrane_strain.empty(); ++i)
        most = std::max(most, std::abs(fields.membrane_strain[3 * static_cast<std::size_t>(t) + i]));
    }
    return most;
  };
  const double gathered = strain(usual), cut = strain(never);
  if (mpi::rank(PETSC_COMM_WORLD) != 0) return;
  CHECK(cut > 0.25);
  CHECK(gathered < 0.02);
}

TEST_CASE("gathers that are welded stay while other seams are pulled") {
  mesh::MeshData d = welded(yoke_and_ruffle(2.0));
  // A seam between two points far from it.
  d.seams = {{"other", {{0, cells}}, {0.1}}};
  d.groups.push_back({mesh::seam_group("other"), 1, {}, {}, {}});
  const mesh::SurfaceMesh mesh(d);
  system::ModelInput in = sewing(usual);
  in.seams = {{"", 1.0, 0.0, usual}};
  system::Model pulled(PETSC_COMM_WORLD, mesh, in);
  in.sewing = {};
  system::Model at_rest(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle u = pulled.dofs().create_vector(), w = at_rest.dofs().create_vector();
  CHECK_FALSE(pulled.discretisation().draws_in());
  for (const double time : {1.0, 1.2, 9.0}) {
    pulled.set_time(time);
    CHECK(system::energies(pulled, u).membrane ==
          doctest::Approx(system::energies(at_rest, w).membrane).epsilon(1e-12));
  }
}

}  // namespace test_gathers
