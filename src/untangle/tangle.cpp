#include "tangle.hpp"

#include <Eigen/Geometry>

namespace voile::untangle {

Tangle::Tangle(const Surface& surface, const std::vector<Mat3>& free, const UntangleOptions& options,
               std::vector<Vec3>& x)
    : surface(surface),
      free(free),
      options(options),
      x(x),
      pieces(regions_without(surface, {})),
      faces_of_point(pieces.size()),
      on_border(pieces.size(), false) {
  for (std::size_t f = 0; f < surface.faces.size(); ++f)
    for (const Segment& edge : edges_of(surface.faces[f])) faces_of_edge[edge].push_back(static_cast<Index>(f));
  for (Index f = 0; f < surface.sheet_faces; ++f)
    for (const Index v : surface.faces[f].points) faces_of_point[v].push_back(f);
  for (const auto& [edge, faces] : faces_of_edge)
    if (surface.is_sheet(edge[0]) && faces.size() == 1) on_border[edge[0]] = on_border[edge[1]] = true;
}

}  // namespace voile::untangle
