#include "pieces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/text.hpp"

namespace voile::picture {

namespace {

using Side = std::pair<Index, Index>;

Side side_of(const mesh::Triangle& t, std::size_t s) {
  return std::minmax(t[(s + 1) % 3], t[(s + 2) % 3]);
}

/// Numbers that are joined step by step (union-find).
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::size_t> parent_;
};

/// Calls work(t, s, u, r) for every two triangles t, u with a common side: side s of the one and r of the other.
template <class Work>
void for_neighbours(const mesh::MeshData& mesh, const Work& work) {
  std::map<Side, std::pair<std::size_t, std::size_t>> seen;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s) {
      const auto [at, is_new] = seen.try_emplace(side_of(mesh.triangles[t], s), t, s);
      if (!is_new) work(t, s, at->second.first, at->second.second);
    }
}

/// Whether texture coordinates agree on a common side.
bool same_piece(const mesh::MeshData& mesh, std::size_t t, std::size_t s, std::size_t u, std::size_t r) {
  for (const std::size_t i : {(s + 1) % 3, (s + 2) % 3})
    for (const std::size_t j : {(r + 1) % 3, (r + 2) % 3})
      if (mesh.triangles[t][i] == mesh.triangles[u][j] && (mesh.texture[t][i] - mesh.texture[u][j]).norm() > 1e-9)
        return false;
  return true;
}

std::vector<std::size_t> texture_pieces(const mesh::MeshData& mesh) {
  Sets sets(mesh.triangles.size());
  for_neighbours(mesh, [&](std::size_t t, std::size_t s, std::size_t u, std::size_t r) {
    if (mesh.texture.empty() || same_piece(mesh, t, s, u, r)) sets.join(t, u);
  });
  std::map<std::size_t, std::size_t> numbers;
  std::vector<std::size_t> pieces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    pieces.push_back(numbers.try_emplace(sets.root(t), numbers.size()).first->second);
  return pieces;
}

void mark_sides(const mesh::MeshData& mesh, const std::set<Side>& lines, std::vector<std::uint8_t>& marks) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s)
      if (lines.contains(side_of(mesh.triangles[t], s))) marks[t] = static_cast<std::uint8_t>(marks[t] | (1U << s));
}

}  // namespace

Bodies find_bodies(const results::ObstacleTriangles& obstacles, const std::vector<Vec3>& positions, const Vec3& up) {
  Bodies found;
  std::vector<std::vector<std::size_t>> own(obstacles.names.size());
  for (std::size_t t = 0; t < obstacles.triangles.size(); ++t) {
    const auto o = static_cast<std::size_t>(obstacles.obstacle[t]);
    if (o < own.size()) own[o].push_back(t);
  }
  for (const std::vector<std::size_t>& triangles : own) {
    std::set<Index> vertices;
    for (const std::size_t t : triangles) vertices.insert(obstacles.triangles[t].begin(), obstacles.triangles[t].end());
    const bool is_square = triangles.size() == 2 && vertices.size() == 4;
    if (is_square) {
      const mesh::Triangle& t = obstacles.triangles[triangles.front()];
      const Vec3 n = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).normalized();
      if (n.dot(up) > 0.999) {
        found.floor = positions[t[0]].dot(up);
        continue;
      }
    }
    for (const std::size_t t : triangles) found.triangles.push_back(obstacles.triangles[t]);
    if (!is_square)
      for (const Index v : vertices) found.solid_points.push_back(positions[v]);
  }
  return found;
}

std::vector<std::size_t> panels_of(const mesh::MeshData& mesh) {
  std::vector<std::size_t> panel(mesh.triangles.size(), 0);
  std::size_t groups = 0;
  for (const mesh::Group& g : mesh.groups) {
    if (g.dimension != 2 || g.triangles.size() == mesh.triangles.size()) continue;
    ++groups;
    for (const Index t : g.triangles) panel[static_cast<std::size_t>(t)] = groups;
  }
  return groups > 0 ? panel : texture_pieces(mesh);
}

std::vector<std::uint8_t> group_borders(const mesh::MeshData& mesh) {
  std::vector<std::uint8_t> marks(mesh.triangles.size(), 0);
  const std::vector<std::size_t> panel = panels_of(mesh), piece = texture_pieces(mesh);
  const auto mark = [&](std::size_t t, std::size_t s) { marks[t] = static_cast<std::uint8_t>(marks[t] | (1U << s)); };
  for_neighbours(mesh, [&](std::size_t t, std::size_t s, std::size_t u, std::size_t r) {
    if (panel[t] == panel[u] && piece[t] == piece[u]) return;
    mark(t, s);
    mark(u, r);
  });
  std::set<Side> lines;
  for (const mesh::Group& g : mesh.groups)
    for (const mesh::Segment& s : g.segments) lines.insert(std::minmax(s[0], s[1]));
  mark_sides(mesh, lines, marks);
  return marks;
}

std::vector<std::uint8_t> seam_sides(const mesh::MeshData& mesh, const std::string& seam) {
  const std::string prefix = "seam ";  // of the names of their groups
  std::vector<std::uint8_t> marks(mesh.triangles.size(), 0);
  std::set<Side> lines;
  for (const mesh::Group& g : mesh.groups)
    if (g.dimension == 1 && g.name.starts_with(prefix) && csv_name(g.name.substr(prefix.size())) == seam)
      for (const mesh::Segment& s : g.segments) lines.insert(std::minmax(s[0], s[1]));
  mark_sides(mesh, lines, marks);
  return marks;
}

std::vector<std::uint8_t> folded_sides(const mesh::MeshData& mesh, const std::vector<Vec3>& positions, double angle) {
  std::vector<std::uint8_t> marks(mesh.triangles.size(), 0);
  const auto normal = [&](std::size_t t) {
    const mesh::Triangle& v = mesh.triangles[t];
    const Vec3& a = positions[static_cast<std::size_t>(v[0])];
    return Vec3((positions[static_cast<std::size_t>(v[1])] - a).cross(positions[static_cast<std::size_t>(v[2])] - a));
  };
  const auto mark = [&](std::size_t t, std::size_t s) { marks[t] = static_cast<std::uint8_t>(marks[t] | (1U << s)); };
  for_neighbours(mesh, [&](std::size_t t, std::size_t s, std::size_t u, std::size_t r) {
    const Vec3 m = normal(t), n = normal(u);
    if (std::atan2(m.cross(n).norm(), m.dot(n)) <= angle) return;
    mark(t, s);
    mark(u, r);
  });
  return marks;
}

}  // namespace voile::picture
