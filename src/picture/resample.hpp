// A sheet that was remeshed on its way, as one mesh that stays; private to src/picture.
//
// Material points are known by where they are on the mesh at the start, which all meshes of a run share. The one mesh is
// the one with the most vertices, halved until its edges are nowhere longer than those of any mesh there, and further
// where points of the run's mesh are more than a tolerance away from it.
// Symbols   x_w   place of vertex w of the one mesh on a mesh of the run: weights in a triangle of it
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/closest_triangle.hpp"
#include "recording.hpp"

namespace voile::picture {

class Resampled {
 public:
  struct Distance {
    double length;   ///< [m]
    Index triangle;  ///< of mesh(), where it is
  };
  /// Reads all moments. `tolerance` > 0 [m], or that of ExportOptions. Throws UserError if there is no sheet in some of
  /// them, or another one.
  Resampled(const Recording& recording, const std::vector<Moment>& moments, std::optional<double> tolerance);
  ~Resampled();
  [[nodiscard]] const std::shared_ptr<const results::StoredMesh>& mesh() const { return mesh_; }
  [[nodiscard]] double tolerance() const { return tolerance_; }  ///< [m]
  /// Places of the vertices of mesh() in a state of the run [m].
  [[nodiscard]] std::vector<Vec3> positions(const State& state) const;
  /// A field on mesh(): linear in triangles, or that of the triangle in which the centroid is.
  [[nodiscard]] results::Field field(const results::StoredMesh& from, results::Field field) const;
  /// Distances of the vertices of the run from the same material points of mesh(), and of points on edges of mesh() from the
  /// triangles of the run that these cross.
  [[nodiscard]] std::vector<Distance> distances(const State& state, const std::vector<Vec3>& positions) const;

 private:
  /// A material point: a triangle of some mesh and barycentric weights.
  struct Place {
    Index triangle = no_index;
    Vec3 weights = Vec3::Zero();
  };
  struct Correspondence {
    std::vector<Place> vertices;                   ///< of mesh(), on the mesh of the run
    std::vector<Place> back;                       ///< of the mesh of the run, on mesh()
    std::vector<std::pair<Place, Place>> between;  ///< points of edges of mesh(), on it and on the mesh of the run
    std::vector<Index> of_triangle;                ///< per triangle of mesh()
  };
  class Locator;

  [[nodiscard]] std::vector<double> wanted_sizes(const mesh::MeshData& base) const;
  [[nodiscard]] std::vector<std::pair<Place, Place>> points_between(const Locator& there,
                                                                    const std::vector<Place>& vertices) const;
  void split(const std::vector<double>& sizes);
  /// Sizes that are smaller where points of the run are too far away; nothing if none are.
  [[nodiscard]] std::vector<double> smaller_sizes(const Recording& recording, const std::vector<Moment>& moments) const;

  std::shared_ptr<const results::StoredMesh> mesh_;
  /// Whether all meshes are of one surface at the start. Those of a curved one are not: between vertices its cells tell no place
  /// closely enough to be refined by.
  bool same_surface_ = true;
  double tolerance_ = 0.0;
  std::map<const results::StoredMesh*, Correspondence> of_;
  std::vector<std::shared_ptr<const results::StoredMesh>> meshes_;  ///< keeps the keys of of_
};

}  // namespace voile::picture
