#include "partition.hpp"

#include <fmt/format.h>
#include <metis.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <type_traits>
#include <utility>

#include "voile/errors.hpp"

namespace voile::mesh {

namespace {

/// Vertex adjacency as divide_graph takes it.
void vertex_graph(const SurfaceMesh& mesh, std::vector<int>& start, std::vector<int>& adjacent) {
  start.assign(1, 0);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    std::vector<Index> around;
    for (Index t : mesh.triangles_of_vertex(v))
      for (Index w : mesh.triangles()[t])
        if (w != v) around.push_back(w);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    adjacent.insert(adjacent.end(), around.begin(), around.end());
    start.push_back(static_cast<int>(adjacent.size()));
  }
}

/// The rank that owns two of the three vertices, or else the first vertex's.
int majority(int a, int b, int c) {
  return b == c ? b : a;
}

}  // namespace

std::vector<int> divide_graph(std::vector<int> start, std::vector<int> adjacent, int parts) {
  static_assert(std::is_same_v<idx_t, int>, "METIS with 32-bit indices");
  std::vector<int> part(start.size() - 1, 0);
  if (parts == 1) return part;
  idx_t n = static_cast<idx_t>(part.size()), constraints = 1, cut = 0;
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_NUMBERING] = 0;
  const int status = METIS_PartGraphKway(&n, &constraints, start.data(), adjacent.data(), nullptr, nullptr, nullptr,
                                         &parts, nullptr, nullptr, options.data(), &cut, part.data());
  if (status != METIS_OK) throw InternalError(fmt::format("METIS_PartGraphKway failed with status {}", status));
  return part;
}

std::vector<int> divide_vertices(const SurfaceMesh& mesh, int parts) {
  if (parts > 1 && parts > mesh.vertex_count())
    throw UserError(fmt::format("{} ranks for {} vertices; use fewer ranks", parts, mesh.vertex_count()));
  std::vector<int> start, adjacent;
  vertex_graph(mesh, start, adjacent);
  return divide_graph(std::move(start), std::move(adjacent), parts);
}

Partition make_partition(MPI_Comm comm, const SurfaceMesh& mesh) {
  Partition p;
  const int ranks = mpi::size(comm);
  std::vector<Index> owner;
  mpi::on_root(comm, [&] {
    const std::vector<int> part = divide_vertices(mesh, ranks);
    owner.assign(part.begin(), part.end());
  });
  mpi::broadcast(comm, owner);
  p.vertex_rank.assign(owner.begin(), owner.end());
  for (const Triangle& t : mesh.triangles())
    p.triangle_rank.push_back(majority(p.vertex_rank[t[0]], p.vertex_rank[t[1]], p.vertex_rank[t[2]]));
  p.row_start.assign(static_cast<std::size_t>(ranks) + 1, 0);
  for (int r : p.vertex_rank) ++p.row_start[r + 1];
  std::partial_sum(p.row_start.begin(), p.row_start.end(), p.row_start.begin());
  std::vector<Index> next(p.row_start.begin(), p.row_start.end() - 1);
  p.row_of.resize(p.vertex_rank.size());
  p.vertex_of.resize(p.vertex_rank.size());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    p.row_of[v] = next[p.vertex_rank[v]]++;
    p.vertex_of[p.row_of[v]] = v;
  }
  return p;
}

}  // namespace voile::mesh
