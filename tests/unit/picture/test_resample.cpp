// Runs that were remeshed, exported on one mesh.
#include <cmath>
#include <numbers>

#include "../test_adapt_kit.hpp"
#include "../test_results_kit.hpp"
#include "extent.hpp"
#include "formats/point_cache.hpp"
#include "picture/export.hpp"
#include "picture/resample.hpp"

namespace test_resample {

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

results::StepFields opened_step(const mesh::SurfaceMesh& mesh, int number) {
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
          {{"displacement", "m", results::Centre::vertex, 3, u}, {"across", "m", results::Centre::triangle, 1, across}},
          {}};
}

/// Rows of a table in CSV, without its heading.
std::vector<std::vector<double>> table(const fs::path& file) {
  std::ifstream in(file);
  std::string line, word;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    for (rows.emplace_back(); std::getline(words, word, ',');) rows.back().push_back(std::stod(word));
  }
  return rows;
}

/// Triangles have the value of the one of the run that they are in: on their own side of the cut, within a `cell` of it.
void check_across(const std::string& files, double cell) {
  const auto vertices = table(files + "_vertices.csv");
  double worst = 0.0;
  bool sides = true;
  for (const std::vector<double>& row : table(files + "_triangles.csv")) {
    double centre = 0.0;
    for (std::size_t i = 1; i < 4; ++i) {
      const std::vector<double>& vertex = vertices[static_cast<std::size_t>(row[i])];
      centre += (vertex[1] - vertex[4]) / 3.0;
    }
    sides = sides && (centre > 0.5) == (row.at(4) > 0.5);
    worst = std::max(worst, std::abs(row[4] - centre));
  }
  CHECK(sides);
  CHECK(worst < cell);
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
  results::ResultsWriter writer = begin(folder.path, first);
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
  const formats::PointCache cache(folder.path / "motion.pc2", 25.0);
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

TEST_CASE("a curved sheet of very different meshes is put on one mesh" * doctest::skip(extent(false, true))) {
  const Folder folder;
  // Three quarters of a closed cylinder of radius 100 m: coarse, very fine in one place, fine in another.
  constexpr double radius = 100.0, turn = 1.5 * std::numbers::pi;
  mesh::MeshData rolled = square(Pattern::union_jack, 12);
  for (Vec3& x : rolled.positions)
    x = Vec3(radius * std::cos(turn * x[0]), 200.0 * x[1], radius * std::sin(turn * x[0]));
  const mesh::SurfaceMesh first(rolled);
  const RestSurface rest(first);
  std::vector<mesh::SurfaceMesh> meshes{first};
  for (const double fine : {0.5, 2.5}) {
    std::vector<double> size;
    const Vec3 there(radius * std::cos(fine), 80.0, radius * std::sin(fine));
    for (const Vec3& x : first.positions()) size.push_back(1.5 + 0.4 * (x - there).norm());
    meshes.emplace_back(adapt::remesh(first, rest, first.positions(), size, {}, {}).mesh);
  }
  results::ResultsWriter writer = begin(folder.path, first);
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    if (k > 0) writer.begin_epoch(meshes[k], ramp(meshes[k].vertex_count()), ramp(meshes[k].triangle_count()));
    const std::vector<double> u(3 * static_cast<std::size_t>(meshes[k].vertex_count()), 0.0);
    const int step = static_cast<int>(k);
    writer.write({step, 0.1 * step, 0.0, {{"displacement", "m", results::Centre::vertex, 3, u}}, {}});
  }
  writer.finish();

  const Recording r(folder.path);
  ExportOptions options{"pc2", folder.path / "motion.pc2", {}, 25.0, true};
  const Exported exported = export_results(r, r.select("all"), options);
  CAPTURE(exported.notes[0]);
  CHECK(has(exported.notes[0], "nothing intersects"));
  // Of a polygon with 12 sides a mesh with much shorter edges cuts the corners.
  CHECK(has(exported.notes[0], "beyond the tolerance"));
  const formats::PointCache cache(folder.path / "motion.pc2", 25.0);
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const std::vector<Vec3> y = cache.positions(0.04 * static_cast<double>(k));
    // Vertices are within the chords of the run's mesh: R - sqrt(R^2 - (L/2)^2) at most, L its longest edge around the axis.
    double off = 0.0, longest = 0.0;
    for (const Vec3& p : y) off = std::max(off, std::abs(std::hypot(p[0], p[2]) - radius));
    for (const mesh::Triangle& t : meshes[k].triangles())
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 edge = meshes[k].positions()[t[i]] - meshes[k].positions()[t[(i + 1) % 3]];
        longest = std::max(longest, std::hypot(edge[0], edge[2]));
      }
    CHECK(off < 1.05 * (radius - std::sqrt(radius * radius - 0.25 * longest * longest)));
  }
}

TEST_CASE("how far one mesh is from those of the run is measured between vertices too") {
  const Folder folder;
  const mesh::SurfaceMesh first(square(Pattern::union_jack, 6));
  std::vector<double> size;
  for (const Vec3& x : first.positions()) size.push_back(0.03 + 0.3 * x[0]);
  const mesh::SurfaceMesh second(adapt::remesh(first, RestSurface(first), first.positions(), size, {}, {}).mesh);
  const auto bent = [](const mesh::SurfaceMesh& mesh) {
    std::vector<double> u;
    for (const Vec3& x : mesh.positions()) u.insert(u.end(), {0.0, 0.0, 0.2 * std::sin(5.0 * x[0] + 3.0 * x[1])});
    return u;
  };
  results::ResultsWriter writer = begin(folder.path, first);
  writer.write({0, 0.0, 0.0, {{"displacement", "m", results::Centre::vertex, 3, bent(first)}}, {}});
  writer.begin_epoch(second, ramp(second.vertex_count()), ramp(second.triangle_count()));
  writer.write({1, 0.1, 0.0, {{"displacement", "m", results::Centre::vertex, 3, bent(second)}}, {}});
  writer.finish();

  const Recording r(folder.path);
  const std::vector<Moment> moments = r.select("all");
  const Resampled one(r, moments, 1.0);
  const geometry::ClosestTriangle search(one.mesh()->data.positions, one.mesh()->data.triangles);
  for (const Moment& moment : moments) {
    const State state = r.state(moment, 1.0);
    const std::vector<Vec3> x = one.positions(state), &start = one.mesh()->data.positions;
    double told = 0.0;
    for (const Resampled::Distance& d : one.distances(state, x)) told = std::max(told, d.length);
    double most = 0.0;
    for (const mesh::Triangle& t : state.mesh->data.triangles)
      for (int i = 0; i <= 8; ++i)
        for (int j = 0; i + j <= 8; ++j) {
          const Vec3 w(i / 8.0, j / 8.0, (8 - i - j) / 8.0);
          Vec3 p = Vec3::Zero(), now = Vec3::Zero(), there = Vec3::Zero();
          for (int k = 0; k < 3; ++k) {
            p += w[k] * state.mesh->data.positions[t[k]];
            now += w[k] * state.positions[t[k]];
          }
          const mesh::Triangle& face = one.mesh()->data.triangles[search.find(p)];
          const Vec3 f = geometry::nearest_weights(p, {start[face[0]], start[face[1]], start[face[2]]});
          for (int k = 0; k < 3; ++k) there += f[k] * x[face[k]];
          most = std::max(most, (there - now).norm());
        }
    CAPTURE(most);
    CHECK(told > 0.85 * most - 1e-12);
  }
}

TEST_CASE("a coarse mesh may lie beside a fine one by more than cells of that" * doctest::skip(extent(false, true))) {
  const Folder folder;
  const auto rolled = [](int cells, double radius) {
    mesh::MeshData data = square(Pattern::union_jack, cells);
    for (Vec3& x : data.positions) x = Vec3(radius * std::cos(3.0 * x[0]), x[1], radius * std::sin(3.0 * x[0]));
    return mesh::SurfaceMesh(data);
  };
  // As after remeshing of a curved start: 0.05 m off, where cells are 0.25 and 0.08 m long.
  const mesh::SurfaceMesh coarse = rolled(12, 1.05), fine = rolled(48, 1.0);
  results::ResultsWriter writer = begin(folder.path, coarse);
  for (const mesh::SurfaceMesh* mesh : {&coarse, &fine}) {
    if (mesh == &fine) writer.begin_epoch(fine, ramp(fine.vertex_count()), ramp(fine.triangle_count()));
    const std::vector<double> u(3 * static_cast<std::size_t>(mesh->vertex_count()), 0.0);
    const int step = mesh == &fine ? 1 : 0;
    writer.write({step, 0.1 * step, 0.0, {{"displacement", "m", results::Centre::vertex, 3, u}}, {}});
  }
  writer.finish();
  const Recording r(folder.path);
  const ExportOptions options{"pc2", folder.path / "motion.pc2", {}, 25.0, true};
  CHECK_NOTHROW((void)export_results(r, r.select("all"), options));
}

TEST_CASE("a sheet on one mesh that meets itself is told") {
  const Folder folder;
  const mesh::SurfaceMesh first(cut_square(4)), second(cut_square(6));
  results::ResultsWriter writer = begin(folder.path, first);
  writer.write(opened_step(first, 0));
  writer.begin_epoch(second, ramp(second.vertex_count()), ramp(second.triangle_count()));
  results::StepFields through = opened_step(second, 1);
  // All of the right part, slanted as it is, is pushed through the left one.
  std::vector<double>& u = through.fields[0].values;
  for (Index t = 0; t < second.triangle_count(); ++t)
    if (through.fields[1].values[t] > 0.5)
      for (const Index v : second.triangles()[t]) u[3 * v] = -0.45, u[3 * v + 2] = 0.3 * second.positions()[v][1] - 0.1;
  writer.write(through);
  writer.finish();
  const Recording r(folder.path);
  ExportOptions options{"pc2", folder.path / "motion.pc2", {}, 25.0, true};
  const std::string note = export_results(r, r.select("all"), options).notes.at(0);
  CAPTURE(note);
  CHECK(has(note, "the sheet intersects in 1 of 2 frames, first at step 1"));
}

TEST_CASE("fields follow onto the one mesh") {
  const Folder folder;
  const mesh::SurfaceMesh first(cut_square(6)), second(cut_square(10));
  results::ResultsWriter writer = begin(folder.path, first);
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
    check_across(folder.path / fmt::format("fields_{}", number), number[5] == '0' ? 1.0 / 6.0 : 0.1);
  }
}

}  // namespace test_resample
