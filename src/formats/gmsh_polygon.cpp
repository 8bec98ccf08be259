#include "gmsh_polygon.hpp"

#include "base/bytes.hpp"
#include "base/child_process.hpp"
#include "message.hpp"

namespace voile::formats {

std::vector<Triangulation> mesh_polygons(const std::string& file, const std::vector<Polygon>& polygons) {
  ByteWriter out;
  out.put(file);
  out.put(polygons.size());
  for (const Polygon& p : polygons) {
    out.put(p.name);
    out.put(p.loops);
    out.put(p.outline);
    out.put(p.size);
    out.put(p.inside);
  }
  const Message message(out.take());
  ByteReader in(run_beside(file, "voile-gmsh", {message.path(), "polygons"}));
  std::vector<Triangulation> all(polygons.size());
  for (Triangulation& t : all) {
    in.get(t.points);
    in.get(t.triangles);
  }
  return all;
}

}  // namespace voile::formats
