// Runs that were remeshed, exported on one mesh.
#include <cmath>

#include "../test_adapt_kit.hpp"
#include "../test_results_kit.hpp"
#include "voile/io/point_cache.hpp"
#include "voile/picture/export.hpp"

using namespace voile;
using namespace voile::testing;
using namespace voile::picture;

namespace {

/// A unit square that is cut along x = 0.5: the vertices there are there twice.
mesh::MeshData cut_square(int n) {
  mesh::MeshData d = square(Pattern::union_jack, n);
  std::map<Index, Index> twin;
  for (mesh::Triangle& t : d.triangles) {
    const double middle = (d.positions[t[0]][0] + d.positions[t[1]][0] + d.positions[t[2]][0]) / 3.0;
    if (middle < 0.5) continue;
    for (Index& v : t) {
      const Vec3 x = d.positions[v];
      if (std::abs(x[0] - 0.5) > 1e-9) continue;
      if (!twin.contains(v)) {
        twin[v] = static_cast<Index>(d.positions.size());
        d.positions.push_back(x);
      }
      v = twin[v];
    }
  }
  d.groups.clear();
  d.vertex_tags.clear();
  return d;
}

/// Where a vertex goes: the right part is lifted and tilted.
Vec3 opened(const Vec3& x, bool right) {
  return {x[0], x[1], right ? 0.1 + 0.3 * x[1] : 0.0};
}

io::StepFields opened_step(const mesh::SurfaceMesh& mesh, int number) {
  std::vector<double> u(3 * static_cast<std::size_t>(mesh.vertex_count())), across;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const auto& corners = mesh.triangles()[t];
    const double middle =
        (mesh.positions()[corners[0]] + mesh.positions()[corners[1]] + mesh.positions()[corners[2]])[0] / 3.0;
    across.push_back(middle);
    for (const Index v : corners) {
      const Vec3& x = mesh.positions()[v];
      const Vec3 by = opened(x, middle > 0.5) - x;
      std::copy(by.begin(), by.end(), u.begin() + 3 * v);
    }
  }
  return {number,
          0.1 * number,
          0.0,
          {{"displacement", "m", io::Centre::vertex, 3, u}, {"across", "m", io::Centre::triangle, 1, across}},
          {}};
}

}  // namespace

TEST_CASE("a cut sheet that was remeshed is put on one mesh as fine as any of its own") {
  const Folder folder;
  const mesh::SurfaceMesh first(cut_square(10));
  const RestSurface rest(first);
  std::vector<mesh::SurfaceMesh> meshes{first};
  // Fine at the left, then at the right, coarse where it was fine.
  for (const double fine : {0.1, 0.9}) {
    std::vector<double> size;
    for (const Vec3& x : meshes.back().positions()) size.push_back(0.015 + 0.2 * std::abs(x[0] - fine));
    meshes.emplace_back(adapt::remesh(meshes.back(), rest, meshes.back().positions(), size, {}, {}).mesh);
  }
  io::ResultsWriter writer = begin(folder.path, first);
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    if (k > 0) writer.begin_epoch(meshes[k], ramp(meshes[k].vertex_count()), ramp(meshes[k].triangle_count()));
    writer.write(opened_step(meshes[k], static_cast<int>(k)));
  }
  writer.finish();

  const Recording r(folder.path);
  ExportOptions options{"pc2", folder.path / "motion.pc2", {}, 25.0, true};
  const Exported exported = export_results(r, r.select("all"), options);
  REQUIRE(exported.notes.size() == 1);
  CAPTURE(exported.notes[0]);
  CHECK(has(exported.notes[0], "nothing intersects"));
  const io::PointCache cache(folder.path / "motion.pc2", 25.0);
  REQUIRE(cache.frame_count() == 3);
  Index most = 0;
  for (const mesh::SurfaceMesh& m : meshes) most = std::max(most, m.vertex_count());
  CHECK(cache.vertex_count() > most);
  const std::vector<Vec3> x = cache.positions(0.0);
  Index lifted = 0, left = 0;
  for (const double time : {0.0, 0.04, 0.08}) {
    const std::vector<Vec3> y = cache.positions(time);
    double moved = 0.0, off = 0.0;
    for (std::size_t v = 0; v < y.size(); ++v) {
      // The same material point in all frames, on the surface, and on its own side of the cut.
      moved = std::max(moved, (y[v] - x[v]).norm());
      const double down = (opened(y[v], false) - y[v]).norm(), up = (opened(y[v], true) - y[v]).norm();
      off = std::max(off, y[v][0] < 0.499 ? down : y[v][0] > 0.501 ? up : std::min(up, down));
      if (std::abs(y[v][0] - 0.5) < 1e-6) (up < down ? lifted : left) += 1;
    }
    CHECK(moved < 1e-6);
    CHECK(off < 1e-6);
  }
  CHECK(lifted == left);
  CHECK(lifted > 60);
}

TEST_CASE("fields follow onto the one mesh") {
  const Folder folder;
  const mesh::SurfaceMesh first(cut_square(6)), second(cut_square(10));
  io::ResultsWriter writer = begin(folder.path, first);
  writer.write(opened_step(first, 0));
  writer.begin_epoch(second, ramp(second.vertex_count()), ramp(second.triangle_count()));
  writer.write(opened_step(second, 1));
  writer.finish();
  const Recording r(folder.path);
  ExportOptions options{"csv", folder.path / "fields.csv", {}, 25.0, true, true};
  CHECK(export_results(r, r.select("all"), options).files.size() == 4);
  for (const char* number : {"000000", "000001"}) {
    std::ifstream vertices(folder.path / fmt::format("fields_{}_vertices.csv", number));
    std::string line;
    std::getline(vertices, line);
    Index rows = 0;
    for (; std::getline(vertices, line); ++rows) {
      std::array<double, 7> n{};
      char comma = 0;
      std::istringstream in(line);
      for (double& value : n) in >> value >> comma;
      // Start and displacement together are the place.
      const Vec3 start = Vec3(n[1], n[2], n[3]) - Vec3(n[4], n[5], n[6]);
      CHECK(std::abs(start[2]) < 1e-12);
    }
    CHECK(rows >= second.vertex_count());
  }
}
