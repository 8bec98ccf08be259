// Division of the vertices and triangles over the ranks with METIS.
//
// Every vertex and triangle has one owner. Rows of vectors and matrices are blocks of three per vertex, numbered so
// that each rank's vertices are contiguous and, within a rank, in mesh order. The division depends only on the mesh and
// the number of ranks.
#pragma once

#include <vector>

#include "base/mpi.hpp"
#include "surface_mesh.hpp"

namespace voile::mesh {

struct Partition {
  std::vector<int> vertex_rank;    ///< owner of each vertex
  std::vector<int> triangle_rank;  ///< owner of each triangle: that of most of its vertices
  std::vector<Index> row_of;       ///< block row of each vertex
  std::vector<Index> vertex_of;    ///< vertex of each block row
  std::vector<Index> row_start;    ///< first block row of each rank, and the total at the end
  [[nodiscard]] Index owned_begin(int rank) const { return row_start[rank]; }
  [[nodiscard]] Index owned_count(int rank) const { return row_start[rank + 1] - row_start[rank]; }
};

/// Divides the mesh over the ranks of `comm`. Collective: rank 0 calls METIS, the others receive.
/// Throws UserError if there are more ranks than vertices.
[[nodiscard]] Partition make_partition(MPI_Comm comm, const SurfaceMesh& mesh);

/// Division over a given number of parts without any communication (for reports).
[[nodiscard]] std::vector<int> divide_vertices(const SurfaceMesh& mesh, int parts);

/// The same for any graph in compressed rows, with both directions of every edge and no loops: node v's neighbours are
/// adjacent[start[v]] .. adjacent[start[v + 1] - 1]. Some parts may stay empty. Not collective.
[[nodiscard]] std::vector<int> divide_graph(std::vector<int> start, std::vector<int> adjacent, int parts);

}  // namespace voile::mesh
