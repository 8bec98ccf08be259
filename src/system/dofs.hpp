// The unknowns of one mesh: their numbering over the ranks, halo, vertex axes, mirror points and fixed components.
//
// Symbols   a     vector of unknowns, three per vertex in the vertex's own axes Q_v (constraints.hpp)           [m]
//           u_v   = Q_v a_v displacement in global axes;  x = X + u position, X that at the start
//           g     mirror point, x_g = f + R (x_A - f), f = (1 - alpha) x_a + alpha x_b (patch.hpp);  where the clamp
//           has
//                 turned by Q, R = Q R_0 Q^T and u_g = u_f + R (u_A - u_f) + d, d = (R - R_0)(X_A - X_f)
// Local points of a rank: its own vertices in the order of their rows, then halo vertices, then mirror points.
#pragma once

#include <vector>

#include "base/petsc.hpp"
#include "constraints.hpp"
#include "mesh/partition.hpp"

namespace voile::mesh {
class PatchMesh;
}  // namespace voile::mesh

namespace voile::system {

/// Local points of a rank.
struct LocalPoints {
  Index owned = 0, vertices = 0;  ///< its own vertices; these and the halo
  std::vector<Index> point_of;    ///< mesh point (patch.hpp) of each local point
  std::vector<Index> local_of;    ///< local point of each mesh point, or no_index
  std::vector<Index> row_of;      ///< block row of each local vertex
  std::vector<Vec3> start;        ///< X [m]
  [[nodiscard]] Index count() const { return static_cast<Index>(point_of.size()); }
};

class Dofs {
 public:
  /// `needed`: for each point of `patches`, whether elements of this rank use it. The patches, the mesh under them, the
  /// partition and the constraints must outlive it. Collective.
  Dofs(MPI_Comm comm, const mesh::PatchMesh& patches, const mesh::Partition& partition, const Constraints& constraints,
       const std::vector<char>& needed);

  [[nodiscard]] MPI_Comm comm() const { return comm_; }
  [[nodiscard]] const mesh::SurfaceMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const mesh::Partition& partition() const { return *partition_; }
  [[nodiscard]] const LocalPoints& local() const { return local_; }
  [[nodiscard]] Index first_row() const { return first_row_; }
  [[nodiscard]] PetscInt unknowns() const { return 3 * mesh_->vertex_count(); }

  // Vertices, by their number in the mesh; the same on every rank
  [[nodiscard]] bool has_axes(Index v) const { return axes_of_[v] != no_index; }
  /// Q_v.
  [[nodiscard]] Mat3 axes(Index v) const;
  /// Components of a vector in the vertex's axes, and back.
  [[nodiscard]] Vec3 to_own(Index v, const Vec3& f) const { return has_axes(v) ? turned_to_own(v, f) : f; }
  [[nodiscard]] Vec3 to_global(Index v, const Vec3& a) const { return has_axes(v) ? turned_to_global(v, a) : a; }
  [[nodiscard]] bool is_fixed(Index v, int component) const {
    return fixed_flags_[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(component)] != 0;
  }
  [[nodiscard]] bool is_held(Index v) const { return is_fixed(v, 0) && is_fixed(v, 1) && is_fixed(v, 2); }
  /// Fixed unknowns of this rank, counted from its first, ascending.
  [[nodiscard]] const std::vector<PetscInt>& fixed() const { return fixed_; }

  // Local points
  /// A vertex in whose unknowns a point takes part: dx_point = map * da_vertex.
  struct Share {
    Index vertex;  ///< local
    Mat3 map;
  };
  /// Whether a local point is a vertex in global axes, so that it moves as its unknowns do.
  [[nodiscard]] bool is_plain(Index point) const {
    return point < local_.vertices && !has_axes(local_.point_of[point]);
  }
  [[nodiscard]] std::vector<Share> fractions(Index point) const;
  /// Turns the mirror points of clamps: the rotation of each support, by number. Not collective.
  void turn_mirrors(const std::vector<Mat3>& rotation);
  /// d: the displacement of a local point that turned clamps alone make [m].
  [[nodiscard]] Vec3 offset(Index point) const;
  /// Displacements u and positions x of the local points, in global axes; both of size local().count(). Collective.
  void update_points(Vec a, std::vector<Vec3>& u, std::vector<Vec3>& x) const;
  /// Adds forces on the local points, in global axes, to the rows of this rank; `force` is used up. Not collective.
  void add_forces(std::vector<Vec3>& force, Vec f) const;

  // Vertices of this rank
  /// Sets the free components of its vertex i so that it is at x [m].
  void place_vertex(Index i, const Vec3& x, const petsc::WriteArray& a) const;

  // Vectors of unknowns
  /// A zero vector. Collective.
  [[nodiscard]] petsc::VecHandle create_vector() const;
  /// Sets the fixed components to zero, or the free ones.
  void clear_fixed(Vec v) const;
  void clear_free(Vec v) const;
  /// Three components per vertex in global axes, mesh order, on rank 0 (empty elsewhere). Collective.
  [[nodiscard]] std::vector<double> gather(Vec a) const;
  /// The other way round, from rank 0. Collective.
  void scatter(const std::vector<double>& values, Vec a) const;

 private:
  struct Mirror {  ///< local points
    Index apex, a, b;
    double foot;
    Mat3 rest_reflection, reflection;  ///< R_0, R
    Vec3 arm;                          ///< X_A - X_f [m]
    int support;                       ///< that turns it, or -1
    Vec3 offset = Vec3::Zero();        ///< d [m]
  };
  void number(const mesh::PatchMesh& patches, const std::vector<char>& needed, const std::vector<int>& turned_by);
  void take_constraints(const Constraints& constraints);
  void create_scatter();
  [[nodiscard]] Vec3 turned_to_own(Index v, const Vec3& f) const;
  [[nodiscard]] Vec3 turned_to_global(Index v, const Vec3& a) const;

  MPI_Comm comm_;
  const mesh::SurfaceMesh* mesh_;
  const mesh::Partition* partition_;
  int rank_;
  Index first_row_;
  LocalPoints local_;
  std::vector<Mirror> mirrors_;
  std::vector<Index> rotated_;  ///< local vertices with axes of their own
  std::vector<Index> axes_of_;  ///< per vertex of the mesh: entry of axes_, or no_index
  std::vector<Mat3> axes_;
  std::vector<char> fixed_flags_;
  std::vector<PetscInt> fixed_;
  petsc::VecHandle pattern_, halo_;  ///< of the shape of a; of the local vertices
  petsc::ScatterHandle scatter_;
};

/// Sets the free components of a so that the vertices are at x (all of them, the same on every rank). Every rank sets its
/// own.
void set_positions(const Dofs& dofs, const std::vector<Vec3>& x, Vec a);
/// Projector onto the directions in which a vertex may move, for each.
[[nodiscard]] std::vector<Mat3> free_directions(const Dofs& dofs);

}  // namespace voile::system
