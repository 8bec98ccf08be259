#include "tie_points.hpp"

#include <algorithm>

#include "mesh/coincident.hpp"
#include "tie_surface.hpp"

namespace voile::geometry {

bool TiePoints::is_on(Index v, const mesh::Segment& edge) const {
  if (v == edge[0] || v == edge[1]) return true;
  const auto at = on_edge_.find(edge);
  return at != on_edge_.end() && std::find(at->second.begin(), at->second.end(), v) != at->second.end();
}

void TiePoints::put_on(Index v, const mesh::Segment& edge) {
  if (!is_on(v, edge)) on_edge_[edge].push_back(v);
}

bool TiePoints::put_in(Index v, Index triangle) {
  const mesh::Triangle& t = data_->triangles[triangle];
  if (v == t[0] || v == t[1] || v == t[2]) return false;
  bool side = false;
  for (std::size_t s = 0; s < 3; ++s) {
    const Index a = t[s], b = t[(s + 1) % 3];
    if (distance_to_segment(x(v), x(a), x(b)) > tolerance_) continue;
    put_on(v, mesh::ascending(a, b));
    side = true;
  }
  if (side) return true;
  std::vector<Index>& points = inside_[triangle];
  if (std::find(points.begin(), points.end(), v) == points.end()) points.push_back(v);
  return true;
}

Index TiePoints::vertex_at(const Vec3& place, const mesh::Segment& edge, const mesh::Segment& other) {
  for (const mesh::Segment& e : {edge, other})
    if (const auto at = on_edge_.find(e); at != on_edge_.end())
      for (const Index v : at->second)
        if ((x(v) - place).norm() <= tolerance_) return v;
  data_->positions.push_back(place);
  return static_cast<Index>(data_->positions.size()) - 1;
}

void TiePoints::sort() {
  for (auto& [edge, points] : on_edge_) {
    const Vec3 along = x(edge[1]) - x(edge[0]);
    std::sort(points.begin(), points.end(), [&](Index v, Index w) { return x(v).dot(along) < x(w).dot(along); });
  }
}

std::vector<Index> TiePoints::chain(Index a, Index b) const {
  std::vector<Index> vertices{a};
  if (const auto at = on_edge_.find(mesh::ascending(a, b)); at != on_edge_.end()) {
    vertices.insert(vertices.end(), at->second.begin(), at->second.end());
    if (a > b) std::reverse(vertices.begin() + 1, vertices.end());
  }
  vertices.push_back(b);
  return vertices;
}

const std::vector<Index>& TiePoints::inside(Index triangle) const {
  static const std::vector<Index> none;
  const auto at = inside_.find(triangle);
  return at == inside_.end() ? none : at->second;
}

std::vector<Index> TiePoints::of_triangle(Index triangle) const {
  const mesh::Triangle& t = data_->triangles[triangle];
  std::vector<Index> all = inside(triangle);
  for (std::size_t s = 0; s < 3; ++s) {
    const std::vector<Index> side = chain(t[s], t[(s + 1) % 3]);
    all.insert(all.end(), side.begin(), side.end() - 1);
  }
  return all;
}

std::vector<Index> TiePoints::all() const {
  std::vector<Index> all;
  for (const auto& [edge, points] : on_edge_) all.insert(all.end(), points.begin(), points.end());
  for (const auto& [triangle, points] : inside_) all.insert(all.end(), points.begin(), points.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace voile::geometry
