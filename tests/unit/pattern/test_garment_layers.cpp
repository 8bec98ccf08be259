// Seams of three layers: nodes, lines and what is refused.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "mesh/weld.hpp"
#include "test_pattern_kit.hpp"

namespace test_garment_layers {

using namespace voile;
using namespace voile::testing;
using pattern::Panel;
using pattern::SeamRequest;

TEST_CASE("an edge in two seams is where three layers meet: all have the same nodes, and become one line") {
  // The upper edge of a skirt between the two layers of its band, of which the outer is divided; finer cells and another length inside.
  const std::vector<Panel> panels{rectangle("skirt", 0.3, 0.2, 0.05),
                                  moved(rectangle("left", 0.11, 0.05, 0.05), {0, 0.2, 0.01}),
                                  moved(rectangle("right", 0.19, 0.05, 0.05), {0.11, 0.2, 0.01}),
                                  moved(rectangle("inner", 0.32, 0.05, 0.02), {0, 0.2, -0.01})};
  const pattern::Garment g = pattern::make_garment(
      panels, {seam({"skirt/2"}, {"right/0", "left/0"}, {"skirt@2", "right@1"}),
               seam({"inner/0"}, {"skirt/2"}, {"inner@0", "skirt@3"}), seam({"left/1"}, {"right/3"})});
  CHECK(std::count_if(g.mesh.notes.begin(), g.mesh.notes.end(), [](const std::string& note) {
          return has(note, "edge skirt/2 is in 2 seams, 'skirt/2-right/0', 'inner/0-skirt/2': 3 layers");
        }) == 1);
  const auto layered = pattern::layered_edges(g);
  REQUIRE(layered.size() == 1);
  CHECK(layered.at("skirt/2").size() == 2);
  const std::vector<double> mass(g.mesh.positions.size(), 1.0);
  const mesh::SurfaceMesh open(g.mesh),
      sewn(mesh::weld(g.mesh, mesh::open_seams(g.mesh, {"all"}), g.mesh.positions, mass).data);
  CHECK(sewn.component_count() == 1);
  const std::size_t cells = open.group("skirt/2", 1).segments.size();
  CHECK(cells == open.group("inner/0", 1).segments.size());
  CHECK(cells == open.group("left/0", 1).segments.size() + open.group("right/0", 1).segments.size());
  CHECK(cells >= 16);
  REQUIRE(sewn.joints().size() == cells);
  // The skirt lies on one side of the line, both bands on the other.
  for (const mesh::Joint& joint : sewn.joints()) {
    REQUIRE(joint.sides.size() == 3);
    for (const mesh::TriangleSide& s : joint.sides) {
      const bool is_skirt = contains(sewn.group("skirt", 2).triangles, s.triangle);
      CHECK(sewn.is_folded(s) != sewn.is_folded(is_skirt ? joint.sides.back() : joint.sides.front()));
    }
  }
  // A seam of its own for each: the line is sewn in any order.
  const auto step = mesh::weld(g.mesh, {"inner/0-skirt/2"}, g.mesh.positions, mass);
  const std::vector<double> left(step.data.positions.size(), 1.0);
  const mesh::SurfaceMesh two(step.data),
      then(mesh::weld(two.data(), mesh::open_seams(two.data(), {"all"}), two.positions(), left).data);
  CHECK(two.joints().empty());
  CHECK(then.joints().size() == cells);
  CHECK(then.vertex_count() == sewn.vertex_count());
}

TEST_CASE("a piece is caught in a part of a seam, and layers that are joined in a circle are refused") {
  std::vector<Panel> panels{rectangle("A", 0.3, 0.2, 0.03), moved(rectangle("B", 0.3, 0.1, 0.03), {0, 0.2, 0}),
                            moved(rectangle("strap", 0.04, 0.3, 0.02), {0.1, 0.2, 0.01})};
  using pattern::Curve;
  auto& edges = panels[0].piece.edges;  // upper edge with points at 0.14 and 0.1 m
  edges.erase(edges.begin() + 2);
  const std::vector<Vec2> x{{0.3, 0.2}, {0.14, 0.2}, {0.1, 0.2}, {0.0, 0.2}};
  for (std::size_t k = 0; k < 3; ++k)
    edges.insert(edges.begin() + 2 + static_cast<std::ptrdiff_t>(k), {Curve::bezier({x[k], x[k + 1]})});
  const SeamRequest line = seam({"A/2", "A/3", "A/4"}, {"B/0"}, {"A@2", "B@1"}),
                    caught = seam({"strap/0"}, {"A/3"}, {"strap@0", "A@4"});
  for (const auto& requests : {std::vector{line, caught}, {caught, line}}) {
    const pattern::Garment g = pattern::make_garment(panels, requests);
    const std::vector<double> mass(g.mesh.positions.size(), 1.0);
    const mesh::SurfaceMesh sewn(mesh::weld(g.mesh, mesh::open_seams(g.mesh, {"all"}), g.mesh.positions, mass).data);
    CHECK(sewn.joints().size() == 2);  // 0.04 m in cells of 0.02 m
    CHECK(sewn.component_count() == 1);
    for (const Vec3& at : sewn.positions()) CHECK(std::abs(at[0] - 0.15) < 0.15 + 1e-12);
    for (const mesh::Joint& joint : sewn.joints())
      for (const Index v : joint.edge) CHECK(std::abs(sewn.positions()[v][0] - 0.12) < 0.02 + 1e-9);
  }
  CHECK(has(refusal_of(panels, {line, caught, seam({"strap/0"}, {"B/0"})}), "more than 4 times"));
  Panel wide = moved(rectangle("C", 0.3, 0.1, 0.03), {0, 0.2, 0.01});
  CHECK(has(refusal_of({panels[0], panels[1], wide}, {line, seam({"B/0"}, {"C/0"}, {"B@0", "C@0"}),
                                                      seam({"A/2", "A/3", "A/4"}, {"C/0"}, {"A@2", "C@1"})}),
            "sewn together twice along one line"));
}

TEST_CASE("a closed band round a skirt: the waist is one line, the top a seam of two, and no piece is twisted") {
  for (const bool is_turned : {false, true}) {
    std::vector<Panel> panels{rectangle("skirt", 0.6, 0.2, 0.05),
                              moved(rectangle("outer", 0.5, 0.1, 0.05), {0, 0.2, -0.01}),
                              moved(rectangle("inner", 0.5, 0.1, 0.05), {0, 0.2, 0.01})};
    panels[2].piece.turned = is_turned;
    std::vector<SeamRequest> seams;
    for (const std::string piece : {"skirt", "outer", "inner"})
      seams.push_back(seam({piece + "/1"}, {piece + "/3"}, {piece + "@1", piece + "@0"}));
    seams.push_back(seam({"skirt/2"}, {"outer/0"}, {"skirt@3", "outer@0"}));
    seams.push_back(seam({"skirt/2"}, {"inner/0"}, {"skirt@3", "inner@0"}));
    seams.push_back(seam({"outer/2"}, {"inner/2"}, {"outer@3", "inner@3"}));
    if (is_turned) {  // the right sides of a tube of both layers cannot agree then
      CHECK(refusal_of(panels, seams).find("twist") == std::string::npos);
      continue;
    }
    const pattern::Garment g = pattern::make_garment(panels, seams);
    const std::vector<Index> joined = mesh::joined_vertices(g.mesh);
    const mesh::SurfaceMesh open(g.mesh);
    const auto line = [&](const std::string& name) {
      std::vector<Index> roots;
      for (const Index v : open.group(name, 1).vertices) roots.push_back(joined[static_cast<std::size_t>(v)]);
      std::sort(roots.begin(), roots.end());
      roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
      return roots;
    };
    CHECK(line("skirt/2") == line("outer/0"));
    CHECK(line("skirt/2") == line("inner/0"));
    CHECK(line("outer/2") == line("inner/2"));
    CHECK(line("skirt/2").size() == 12);  // a ring has as many vertices as cells
    CHECK(g.mesh.folded.size() == 24);    // both layers of the band lie across from the skirt
  }
}

}  // namespace test_garment_layers
