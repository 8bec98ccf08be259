#include "hinges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mesh/surface_mesh.hpp"
#include "voile/errors.hpp"

namespace voile::system {

std::vector<Index> joints_of(const mesh::SurfaceMesh& mesh, const Hinge& hinge) {
  std::vector<Index> numbers;
  const std::vector<mesh::Joint>& joints = mesh.joints();
  for (mesh::Segment edge : mesh.group(hinge.group, 1).segments) {
    std::sort(edge.begin(), edge.end());
    const auto found = std::lower_bound(joints.begin(), joints.end(), edge,
                                        [](const mesh::Joint& j, const mesh::Segment& e) { return j.edge < e; });
    if (found == joints.end() || found->edge != edge || found->sides.size() != 2) {
      const Vec3 x = 0.5 * (mesh.positions()[edge[0]] + mesh.positions()[edge[1]]);
      throw UserError(fmt::format(
          "[[hinge]] group '{}': the edge at ({:.4g}, {:.4g}, {:.4g}) m is not one of two triangles; a hinge "
          "lies inside a sheet: take edges on the boundary, and those where more sheets meet, out of the group",
          hinge.group, x[0], x[1], x[2]));
    }
    numbers.push_back(static_cast<Index>(found - joints.begin()));
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

std::vector<double> hinge_stiffness(const mesh::SurfaceMesh& mesh, const std::vector<Hinge>& hinges) {
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<double> stiffness(mesh.joints().size(), none);
  for (const Hinge& hinge : hinges)
    for (const Index j : joints_of(mesh, hinge)) {
      double& k = stiffness[static_cast<std::size_t>(j)];
      if (k != none)
        throw UserError(
            fmt::format("[[hinge]] group '{}': some of its edges belong to another hinge; take them out of "
                        "one of the groups",
                        hinge.group));
      k = hinge.stiffness;
    }
  return stiffness;
}

}  // namespace voile::system
