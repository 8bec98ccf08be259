#include "open_seams.hpp"

#include <algorithm>

#include "mesh/weld.hpp"

namespace voile::adapt {

namespace {

double rest_length(const mesh::SurfaceMesh& mesh, Index h) {
  return (mesh.rest_corner(h / 3, prev(h) % 3) - mesh.rest_corner(h / 3, next(h) % 3)).norm();
}

/// The edges of open seams by their groups, with the number of the seam.
std::map<std::pair<Index, Index>, int> grouped_edges(const mesh::SurfaceMesh& mesh) {
  std::map<std::pair<Index, Index>, int> seam_of;
  const std::vector<mesh::Seam>& seams = mesh.data().seams;
  for (std::size_t k = 0; k < seams.size(); ++k)
    for (const mesh::Group& g : mesh.groups())
      if (g.dimension == 1 && g.name == mesh::seam_group(seams[k].name))
        for (const mesh::Segment& e : g.segments) seam_of[std::minmax(e[0], e[1])] = static_cast<int>(k);
  return seam_of;
}

}  // namespace

OpenSeams::OpenSeams(const mesh::SurfaceMesh& mesh, const HalfEdges& edges) : seams_(mesh.data().seams) {
  const std::vector<Index> root = mesh::joined_vertices(mesh.data());
  if (root.empty()) return;
  std::map<Index, std::vector<Index>> members;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (root[v] == v) continue;
    std::vector<Index>& all = members[root[v]];
    if (all.empty()) all.push_back(root[v]);
    all.push_back(v);
  }
  for (const auto& [first, all] : members)
    for (const Index v : all) class_of_[v] = all;
  std::map<Ends, std::vector<Index>> meeting;
  for (Index h = 0; h < static_cast<Index>(edges.twin.size()); ++h) {
    const Index a = root[edges.origin(h)], b = root[edges.dest(h)];
    if (edges.twin[h] == no_index && a != b) meeting[std::minmax(a, b)].push_back(h);
  }
  const auto seam_of = grouped_edges(mesh);
  for (const auto& [v, all] : class_of_) held_[v] = {};
  for (const auto& [ends, sides] : meeting) {
    if (sides.size() < 2) continue;
    double length = 0.0;
    for (const Index h : sides) length += rest_length(mesh, h) / static_cast<double>(sides.size());
    for (std::size_t k = 0; k < sides.size(); ++k) {
      const Index h = sides[k], g = sides[(k + 1) % sides.size()], o = edges.origin(h), d = edges.dest(h);
      const bool turned = root[edges.origin(g)] != root[o];
      const Index at_o = turned ? edges.dest(g) : edges.origin(g), at_d = turned ? edges.origin(g) : edges.dest(g);
      const auto known = seam_of.find(std::minmax(o, d));
      Edge e{{at_o, at_d}, known == seam_of.end() || sides.size() > 2 ? -1 : known->second, length, h, {0.0, 1.0}};
      if (o > d) std::swap(e.other[0], e.other[1]), std::swap(e.fraction[0], e.fraction[1]);
      edges_[std::minmax(o, d)] = e;
      held_[o] = held_[d] = {};
    }
  }
}

const OpenSeams::Edge* OpenSeams::find(Index a, Index b) const {
  const auto found = edges_.find(std::minmax(a, b));
  return found == edges_.end() ? nullptr : &found->second;
}

std::vector<Index> OpenSeams::members(Index v) const {
  const auto found = class_of_.find(v);
  return found == class_of_.end() ? std::vector<Index>{v} : found->second;
}

std::optional<OldShare> OpenSeams::origin_of(Index v) const {
  const auto found = held_.find(v);
  if (found == held_.end() || found->second.side == no_index) return std::nullopt;
  return found->second;
}

void OpenSeams::split(Index a, Index b, Index m, Index n) {
  const Edge e = *find(a, b);
  const auto [low, high] = std::minmax(a, b);
  halve(low, high, m, n);
  halve(e.other[0], e.other[1], n, m);
  class_of_[m] = class_of_[n] = {std::min(m, n), std::max(m, n)};
  mesh::Seam& seam = seams_[static_cast<std::size_t>(e.seam)];
  if (!seam.stations.empty())
    seam.stations.push_back(station_between(seam, {low, e.other[0]}, {high, e.other[1]}, e.length));
  const double length =
      take(e.seam, low, e.other[0], 0.25 * e.length) + take(e.seam, high, e.other[1], 0.25 * e.length);
  const auto is_pair = [&](Index first, Index second) {
    return std::find(seam.pairs.begin(), seam.pairs.end(), Pair{first, second}) != seam.pairs.end();
  };
  const bool is_second = is_pair(e.other[0], low) || is_pair(e.other[1], high);
  seam.pairs.push_back(is_second ? Pair{n, m} : Pair{m, n});
  seam.lengths.push_back(length);
}

/// The new vertex is the highest so far.
void OpenSeams::halve(Index a, Index b, Index m, Index n) {
  const Ends ends = std::minmax(a, b);
  const Edge e = edges_.at(ends);
  edges_.erase(ends);
  const double middle = 0.5 * (e.fraction[0] + e.fraction[1]);
  held_[m] = {e.side, middle};
  edges_[{ends.first, m}] = {{e.other[0], n}, e.seam, 0.5 * e.length, e.side, {e.fraction[0], middle}};
  edges_[{ends.second, m}] = {{e.other[1], n}, e.seam, 0.5 * e.length, e.side, {e.fraction[1], middle}};
}

/// Of the pair in the middle of an edge. The tip of a dart is no pair: it is the beginning or the end of the seam.
double OpenSeams::station_between(const mesh::Seam& seam, const Pair& a, const Pair& b, double length) {
  const auto [first, last] = std::minmax_element(seam.stations.begin(), seam.stations.end());
  const auto of = [&](const Pair& pair) -> std::optional<double> {
    for (std::size_t k = 0; k < seam.stations.size(); ++k)
      if (seam.pairs[k] == pair || seam.pairs[k] == Pair{pair[1], pair[0]}) return seam.stations[k];
    return std::nullopt;
  };
  const std::optional<double> at_a = of(a), at_b = of(b);
  if (at_a && at_b) return 0.5 * (*at_a + *at_b);
  const double known = at_a ? *at_a : at_b.value_or(*first);
  return known - *first < *last - known ? std::max(0.0, known - 0.5 * length) : known + 0.5 * length;
}

/// The tip of a dart is no pair: its fraction is nobody's.
double OpenSeams::take(int seam, Index v, Index w, double length) {
  mesh::Seam& s = seams_[static_cast<std::size_t>(seam)];
  for (std::size_t k = 0; k < s.pairs.size(); ++k) {
    if (s.pairs[k] != std::array{v, w} && s.pairs[k] != std::array{w, v}) continue;
    const double taken = std::min(length, 0.5 * s.lengths[k]);
    s.lengths[k] -= taken;
    return taken;
  }
  return length;
}

}  // namespace voile::adapt
