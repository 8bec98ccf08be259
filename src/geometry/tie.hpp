// Ties of parts whose meshes do not match: where one ends on another, both are divided along the line.
//
// Symbols   e   tolerance: what is closer lies at the same place [m]
//           h   length of the shortest edge at a vertex [m]
// Parts may also pass through each other (tie_crossing.hpp).
// A vertex of one part that is near a vertex or an edge on the rim of the other (0.3 h) first moves onto it where no shape is
// lost (0.02 h), so that cells stay well shaped. Then triangles are divided at vertices of the other part and where its rim
// crosses their sides. What comes out is one mesh, conforming: nothing of the element's order is lost.
#pragma once

#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

struct Tied {
  Index moved = 0;      ///< onto vertices and edges of another part
  Index vertices = 0;   ///< that lay on edges or in triangles of another part, or where one passes through another
  Index triangles = 0;  ///< that were divided
};

/// What becomes of parts that pass through each other (tie_crossing.hpp).
enum class Crossing { left, joined };

/// Ties parts where vertices hang (hanging_vertices.hpp). Groups follow: what is divided keeps its names. Vertices closer
/// than `tolerance` [m] have to be one already (mesh::merge_coincident); `rims` are edges where parts
/// ended before that. No charts, no open seams. Not collective.
/// Throws UserError if `tolerance` is too large for the triangles.
Tied tie_parts(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment> rims = {},
               Crossing crossing = Crossing::joined);

}  // namespace voile::geometry
