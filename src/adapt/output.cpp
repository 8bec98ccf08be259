#include "output.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "base/decompositions.hpp"
#include "repair.hpp"

namespace voile::adapt {

namespace {

/// New numbers of what is left, and the other way round. What is as it was comes first, in its old order.
struct Numbers {
  std::vector<Index> vertex, triangle;            ///< new number per slot
  std::vector<Index> vertex_slot, triangle_slot;  ///< slot per new number
};

Numbers number(const Surface& s, Index old_triangles) {
  Numbers n;
  n.vertex.assign(static_cast<std::size_t>(s.vertex_slots()), no_index);
  n.triangle.assign(static_cast<std::size_t>(s.triangle_slots()), no_index);
  for (const bool as_was : {true, false}) {
    for (Index v = 0; v < s.vertex_slots(); ++v)
      if (!s.gone[v] && (s.old[v] != no_index) == as_was) {
        n.vertex[v] = static_cast<Index>(n.vertex_slot.size());
        n.vertex_slot.push_back(v);
      }
    for (Index t = 0; t < s.triangle_slots(); ++t)
      if (!s.dead[t] && (t < old_triangles && !s.touched[t]) == as_was) {
        n.triangle[t] = static_cast<Index>(n.triangle_slot.size());
        n.triangle_slot.push_back(t);
      }
  }
  return n;
}

/// Nearest point on the old sides of a line's class beside the triangle of a hit.
ChartSearch::Hit onto_line(const Surface& s, const Vec3& p, const ChartSearch::Hit& hit, int line) {
  ChartSearch::Hit best;
  best.squared_distance = std::numeric_limits<double>::infinity();
  s.search.around(hit.triangle, [&](Index t) {
    if (s.search.chart(t) != s.search.chart(hit.triangle)) return;
    for (int i = 0; i < 3; ++i) {
      if (s.features.side_class[3 * t + i] != line) continue;
      const auto a = static_cast<std::size_t>((i + 1) % 3), b = static_cast<std::size_t>((i + 2) % 3);
      const Vec3 &xa = s.search.rest(t)[a], edge = s.search.rest(t)[b] - xa;
      const double q = std::clamp((p - xa).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      const double d = (xa + q * edge - p).squaredNorm();
      if (d >= best.squared_distance) continue;
      best = {t, {0.0, 0.0, 0.0}, d};
      best.weights[a] = 1.0 - q;
      best.weights[b] = q;
    }
  });
  return best.triangle == no_index ? hit : best;
}

Remeshed::Source source_of(const Surface& s, Index v) {
  Index side = s.leaving[v];
  if (s.old[v] != no_index) {
    // Any old triangle of it: the search knows them by numbers.
    Remeshed::Source source;
    source.triangle = s.search.triangle_of(s.old[v]);
    for (std::size_t i = 0; i < 3; ++i) source.weights[i] = s.old_triangles[source.triangle][i] == s.old[v] ? 1.0 : 0.0;
    return source;
  }
  if (const std::optional<OldShare> at = s.open_seams.origin_of(v)) {
    // At the same fraction of both sides of the seam, to the last digit.
    Remeshed::Source source{at->side / 3, {0.0, 0.0, 0.0}};
    source.weights[static_cast<std::size_t>(next(at->side) % 3)] = 1.0 - at->fraction;
    source.weights[static_cast<std::size_t>(prev(at->side) % 3)] = at->fraction;
    return source;
  }
  int line = 0;
  if (s.on_feature[v]) {
    // The line's side with the triangle to its left, coming or going.
    const Index start = s.first_around(side);
    side = start;
    while (s.side_class[side] == 0) side = s.left(side);
    line = s.side_class[side];
  }
  const Vec3& p = s.rest[next(side)];
  ChartSearch::Hit hit = s.search.nearest(p, s.old_hint[side / 3]);
  if (line != 0) hit = onto_line(s, p, hit, line);
  double sum = 0.0;
  for (double& w : hit.weights) {
    if (w < 1e-12) w = 0.0;
    sum += w;
  }
  for (double& w : hit.weights) w /= sum;
  return {hit.triangle, hit.weights};
}

/// Place at the start of a new vertex of panels. On a curved rim it lies beside the triangle that it comes from, which goes on
/// there as it is, so that what is not strained stays so. On open seams it stays on the old edge, as its partner does.
Vec3 start_of(const Surface& s, Index v, const Remeshed::Source& at, const mesh::SurfaceMesh& old_mesh) {
  const mesh::Triangle& corners = old_mesh.triangles()[at.triangle];
  Eigen::Matrix<double, 3, 2> rest, start;
  Vec3 x = Vec3::Zero(), source = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &place = old_mesh.positions()[corners[i]], &chart = s.search.rest(at.triangle)[i];
    x += at.weights[i] * place;
    source += at.weights[i] * chart;
    if (i == 0) continue;
    start.col(static_cast<Eigen::Index>(i) - 1) = place - old_mesh.positions()[corners[0]];
    rest.col(static_cast<Eigen::Index>(i) - 1) = chart - s.search.rest(at.triangle)[0];
  }
  const Index side = s.first_around(s.leaving[v]);
  if (s.twin[side] != no_index || s.open_seams.origin_of(v)) return x;
  return x + start * LeastSquares(rest).solve(s.rest[next(side)] - source);
}

void fill_vertices(const Surface& s, const Numbers& n, const mesh::SurfaceMesh& old_mesh, Remeshed& r) {
  const mesh::MeshData& from = old_mesh.data();
  std::size_t tag = *std::max_element(from.vertex_tags.begin(), from.vertex_tags.end());
  for (Index v : n.vertex_slot) {
    r.kept.push_back(s.old[v]);
    r.source.push_back(source_of(s, v));
    r.places.push_back(s.place[v]);
    const bool is_old = s.old[v] != no_index;
    r.mesh.vertex_tags.push_back(is_old ? from.vertex_tags[s.old[v]] : ++tag);
    const Remeshed::Source& at = r.source.back();
    if (is_old) {
      r.mesh.positions.push_back(from.positions[s.old[v]]);
    } else if (!old_mesh.has_charts()) {
      r.mesh.positions.push_back(s.rest[next(s.leaving[v])]);
    } else {
      r.mesh.positions.push_back(start_of(s, v, at, old_mesh));
    }
  }
  if (s.allowed.empty()) return;
  r.clearance.assign(n.vertex_slot.size(), std::numeric_limits<double>::infinity());
  for (Index t : n.triangle_slot)
    for (Index c = 3 * t; c < 3 * t + 3; ++c) {
      double& left = r.clearance[n.vertex[s.vertex[c]]];
      left = std::min(left, s.allowed[t] - s.moved[t]);
    }
}

void fill_triangles(const Surface& s, const Numbers& n, const mesh::SurfaceMesh& old_mesh, Remeshed& r) {
  const mesh::MeshData& from = old_mesh.data();
  std::size_t tag = *std::max_element(from.triangle_tags.begin(), from.triangle_tags.end());
  for (Index t : n.triangle_slot) {
    const bool same = t < old_mesh.triangle_count() && !s.touched[t];
    r.same_triangle.push_back(same ? t : no_index);
    r.mesh.triangle_tags.push_back(same ? from.triangle_tags[t] : ++tag);
    r.mesh.triangles.push_back(
        {n.vertex[s.vertex[3 * t]], n.vertex[s.vertex[3 * t + 1]], n.vertex[s.vertex[3 * t + 2]]});
    if (!from.texture.empty()) r.mesh.texture.push_back({s.texture[3 * t], s.texture[3 * t + 1], s.texture[3 * t + 2]});
    if (!from.rest.empty()) r.mesh.rest.push_back({s.rest[3 * t], s.rest[3 * t + 1], s.rest[3 * t + 2]});
  }
}

void fill_groups(const Surface& s, const Numbers& n, const mesh::SurfaceMesh& old_mesh, Remeshed& r) {
  std::vector<mesh::Group>& groups = r.mesh.groups;
  for (const mesh::Group& g : old_mesh.groups()) groups.push_back({g.name, g.dimension, {}, {}, {}});
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (Index v : s.features.single_vertices[g]) groups[g].vertices.push_back(n.vertex[v]);
  for (Index t : n.triangle_slot) {
    const Index now = n.triangle[t];
    for (int g : s.features.groups_of_triangle_class[s.triangle_class[t]]) {
      groups[g].triangles.push_back(now);
      for (Index c = 3 * t; c < 3 * t + 3; ++c) groups[g].vertices.push_back(n.vertex[s.vertex[c]]);
    }
    for (Index h = 3 * t; h < 3 * t + 3; ++h) {
      if (s.side_class[h] == 0 || !s.is_edge(h)) continue;
      for (int g : s.features.groups_of_side_class[s.side_class[h]]) {
        const Index a = n.vertex[s.origin(h)], b = n.vertex[s.dest(h)];
        groups[g].segments.push_back({a, b});
        groups[g].vertices.insert(groups[g].vertices.end(), {a, b});
      }
    }
  }
  for (mesh::Group& g : groups) {
    std::sort(g.vertices.begin(), g.vertices.end());
    g.vertices.erase(std::unique(g.vertices.begin(), g.vertices.end()), g.vertices.end());
  }
}

void fill_seams(const Surface& s, const Numbers& n, Remeshed& r) {
  r.mesh.seams = s.open_seams.seams();
  for (mesh::Seam& seam : r.mesh.seams)
    for (std::array<Index, 2>& pair : seam.pairs) pair = {n.vertex[pair[0]], n.vertex[pair[1]]};
}

}  // namespace

Remeshed make_output(const Surface& s, const mesh::SurfaceMesh& old_mesh) {
  Remeshed r;
  r.mesh.source = old_mesh.source();
  const Numbers n = number(s, old_mesh.triangle_count());
  fill_vertices(s, n, old_mesh, r);
  fill_triangles(s, n, old_mesh, r);
  fill_groups(s, n, old_mesh, r);
  fill_seams(s, n, r);
  r.counts = s.counts;
  r.quality = quality_of(s);
  return r;
}

}  // namespace voile::adapt
