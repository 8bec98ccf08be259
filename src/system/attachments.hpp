// Vertices that are held to the surface of an obstacle, wherever it goes and however it deforms.
//
// Symbols   X_0     where a vertex is when it is taken hold of                                                    [m]
//           y_0     the point of the obstacle nearest to it then, at weights l_i of the corners p_i of a triangle  [m]
//           F       axes of that triangle: along its first side, in its plane square to that, normal
//   y(t) = sum_i l_i p_i(t) + F(t) d,   d = F_0^T (X_0 - y_0), or (0, 0, +-gap) on the side on which X_0 lies
//   W    = k/2 |x - y(t)|^2           k: a fraction of the stiffness, spread as loads are (boundary_conditions.hpp)
//   x    = y(t)                       of a hard one
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "conditions.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::energy {
class AnchorTerm;
}  // namespace voile::energy

namespace voile::system {

class BoundaryConditions;
class Contact;
class Discretisation;

/// What is remembered of one vertex, alike on all ranks.
struct Anchor {
  int attachment = 0;  ///< Attachment::number
  Index vertex = 0;    ///< of the mesh
  Index triangle = 0;  ///< of the obstacle
  Vec2 weights;        ///< of its second and third corner
  Vec3 offset;         ///< d, from there in the axes of the triangle [m]
};

/// As rows of eight numbers, for files; and back.
[[nodiscard]] std::vector<double> numbers_of(const std::vector<Anchor>& anchors);
[[nodiscard]] std::vector<Anchor> anchors_of(const std::vector<double>& numbers);

/// Where an anchor's place is, from the corners of the obstacle [m].
[[nodiscard]] Vec3 anchor_place(const Anchor& anchor, const mesh::Triangle& triangle, const std::vector<Vec3>& points);

/// Anchors of vertices at `places`, to the surface of `points` and `triangles` (of non-zero area, at least one).
/// Not collective.
[[nodiscard]] std::vector<Anchor> make_anchors(const Attachment& attachment, const std::vector<Index>& vertices,
                                               const std::vector<Vec3>& places, const std::vector<Vec3>& points,
                                               const std::vector<mesh::Triangle>& triangles);

/// The vertices of the groups of an attachment, ascending, each once. Not collective. Throws UserError.
[[nodiscard]] std::vector<Index> vertices_of(const mesh::SurfaceMesh& mesh, const Attachment& attachment);

/// The attachments of a model. Until attach() they do nothing.
class Attachments {
 public:
  /// Soft ones become elements of `term`; the vertices of hard ones have supports that follow, whose displacements in
  /// `conditions` are set here. `contact` has the obstacles, `term` is null where there are no attachments. All must
  /// outlive it. Not collective. Throws UserError.
  Attachments(const Discretisation& on, std::vector<Attachment> list, const Contact* contact,
              BoundaryConditions& conditions, energy::AnchorTerm* term);

  [[nodiscard]] const std::vector<Attachment>& list() const { return list_; }
  /// The number of the obstacle that an attachment names. Throws UserError.
  [[nodiscard]] std::size_t obstacle_of(const Attachment& attachment) const;
  /// Those of which `anchors` knows nothing take hold of what they hold where it is in state a, to the obstacles at the
  /// time in force; the others go on as it says. `anchors`: becomes what is to be remembered. Collective.
  void attach(Vec a, std::vector<Anchor>& anchors);
  /// Puts the places of anchors where the obstacles are at the time in force. Not collective.
  void place();

 private:
  void hold_softly(const Attachment& attachment, std::size_t obstacle);

  struct Held {
    Index element;  ///< of the term; hard: the local point
    std::size_t obstacle;
    bool hard;
  };
  const Discretisation* on_;
  std::vector<Attachment> list_;
  const Contact* contact_;
  BoundaryConditions* conditions_;
  energy::AnchorTerm* term_;
  std::map<std::pair<int, Index>, Held> held_;  ///< by attachment and owned vertex
  std::vector<Anchor> anchors_;
  std::optional<double> placed_at_;  ///< time for which the places are known [s]
};

}  // namespace voile::system
