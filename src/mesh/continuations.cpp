#include "continuations.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace voile::mesh {

namespace {

constexpr double largest_turn = 20.0 * std::numbers::pi / 180.0;

/// Unit vector across the edge into the triangle of a side.
Vec3 inwards(const MeshData& data, const TriangleSide& s) {
  const Triangle& v = data.triangles[s.triangle];
  const Vec3 a = data.positions[v[(s.side + 1) % 3]], along = (data.positions[v[(s.side + 2) % 3]] - a).normalized(),
             to_apex = data.positions[v[s.side]] - a;
  return (to_apex - to_apex.dot(along) * along).normalized();
}

/// Cosine of the turn from one sheet to the other, and both.
using Pair = std::tuple<double, std::size_t, std::size_t>;

std::vector<Pair> straightest_first(const MeshData& data, const Joint& joint) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < joint.sides.size(); ++i)
    for (std::size_t j = i + 1; j < joint.sides.size(); ++j) {
      const double cosine = -inwards(data, joint.sides[i]).dot(inwards(data, joint.sides[j]));
      if (cosine > std::cos(largest_turn)) pairs.emplace_back(-cosine, i, j);
    }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace

std::map<Index, std::vector<Continuation>> continuations(const MeshData& data, const std::vector<Joint>& joints) {
  std::map<Index, std::vector<Continuation>> result;
  if (!data.rest.empty())
    return result;  // which side of a piece of fabric is the right one does not depend on where it lies
  for (const Joint& joint : joints) {
    std::vector<char> used(joint.sides.size(), 0);
    for (const Pair& pair : straightest_first(data, joint)) {
      const std::size_t i = std::get<1>(pair), j = std::get<2>(pair);
      if (used[i] || used[j]) continue;
      used[i] = used[j] = 1;
      const TriangleSide &p = joint.sides[i], &q = joint.sides[j];
      const bool opposite =
          data.triangles[p.triangle][(p.side + 1) % 3] != data.triangles[q.triangle][(q.side + 1) % 3];
      result[p.triangle].push_back({q.triangle, opposite});
      result[q.triangle].push_back({p.triangle, opposite});
    }
  }
  for (auto& entry : result)
    std::sort(entry.second.begin(), entry.second.end(),
              [](const Continuation& a, const Continuation& b) { return a.next < b.next; });
  return result;
}

}  // namespace voile::mesh
