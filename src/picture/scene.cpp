#include "scene.hpp"

#include <algorithm>
#include <cmath>
#include <map>

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

namespace {

/// Sides of one triangle alone.
std::vector<mesh::TriangleSide> free_sides(const std::vector<mesh::Triangle>& triangles) {
  std::map<mesh::Segment, std::vector<mesh::TriangleSide>> sides;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s)
      sides[mesh::ascending(triangles[t][(s + 1) % 3], triangles[t][(s + 2) % 3])].push_back(
          {static_cast<Index>(t), static_cast<int>(s)});
  std::vector<mesh::TriangleSide> free;
  for (const auto& [edge, at] : sides)
    if (at.size() == 1) free.push_back(at.front());
  return free;
}

/// A strip along a free side between both layers; vertices of the back are numbered `count` higher.
void add_strip(Surface& s, const mesh::TriangleSide& side, Index count) {
  const auto t = static_cast<std::size_t>(side.triangle), i = static_cast<std::size_t>(side.side);
  const Index a = s.triangles[t][(i + 1) % 3], b = s.triangles[t][(i + 2) % 3];
  const Vec3f &front = s.positions[static_cast<std::size_t>(a)],
              &back = s.positions[static_cast<std::size_t>(a) + static_cast<std::size_t>(count)];
  const Vec3f out = Vec3f(s.positions[static_cast<std::size_t>(b)] - front).cross(front - back);
  if (!(out.norm() > 0.0F)) return;
  s.triangles.push_back({a, a + count, b + count});
  s.triangles.push_back({a, b + count, b});
  for (int k = 0; k < 6; ++k) s.normals.emplace_back(out.normalized());
  if (s.flat.empty()) return;
  const Vec2f from = s.flat[t][(i + 1) % 3], to = s.flat[t][(i + 2) % 3];
  s.flat.push_back({from, from, to});
  s.flat.push_back({from, to, to});
}

}  // namespace

void thicken(Surface& s, double thickness) {
  const std::size_t vertices = s.positions.size(), triangles = s.triangles.size();
  const auto count = static_cast<Index>(vertices);
  std::vector<Vec3f> up(vertices, Vec3f::Zero());
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t i = 0; i < 3; ++i) up[static_cast<std::size_t>(s.triangles[t][i])] += s.normals[3 * t + i];
  const std::vector<mesh::TriangleSide> ends = free_sides(s.triangles);
  s.positions.resize(2 * vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    const Vec3f half = up[v].norm() > 0.0F ? Vec3f(static_cast<float>(0.5 * thickness) * up[v].normalized()) : up[v];
    s.positions[vertices + v] = s.positions[v] - half;
    s.positions[v] += half;
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    mesh::Triangle v = s.triangles[t];
    for (Index& k : v) k += count;
    s.triangles.push_back(v);
  }
  const auto twice = [](auto& list) {
    const auto once = list;
    list.insert(list.end(), once.begin(), once.end());
  };
  twice(s.normals);
  twice(s.flat);
  twice(s.marked_sides);
  twice(s.red_sides);
  for (const mesh::TriangleSide& side : ends) add_strip(s, side, count);
  for (std::vector<std::uint8_t>* marks : {&s.marked_sides, &s.red_sides})
    if (!marks->empty()) marks->resize(s.triangles.size(), 0);
}

}  // namespace voile::picture
