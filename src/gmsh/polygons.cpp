#include "polygons.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

#include "base/bytes.hpp"
#include "formats/gmsh_polygon.hpp"
#include "session.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

constexpr int frontal_delaunay = 6;  // Gmsh's number

/// Each side is a curve of one element, so that Gmsh cannot divide it.
void add_polygon(const Polygon& p) {
  namespace geo = gmsh::model::geo;
  gmsh::model::add(p.name);
  std::vector<int> loops, all;
  int point = 0;
  for (const std::vector<Vec2>& loop : p.loops) {
    const int first = point + 1;
    for (const Vec2& x : loop) geo::addPoint(x[0], x[1], 0.0, p.size, ++point);
    std::vector<int> lines;
    for (int i = first; i <= point; ++i) lines.push_back(geo::addLine(i, i < point ? i + 1 : first));
    loops.push_back(geo::addCurveLoop(lines));
    all.insert(all.end(), lines.begin(), lines.end());
  }
  std::vector<int> inside;
  for (const Vec2& x : p.inside) inside.push_back(geo::addPoint(x[0], x[1], 0.0, p.size, ++point));
  std::swap(loops.front(), loops[p.outline]);  // Gmsh takes the first for the outline
  const int surface = geo::addPlaneSurface(loops);
  geo::synchronize();
  if (!inside.empty()) gmsh::model::mesh::embed(0, inside, 2, surface);
  for (const int line : all) gmsh::model::mesh::setTransfiniteCurve(line, 2);
}

Triangulation take_mesh(const Polygon& p) {
  Triangulation t;
  std::map<std::size_t, Index> number;
  std::vector<std::size_t> tags;
  std::vector<double> x, parameters;
  const auto take = [&](int dimension, int entity) {
    gmsh::model::mesh::getNodes(tags, x, parameters, dimension, entity);
    for (std::size_t k = 0; k < tags.size(); ++k) {
      number[tags[k]] = static_cast<Index>(t.points.size());
      t.points.emplace_back(x[3 * k], x[3 * k + 1]);
    }
  };
  std::vector<Vec2> corners;
  for (const std::vector<Vec2>& loop : p.loops) corners.insert(corners.end(), loop.begin(), loop.end());
  corners.insert(corners.end(), p.inside.begin(), p.inside.end());
  for (std::size_t i = 0; i < corners.size(); ++i) take(0, static_cast<int>(i) + 1);
  if (t.points.size() != corners.size()) return {};
  t.points = corners;
  take(2, -1);
  std::vector<std::size_t> elements, nodes;
  gmsh::model::mesh::getElementsByType(triangle_type, elements, nodes);
  for (std::size_t k = 0; k + 2 < nodes.size(); k += 3) {
    mesh::Triangle v{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = number.find(nodes[k + i]);
      if (at == number.end()) return {};  // a node on a side
      v[i] = at->second;
    }
    const Vec2 a = t.points[v[1]] - t.points[v[0]], b = t.points[v[2]] - t.points[v[0]];
    if (a[0] * b[1] - a[1] * b[0] < 0.0) std::swap(v[1], v[2]);
    t.triangles.push_back(v);
  }
  return t;
}

Triangulation fill(const std::string& source, const Polygon& p) {
  Triangulation t;
  try {
    gmsh::option::setNumber("Mesh.MeshSizeMax", p.size);
    add_polygon(p);
    gmsh::model::mesh::generate(2);
    t = take_mesh(p);
    gmsh::model::remove();
  } catch (const std::string&) {  // what Gmsh throws
    t = {};
  }
  if (t.triangles.empty())
    throw UserError(fmt::format(
        "{}: {} cannot be meshed: its outline with cells of {:.4g} m is not one that Gmsh can fill; look for "
        "nearly touching edges, or change its size of cells",
        source, p.name, p.size));
  return t;
}

}  // namespace

std::string fill_polygons(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  ByteReader in(std::string(std::istreambuf_iterator<char>(stream), {}));
  std::string source;
  std::size_t count = 0;
  in.get(source);
  in.get(count);
  ByteWriter out;
  const Session session(Rights::confined);
  gmsh::option::setNumber("Mesh.Algorithm", frontal_delaunay);
  for (std::size_t k = 0; k < count; ++k) {
    Polygon p;
    in.get(p.name);
    in.get(p.loops);
    in.get(p.outline);
    in.get(p.size);
    in.get(p.inside);
    const Triangulation t = fill(source, p);
    out.put(t.points);
    out.put(t.triangles);
  }
  return out.take();
}

}  // namespace voile::formats
