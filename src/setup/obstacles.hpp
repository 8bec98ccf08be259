// Obstacles of a case and the independent check of contact.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/mpi.hpp"
#include "geometry/intersections.hpp"
#include "input/case.hpp"
#include "results/results.hpp"

namespace voile::system {
class Contact;
class ContactScene;
}  // namespace voile::system

namespace voile::setup {

/// Obstacles that were read, by name, for the epochs and stages of a run.
using KnownObstacles = std::map<std::string, contact::Obstacle>;

/// What a model needs to know of contact: rank 0 reads the files of obstacles that are not known yet, every rank
/// receives them. Collective. Throws UserError for files that cannot be read and frames that do not fit their mesh.
[[nodiscard]] system::ContactInput contact_input(MPI_Comm comm, const input::Case& c, KnownObstacles& known);

/// Vertices of an obstacle of type mesh in the scene at time 0 [m]. Not collective. Throws UserError as above.
[[nodiscard]] std::vector<Vec3> vertices_at_start(const input::ObstacleSection& section);

/// Counts triangles that intersect, by exact predicates (see io/intersections.hpp). Balls and capsules count as
/// polyhedra inscribed in them, a half-space is compared vertex by vertex.
class IntersectionCheck {
 public:
  /// The contact must outlive it.
  explicit IntersectionCheck(const system::Contact& contact);

  /// Intersecting pairs of the sheet with itself and with obstacles that it can touch, at positions of all points of
  /// the contact surface; those that pass through an obstacle do not count. Not collective, for rank 0.
  [[nodiscard]] std::vector<geometry::TrianglePair> find(const std::vector<Vec3>& positions) const {
    return find(positions, geometry::Share{});
  }
  /// The same, found by all ranks together, each in its part of space; on every rank. Collective.
  [[nodiscard]] std::vector<geometry::TrianglePair> find_by_ranks(const std::vector<Vec3>& positions) const;
  /// What was found, in words, by pairs of bodies; the triangles go to `file` for ParaView, unless that is empty, and with all others
  /// as a picture to a .png beside it, if that can be drawn.
  [[nodiscard]] std::string report(const std::vector<Vec3>& positions, const std::vector<geometry::TrianglePair>& pairs,
                                   const std::filesystem::path& file) const;

 private:
  struct Triangles {
    std::vector<Vec3> positions;
    std::vector<mesh::Triangle> triangles;
    std::vector<Index> body;
  };
  [[nodiscard]] std::vector<geometry::TrianglePair> find(const std::vector<Vec3>& positions,
                                                         geometry::Share fraction) const;
  [[nodiscard]] Triangles triangles_at(const std::vector<Vec3>& positions) const;
  /// A picture beside `file`. Says nothing if it cannot be drawn: the triangles are there.
  void draw(const Triangles& all, const std::vector<geometry::TrianglePair>& pairs,
            const std::filesystem::path& file) const;

  const system::Contact& contact_;
};

/// Obstacles to look at: balls and capsules as the polyhedra of the check, which turn with them, a half-space as a
/// square near the sheet.
class ObstaclePicture {
 public:
  /// Not collective.
  ObstaclePicture(const system::ContactInput& input, const mesh::SurfaceMesh& sheet);

  [[nodiscard]] const results::ObstacleTriangles& at_rest() const { return rest_; }
  /// Vertices at the time in force of a scene with the same obstacles [m]. Not collective.
  [[nodiscard]] std::vector<Vec3> positions(const system::ContactScene& scene) const;

 private:
  results::ObstacleTriangles rest_;
  std::vector<std::size_t> first_;  ///< vertex of each obstacle
};

}  // namespace voile::setup
