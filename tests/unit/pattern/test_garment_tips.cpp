// Two edges of a piece that meet in a corner and are sewn to each other: a bag, a cone.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "mesh/weld.hpp"
#include "test_pattern_kit.hpp"

namespace test_garment_tips {

using namespace voile;
using namespace voile::testing;
using pattern::Panel;

namespace {

/// A triangle whose corner 1 has this angle between legs of 0.3 m.
Panel wedge(double degrees, double size) {
  Panel p = rectangle("A", 0.3, 0.3, size);
  const double a = degrees * std::numbers::pi / 180.0;
  const std::array<Vec2, 3> x{Vec2(0.3 * std::cos(a), 0.3 * std::sin(a)), Vec2(0, 0), Vec2(0.3, 0)};
  p.piece.edges.clear();
  for (std::size_t k = 0; k < 3; ++k) p.piece.edges.push_back({pattern::Curve::bezier({x[k], x[(k + 1) % 3]})});
  return p;
}

/// Vertices - edges + triangles of what a weld leaves.
int characteristic(const mesh::MeshData& welded) {
  std::set<Index> vertices;
  std::set<mesh::Segment> edges;
  for (const mesh::Triangle& t : welded.triangles)
    for (std::size_t s = 0; s < 3; ++s) {
      vertices.insert(t[s]);
      edges.insert(mesh::ascending(t[s], t[(s + 1) % 3]));
    }
  return static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) + static_cast<int>(welded.triangles.size());
}

}  // namespace

TEST_CASE("a corner whose legs are sewn to each other stays open as far as too few cells lie between them") {
  for (const double degrees : {30.0, 60.0, 90.0, 120.0, 150.0})
    for (const double size : {0.03, 0.015}) {
      CAPTURE(degrees);
      CAPTURE(size);
      const Panel p = wedge(degrees, size);
      for (const bool other_way : {false, true}) {
        const pattern::Garment g = pattern::make_garment(
            {p}, {other_way ? seam({"A/1"}, {"A/0"}, {"A@1", "A@1"}) : seam({"A/0"}, {"A/1"}, {"A@1", "A@1"})});
        const std::vector<double> mass(g.mesh.positions.size(), 1.0);
        const mesh::Welded w = mesh::weld(g.mesh, mesh::open_seams(g.mesh, {"all"}), g.mesh.positions, mass);
        const auto cells = static_cast<std::size_t>(std::lround(0.3 / size));
        const bool is_open = g.mesh.seams[0].pairs.size() < cells;
        CHECK(g.mesh.notes.size() == (is_open ? 1 : 0));
        if (is_open) CHECK(has(g.mesh.notes[0], "stay open"));
        CHECK(g.mesh.seams[0].pairs.size() > cells / 4);
        CHECK(is_open == (degrees < 150.0));
        CHECK(characteristic(w.data) == (is_open ? 0 : 1));  // a hole at the tip, or none
        CHECK(mesh::SurfaceMesh(w.data).component_count() == 1);
      }
    }
}

}  // namespace test_garment_tips
