#include "scene.hpp"

#include <algorithm>
#include <cmath>

namespace voile::picture {

namespace {

/// Triangles round each vertex: those of v are list[first[v]] to list[first[v + 1]].
struct Rounds {
  std::vector<std::size_t> first, list;
  Rounds(std::size_t vertices, const std::vector<mesh::Triangle>& triangles) : first(vertices + 1, 0) {
    for (const mesh::Triangle& t : triangles)
      for (const Index v : t) ++first[static_cast<std::size_t>(v) + 1];
    for (std::size_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
    list.resize(first.back());
    std::vector<std::size_t> at(first.begin(), first.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const Index v : triangles[t]) list[at[static_cast<std::size_t>(v)]++] = 3 * t;
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto v = static_cast<std::size_t>(triangles[t][i]);
        for (std::size_t k = first[v]; k < first[v + 1]; ++k)
          if (list[k] == 3 * t) list[k] += i;  // which of its corners
      }
  }
};

}  // namespace

std::vector<Vec3f> corner_normals(const std::vector<Vec3f>& positions, const std::vector<mesh::Triangle>& triangles,
                                  double crease) {
  const auto x = [&](std::size_t t, std::size_t i) -> const Vec3f& {
    return positions[static_cast<std::size_t>(triangles[t][i % 3])];
  };
  std::vector<Vec3f> flat(triangles.size()), corners(3 * triangles.size());
  std::vector<float> angles(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3f n = (x(t, 1) - x(t, 0)).cross(x(t, 2) - x(t, 0));
    flat[t] = n.norm() > 0.0F ? Vec3f(n.normalized()) : Vec3f(0, 0, 1);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3f a = x(t, i + 1) - x(t, i), b = x(t, i + 2) - x(t, i);
      angles[3 * t + i] = std::atan2(a.cross(b).norm(), a.dot(b));
    }
  }
  const Rounds rounds(positions.size(), triangles);
  const auto limit = static_cast<float>(std::cos(crease));
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(triangles[t][i]);
      Vec3f sum = Vec3f::Zero();
      for (std::size_t k = rounds.first[v]; k < rounds.first[v + 1]; ++k) {
        const std::size_t corner = rounds.list[k];
        if (flat[corner / 3].dot(flat[t]) >= limit) sum += angles[corner] * flat[corner / 3];
      }
      corners[3 * t + i] = sum.norm() > 0.0F ? Vec3f(sum.normalized()) : flat[t];
    }
  return corners;
}

}  // namespace voile::picture
