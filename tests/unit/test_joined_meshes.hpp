// Meshes of sheets that are joined along an edge.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <vector>

#include "test_meshes.hpp"

namespace voile::testing {

/// Unit squares around their common edge x = z = 0 along y, at these angles [rad] from x; group "sheet k" each, sides as those of
/// the square ("end k" far from the edge), "ends" at y = 0. Odd sheets are turned over.
inline mesh::MeshData fan(const std::vector<double>& angles, Pattern pattern, int nx, int ny) {
  mesh::MeshData d;
  d.source = "fan";
  mesh::Group low{"ends", 1, {}, {}, {}};
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const mesh::MeshData square = grid(nx, ny, pattern == Pattern::union_jack,
                                       pattern == Pattern::jittered ? 0.25 : 0.0, static_cast<unsigned>(k + 1));
    std::vector<Index> number;
    mesh::Group sheet{"sheet " + std::to_string(k), 2, {}, {}, {}}, far{"end " + std::to_string(k), 1, {}, {}, {}};
    for (std::size_t v = 0; v < square.positions.size(); ++v) {
      const Vec3& x = square.positions[v];
      const auto row = static_cast<Index>(v) / (nx + 1);
      if (k > 0 && static_cast<Index>(v) % (nx + 1) == 0) {
        number.push_back(row * (nx + 1));
        continue;
      }
      number.push_back(static_cast<Index>(d.positions.size()));
      d.positions.emplace_back(x[0] * std::cos(angles[k]), x[1], x[0] * std::sin(angles[k]));
    }
    for (const mesh::Triangle& t : square.triangles) {
      sheet.triangles.push_back(static_cast<Index>(d.triangles.size()));
      d.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
      if (k % 2 == 1) std::swap(d.triangles.back()[0], d.triangles.back()[1]);
    }
    for (int i = 0; i <= ny; ++i) far.vertices.push_back(number[i * (nx + 1) + nx]);
    for (int i = 0; i < ny; ++i) far.segments.push_back({far.vertices[i], far.vertices[i + 1]});
    for (int i = 0; i <= nx; ++i) low.vertices.push_back(number[i]);
    for (int i = 0; i < nx; ++i) low.segments.push_back({number[i], number[i + 1]});
    d.groups.push_back(sheet);
    d.groups.push_back(far);
  }
  std::sort(low.vertices.begin(), low.vertices.end());
  low.vertices.erase(std::unique(low.vertices.begin(), low.vertices.end()), low.vertices.end());
  d.groups.push_back(low);
  return d;
}

/// A fan whose edge is a hinge and the group "hinge".
inline mesh::MeshData hinged(mesh::MeshData d) {
  mesh::Group hinge{"hinge", 1, {}, {}, {}};
  for (std::size_t v = 0; v < d.positions.size(); ++v)
    if (std::hypot(d.positions[v][0], d.positions[v][2]) < 1e-12) hinge.vertices.push_back(static_cast<Index>(v));
  for (std::size_t i = 0; i + 1 < hinge.vertices.size(); ++i)
    hinge.segments.push_back({hinge.vertices[i], hinge.vertices[i + 1]});
  d.hinges = hinge.segments;
  d.groups.push_back(hinge);
  return d;
}

/// A strip of nx x ny cells around a circle of radius 1, turned over once if `twisted`.
inline mesh::MeshData moebius(int nx, int ny, bool twisted = true) {
  mesh::MeshData d;
  d.source = "strip.msh";
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j <= ny; ++j) {
      const double around = 2.0 * std::numbers::pi * i / nx, turn = twisted ? 0.5 * around : 0.0;
      const double across = 0.6 * (static_cast<double>(j) / ny - 0.5);
      const double radius = 1.0 + across * std::cos(turn);
      d.positions.emplace_back(radius * std::cos(around), radius * std::sin(around), across * std::sin(turn));
    }
  const auto at = [&](int i, int j) { return static_cast<Index>(i < nx ? i * (ny + 1) + j : twisted ? ny - j : j); };
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      d.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      d.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return d;
}

/// Half planes z = 0, x = 0 and y = 0, which cross or end at each other: where they meet, joints share triangles.
inline mesh::MeshData cell_corner(int n) {
  mesh::MeshData d;
  d.source = "corner";
  std::map<std::array<int, 3>, Index> number;
  const auto at = [&](int i, int j, int k) {
    const auto [found, is_new] = number.try_emplace({i, j, k}, static_cast<Index>(d.positions.size()));
    if (is_new)
      d.positions.emplace_back(i / static_cast<double>(n), j / static_cast<double>(n), k / static_cast<double>(n));
    return found->second;
  };
  for (int i = -n; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (const auto& f : {std::array{at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0)},
                            std::array{at(0, j, i), at(0, j + 1, i), at(0, j + 1, i + 1), at(0, j, i + 1)},
                            std::array{at(i, 0, j), at(i + 1, 0, j), at(i + 1, 0, j + 1), at(i, 0, j + 1)}}) {
        d.triangles.push_back({f[0], f[1], f[3]});
        d.triangles.push_back({f[1], f[2], f[3]});
      }
  return d;
}

}  // namespace voile::testing
