// Rank 0 reads or makes a mesh, every rank receives the whole surface.
#include "mesh_transfer.hpp"

#include <fmt/format.h>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "formats/mesh_file.hpp"
#include "geometry/hanging_vertices.hpp"
#include "geometry/tie.hpp"
#include "geometry/tie_crossing.hpp"
#include "mesh/coincident.hpp"
#include "mesh/panels.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

void broadcast_groups(MPI_Comm comm, std::vector<mesh::Group>& groups) {
  std::vector<Index> count{static_cast<Index>(groups.size())};
  mpi::broadcast(comm, count);
  groups.resize(static_cast<std::size_t>(count[0]));
  for (mesh::Group& g : groups) {
    mpi::broadcast(comm, g.name);
    std::vector<Index> segments{g.dimension};
    for (const mesh::Segment& s : g.segments) segments.insert(segments.end(), s.begin(), s.end());
    mpi::broadcast(comm, segments);
    mpi::broadcast(comm, g.vertices);
    mpi::broadcast(comm, g.triangles);
    mpi::broadcast(comm, g.added);
    g.dimension = segments[0];
    g.segments.clear();
    for (std::size_t i = 1; i < segments.size(); i += 2) g.segments.push_back({segments[i], segments[i + 1]});
  }
}

void broadcast_seams(MPI_Comm comm, std::vector<mesh::Seam>& seams) {
  std::vector<Index> count{static_cast<Index>(seams.size())};
  mpi::broadcast(comm, count);
  seams.resize(static_cast<std::size_t>(count[0]));
  for (mesh::Seam& seam : seams) {
    std::vector<Index> members;
    for (const auto& pair : seam.pairs) members.insert(members.end(), pair.begin(), pair.end());
    mpi::broadcast(comm, seam.name);
    mpi::broadcast(comm, members);
    mpi::broadcast(comm, seam.lengths);
    mpi::broadcast(comm, seam.stations);
    seam.pairs.resize(seam.lengths.size());
    for (std::size_t k = 0; k < seam.pairs.size(); ++k) seam.pairs[k] = {members[2 * k], members[2 * k + 1]};
  }
}

}  // namespace

void broadcast_mesh(MPI_Comm comm, mesh::MeshData& data) {
  std::vector<double> coordinates;
  std::vector<Index> corners;
  for (const Vec3& x : data.positions) coordinates.insert(coordinates.end(), x.begin(), x.end());
  for (const mesh::Triangle& t : data.triangles) corners.insert(corners.end(), t.begin(), t.end());
  mpi::broadcast(comm, data.source);
  mpi::broadcast(comm, coordinates);
  mpi::broadcast(comm, corners);
  mpi::broadcast(comm, data.vertex_tags);
  mpi::broadcast(comm, data.triangle_tags);
  std::vector<double> texture;
  for (const auto& corners_of : data.texture)
    for (const Vec2& uv : corners_of) texture.insert(texture.end(), {uv[0], uv[1]});
  mpi::broadcast(comm, texture);
  data.texture.resize(texture.size() / 6);
  for (std::size_t i = 0; i < texture.size(); i += 2) data.texture[i / 6][i / 2 % 3] = {texture[i], texture[i + 1]};
  std::vector<double> rest;
  for (const auto& corners_of : data.rest)
    for (const Vec3& x : corners_of) rest.insert(rest.end(), x.begin(), x.end());
  mpi::broadcast(comm, rest);
  data.rest.resize(rest.size() / 9);
  for (std::size_t i = 0; i < rest.size(); i += 3) data.rest[i / 9][i / 3 % 3] = Eigen::Map<Vec3>(&rest[i]);
  broadcast_groups(comm, data.groups);
  broadcast_seams(comm, data.seams);
  std::vector<Index> folded;
  for (const mesh::TriangleSide& s : data.folded) folded.insert(folded.end(), {s.triangle, Index{s.side}});
  mpi::broadcast(comm, folded);
  data.folded.clear();
  for (std::size_t i = 0; i < folded.size(); i += 2) data.folded.push_back({folded[i], folded[i + 1]});
  data.positions.resize(coordinates.size() / 3);
  data.triangles.resize(corners.size() / 3);
  for (std::size_t v = 0; v < data.positions.size(); ++v) data.positions[v] = Eigen::Map<Vec3>(&coordinates[3 * v]);
  for (std::size_t t = 0; t < data.triangles.size(); ++t)
    data.triangles[t] = {corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]};
}

namespace {

/// Gaps of up to a twentieth of a cell are those between chords of one curve that is divided differently.
void note_gaps(mesh::MeshData& data, double tolerance) {
  double sum = 0.0;
  for (const mesh::Triangle& t : data.triangles) sum += (data.positions[t[1]] - data.positions[t[0]]).norm();
  const double gap = 0.05 * sum / static_cast<double>(data.triangles.size());
  if (!(gap > tolerance)) return;
  const geometry::HangingVertices h = geometry::find_hanging(data, gap, geometry::Beside::skipped);
  if (h.count > 0)
    data.notes.push_back(fmt::format(
        "{} vertices lie within {:.2g} m of edges or triangles of another part, as near ({:.4g}, {:.4g}, {:.4g}), but "
        "not "
        "within mesh.merge_tolerance = {:.2g} m: they are not joined there; if they should be, make it larger",
        h.count, gap, h.place[0], h.place[1], h.place[2], tolerance));
}

/// Makes one mesh of parts that touch.
void join_parts(mesh::MeshData& data, const formats::MeshOptions& options) {
  const double given = options.merge_tolerance;
  const double tolerance = given > 0.0 ? given : mesh::default_merge_tolerance(data);
  std::vector<mesh::Segment> rims = mesh::rim_edges(data);
  const Index gone = mesh::merge_coincident(data, tolerance, &rims);
  formats::renew_boundary(data);
  if (gone > 0) data.notes.push_back(fmt::format("{} vertices were merged with others at the same place", gone));
  if (options.rest == formats::RestShape::texture) return;
  const bool crosses = options.join_crossing && !geometry::crossing_triangles(data, tolerance, rims).empty();
  if (crosses || geometry::find_hanging(data, tolerance, geometry::Beside::counted, rims).count > 0) {
    const geometry::Tied tied = geometry::tie_parts(data, tolerance, std::move(rims),
                                                    crosses ? geometry::Crossing::joined : geometry::Crossing::left);
    formats::renew_boundary(data);
    if (tied.triangles > 0)
      data.notes.push_back(fmt::format(
          "parts whose meshes do not match were tied: {} vertices moved onto others or onto edges, {} lie on "
          "edges or triangles of another part, and {} triangles were divided there",
          tied.moved, tied.vertices, tied.triangles));
    if (crosses)
      data.notes.push_back(
          "parts that pass through each other were joined there; if they should not be, move them apart");
  }
  note_gaps(data, tolerance);
}

/// What is wrong may be of the file or of what has been made of it.
mesh::SurfaceMesh checked(mesh::MeshData data, bool merged) {
  try {
    return mesh::SurfaceMesh(std::move(data));
  } catch (const UserError& e) {
    if (!merged) throw;
    throw UserError(
        fmt::format("{} (after mesh.merge: sheets that lie flat on each other cannot be joined, and a merge_tolerance "
                    "that is not small against the cells folds them; make it smaller, or leave merge out)",
                    e.what()));
  }
}

}  // namespace

mesh::SurfaceMesh load_mesh(MPI_Comm comm, const std::filesystem::path& file, const formats::MeshOptions& options) {
  mesh::MeshData data;
  mpi::on_root(comm, [&] {
    data = formats::read_mesh(file.string(), options);
    if (options.merge) join_parts(data, options);
  });
  broadcast_mesh(comm, data);
  // The same data give the same verdict on every rank, so this throws everywhere or nowhere.
  const bool panels = options.rest == formats::RestShape::texture;
  if (panels) mesh::take_rest_from_texture(data, options.texture_unit);
  mesh::SurfaceMesh mesh = checked(std::move(data), options.merge);
  if (panels) mesh::check_panels(mesh);
  return mesh;
}

}  // namespace voile::setup
