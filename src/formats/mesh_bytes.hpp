// Meshes as bytes for base/child_process.hpp; shared by src/io and the program voile-gmsh.
#pragma once

#include "base/bytes.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::formats {

inline std::string to_bytes(const mesh::MeshData& data) {
  ByteWriter out;
  out.put(data.source);
  out.put(data.positions);
  out.put(data.triangles);
  out.put(data.vertex_tags);
  out.put(data.triangle_tags);
  out.put(data.texture);
  out.put(data.rest);
  out.put(data.notes);
  out.put(data.finds_boundary ? 1 : 0);
  out.put(data.groups.size());
  for (const mesh::Group& g : data.groups) {
    out.put(g.name);
    out.put(g.dimension);
    out.put(g.vertices);
    out.put(g.segments);
    out.put(g.triangles);
  }
  return out.take();
}

inline mesh::MeshData mesh_from_bytes(std::string bytes) {
  ByteReader in(std::move(bytes));
  mesh::MeshData data;
  std::size_t groups = 0;
  int finds_boundary = 0;
  in.get(data.source);
  in.get(data.positions);
  in.get(data.triangles);
  in.get(data.vertex_tags);
  in.get(data.triangle_tags);
  in.get(data.texture);
  in.get(data.rest);
  in.get(data.notes);
  in.get(finds_boundary);
  data.finds_boundary = finds_boundary != 0;
  in.get(groups);
  for (std::size_t k = 0; k < groups; ++k) {
    mesh::Group g;
    in.get(g.name);
    in.get(g.dimension);
    in.get(g.vertices);
    in.get(g.segments);
    in.get(g.triangles);
    data.groups.push_back(std::move(g));
  }
  return data;
}

}  // namespace voile::formats
