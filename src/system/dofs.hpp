// The unknowns of one mesh: their numbering over the ranks, halo, vertex axes, mirror points and fixed components.
//
// Symbols   a     vector of unknowns, three per vertex in the vertex's own axes Q_v (constraints.hpp)           [m]
//           u_v   = Q_v a_v displacement in global axes;  x = X + u position, X that at the start
//           g     mirror point, x_g = f + R (x_A - f), f = (1 - alpha) x_a + alpha x_b (patch.hpp);  where the clamp
//           has
//                 turned by Q, R = Q R_0 Q^T and u_g = u_f + R (u_A - u_f) + d, d = (R - R_0)(X_A - X_f)
//           of a tie: u = u_r + sum n_i d_i, d_i the unknowns of carriers (ties.hpp)
//           of a rigid body: x = C + c + R (X - C), c and R from the unknowns of its carriers (rigid_bodies.hpp)
// Local points of a rank: its own vertices in the order of their rows, then halo vertices, images of vertices, mirror points,
// frames of bodies.
// Theory: docs/theory/patch.md, missing neighbours.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "constraints.hpp"
#include "mesh/partition.hpp"

namespace voile::mesh {
class PatchMesh;
}  // namespace voile::mesh

namespace voile::system {

/// Local points of a rank.
struct LocalPoints {
  Index owned = 0, vertices = 0;  ///< its own vertices; these and the halo
  std::vector<Index>
      point_of;  ///< mesh point (patch.hpp) of each local point; frames of bodies follow the mirror points
  std::vector<Index> local_of;  ///< local point of each mesh point, or no_index
  std::vector<Index> row_of;    ///< block row of each local vertex
  std::vector<Vec3> start;      ///< X [m]
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
  /// Whether a local point is a vertex in global axes and of no rigid body, so that it moves as its unknowns do.
  [[nodiscard]] bool is_plain(Index point) const {
    return point < local_.vertices && !has_axes(local_.point_of[point]) && !is_dependent(local_.point_of[point]);
  }
  [[nodiscard]] std::vector<Share> fractions(Index point) const;
  /// Turns the mirror points of clamps: the rotation of each support, by number. Not collective.
  void turn_mirrors(const std::vector<Mat3>& rotation);
  /// d: the displacement of a local point that turned clamps alone make [m].
  [[nodiscard]] Vec3 offset(Index point) const;
  /// Displacements u and positions x of the local points, in global axes; both of size local().count(). Collective.
  void update_points(Vec a, std::vector<Vec3>& u, std::vector<Vec3>& x) const;
  /// How local points move with a change of the unknowns at the state that update_points() took last. Collective. [m]
  [[nodiscard]] std::vector<Vec3> point_changes(Vec da) const;
  /// Adds forces on the local points, in global axes, to the rows of this rank; `force` is used up. Not collective.
  void add_forces(std::vector<Vec3>& force, Vec f) const;

  // Rigid bodies, at the state that update_points() took last
  [[nodiscard]] bool has_bodies() const { return !bodies_.empty(); }
  /// Number of the body that a vertex of the mesh belongs to, or no_index.
  [[nodiscard]] Index body_of(Index v) const { return bodies_.empty() ? no_index : body_of_[v]; }
  /// Whether a vertex of the mesh has no unknowns of its own: it belongs to a body or repeats another one.
  [[nodiscard]] bool is_dependent(Index v) const {
    return body_of(v) != no_index || (ties_->any() && ties_->is_tied(v));
  }
  [[nodiscard]] const Ties& ties() const { return *ties_; }
  [[nodiscard]] const std::vector<RigidMotion>& motions() const { return motions_; }
  /// Forces on the points of each body that this rank knows: all of them where it owns a carrier. Not collective.
  [[nodiscard]] std::vector<BodyForce> body_forces(const std::vector<Vec3>& force) const;
  /// Adds forces on a body to the rows of its carriers. Not collective. [N]
  void add_body_force(std::size_t body, const BodyForce& on, const petsc::WriteArray& f) const;
  /// Adds a row of the unknowns of a body, or only of its rotation's, by the numbers of the rotation's unknowns. Not collective. [N]
  void add_body_row(std::size_t body, const RigidMotion::Row& on, const petsc::WriteArray& f) const;
  void add_turning_force(std::size_t body, const Eigen::Vector4d& on, const petsc::WriteArray& f) const;
  /// Adds a matrix of the unknowns of a body to the open values of a tangent. Not collective. [N/m]
  void add_unknowns_block(std::size_t body, const RigidMotion::Block& k, const BlockMatrix& tangent,
                          const BlockMatrix::Values& values) const;
  /// Entries of a vector for the unknowns of each body, on every rank. Collective.
  [[nodiscard]] std::vector<RigidMotion::Row> body_rows(Vec a) const;
  /// Rates of the unknowns at the start that fit velocities of vertices best, in the order of gather_bodies(). Rank 0 only.
  [[nodiscard]] std::vector<double> body_rates(const std::vector<double>& velocity) const;
  /// Local vertices that carry the unknowns of a body.
  [[nodiscard]] const std::array<Index, 3>& carriers(std::size_t body) const { return bodies_[body].carriers; }
  [[nodiscard]] std::size_t body_unknowns() const { return 9 * bodies_.size(); }
  [[nodiscard]] const std::vector<RigidBody>& bodies() const { return *bodies_of_mesh_; }
  /// Unknowns of all bodies, nine each, on rank 0; the other way round. Collective.
  [[nodiscard]] std::vector<double> gather_bodies(Vec a) const;
  void scatter_bodies(const std::vector<double>& unknowns, Vec a) const;

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
  /// Likewise of a change of displacements at the state that update_points() took last; of forces, which are left out on
  /// rigid bodies. Those on a difference of a periodic sheet act at one vertex of each of its curves.
  [[nodiscard]] std::vector<double> gather_change(Vec da) const;
  [[nodiscard]] std::vector<double> gather_forces(Vec f) const;
  /// The other way round, from rank 0; vertices of rigid bodies are left at zero. Collective.
  void scatter(const std::vector<double>& values, Vec a) const;
  /// Likewise of forces, with those on vertices of rigid bodies (rigid_loads.hpp).
  void scatter_forces(const std::vector<double>& values, Vec f) const;

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
  void number_bodies(const mesh::PatchMesh& patches, const Constraints& constraints, const std::vector<char>& needed);
  void number_ties();
  /// In a periodic sheet.
  [[nodiscard]] std::vector<Share> tied_fractions(Index point) const;
  void add_tied_forces(std::vector<Vec3>& force) const;
  /// Puts what belongs to the rows of carriers into values per vertex.
  void take_differences(std::vector<double>& values) const;
  void take_tied_forces(std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> gather_tied_forces(Vec f) const;
  void take_halo(Vec a) const;
  /// Values of a vector by vertex, with what `of_body` gives for an owned one of a body.
  void scatter_with(const std::vector<double>& values, Vec a, bool on_bodies) const;
  [[nodiscard]] std::vector<double> gather_with(Vec a, const std::function<Vec3(Index local)>& of_body) const;
  void create_scatter();
  [[nodiscard]] Vec3 turned_to_own(Index v, const Vec3& f) const;
  [[nodiscard]] Vec3 turned_to_global(Index v, const Vec3& a) const;

  MPI_Comm comm_;
  const mesh::SurfaceMesh* mesh_;
  const mesh::Partition* partition_;
  int rank_;
  Index first_row_;
  LocalPoints local_;
  struct BodyPoint {  ///< a local point and its arm at the start [m]
    Index point;
    Vec3 arm;
  };
  struct Body {
    std::array<Index, 3> carriers;  ///< local
    std::vector<BodyPoint> points;
  };
  /// Body of a local point, or no_index, and the unknowns that it depends on.
  [[nodiscard]] Index body_of_point(Index point) const;
  [[nodiscard]] std::vector<Share> body_fractions(std::size_t body, Index point) const;
  void set_motion(std::size_t body, const petsc::ReadArray& halo) const;

  /// A local point that follows others.
  struct Tied {
    Index point, root;
    mesh::ContinuedSurface::Shift periods;
  };

  std::vector<Mirror> mirrors_;
  Index first_mirror_ = 0;  ///< local point of the first mirror point
  const Ties* ties_;
  std::vector<Tied> tied_;
  std::vector<Index> tied_of_;  ///< per local point that is no mirror point: entry of tied_, or no_index; empty: none
  std::vector<Index> local_carriers_;  ///< of the ties, or no_index
  std::vector<Body> bodies_;
  const std::vector<RigidBody>* bodies_of_mesh_ = nullptr;
  Index first_frame_ = 0;                     ///< local point of the first frame
  std::vector<Vec3> arms_;                    ///< per local point, of bodies only [m]
  std::vector<Index> frame_body_;             ///< body of each frame point
  std::vector<Index> body_of_;                ///< per vertex of the mesh; empty: there are no bodies
  mutable std::vector<RigidMotion> motions_;  ///< at the state taken last
  std::vector<Index> rotated_;                ///< local vertices with axes of their own
  std::vector<Index> axes_of_;                ///< per vertex of the mesh: entry of axes_, or no_index
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
