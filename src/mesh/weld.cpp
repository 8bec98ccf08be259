#include "weld.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "base/text.hpp"
#include "base/wildcard.hpp"
#include "voile/errors.hpp"

namespace voile::mesh {

namespace {

/// The lowest of the vertices that hang together through the wanted seams.
template <class Wanted>
std::vector<Index> roots(const MeshData& mesh, const Wanted& wanted) {
  std::vector<Index> target(mesh.positions.size());
  std::iota(target.begin(), target.end(), Index{0});
  const auto root = [&](Index v) {
    while (target[v] != v) v = target[v] = target[target[v]];
    return v;
  };
  for (const Seam& seam : mesh.seams) {
    if (!wanted(seam.name)) continue;
    for (const auto& [v, w] : seam.pairs) {
      const Index a = root(v), b = root(w);
      target[std::max(a, b)] = std::min(a, b);
    }
  }
  for (Index v = 0; v < static_cast<Index>(target.size()); ++v) target[v] = root(v);
  return target;
}

void renumber(Group& g, const std::vector<Index>& number) {
  for (Index& v : g.vertices) v = number[v];
  std::sort(g.vertices.begin(), g.vertices.end());
  g.vertices.erase(std::unique(g.vertices.begin(), g.vertices.end()), g.vertices.end());
  std::vector<Segment> kept;
  std::set<Segment> seen;
  for (const Segment& s : g.segments) {
    const Index a = number[s[0]], b = number[s[1]];
    if (seen.insert({std::min(a, b), std::max(a, b)}).second) kept.push_back({a, b});
  }
  g.segments = std::move(kept);
}

void renumber(Seam& seam, const std::vector<Index>& number) {
  Seam kept{seam.name, {}, {}};
  for (std::size_t k = 0; k < seam.pairs.size(); ++k) {
    const std::array<Index, 2> pair{number[seam.pairs[k][0]], number[seam.pairs[k][1]]};
    if (pair[0] == pair[1]) continue;
    kept.pairs.push_back(pair);
    kept.lengths.push_back(seam.lengths[k]);
    if (k < seam.stations.size()) kept.stations.push_back(seam.stations[k]);
  }
  seam = std::move(kept);
}

}  // namespace

std::string seam_group(const std::string& seam) {
  return "seam " + seam;
}

std::vector<std::string> open_seams(const MeshData& mesh, const std::vector<std::string>& names) {
  std::vector<std::string> found;
  const auto is_named = [&](const Seam& seam) {
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return name == "all" || name == seam.name || star_of(name, seam.name);
    });
  };
  for (const Seam& seam : mesh.seams)
    if (is_named(seam)) found.push_back(seam.name);
  return found;
}

std::array<double, 2> side_lengths(const SurfaceMesh& mesh, const std::string& seam) {
  std::array<double, 2> lengths{0.0, 0.0};
  const std::string group = seam_group(seam);
  if (!mesh.has_group(group)) return lengths;
  std::map<Index, int> sides;  // bits; the tip of a dart has none
  for (const Seam& s : mesh.data().seams)
    if (s.name == seam)
      for (const auto& [first, second] : s.pairs) {
        sides[first] |= 1;
        sides[second] |= 2;
      }
  const auto side_of = [&](Index v) {
    const auto found = sides.find(v);
    return found == sides.end() ? 0 : found->second;
  };
  for (const Segment& e : mesh.group(group, 1).segments) {
    const int side = side_of(e[0]) | side_of(e[1]);
    if (side == 1 || side == 2) lengths[side == 1 ? 0 : 1] += mesh.rest_length(e);
  }
  return lengths;
}

Welded weld(const MeshData& mesh, const std::vector<std::string>& seams, const std::vector<Vec3>& places,
            const std::vector<double>& mass) {
  const std::vector<Index> root = roots(mesh, [&](const std::string& name) { return contains(seams, name); });
  Welded w{mesh, std::vector<Index>(root.size())};
  std::vector<std::size_t> tags;
  Index count = 0;
  for (std::size_t v = 0; v < root.size(); ++v) {
    if (root[v] != static_cast<Index>(v)) {
      w.target[v] = w.target[root[v]];
      continue;
    }
    w.target[v] = count++;
    if (v < mesh.vertex_tags.size()) tags.push_back(mesh.vertex_tags[v]);
  }
  std::vector<double> flat;
  for (const Vec3& x : places) flat.insert(flat.end(), x.begin(), x.end());
  const std::vector<double> mean = merged_means(w.target, mass, flat, 3);
  w.data.positions.clear();
  for (std::size_t i = 0; i < mean.size(); i += 3) w.data.positions.emplace_back(mean[i], mean[i + 1], mean[i + 2]);
  w.data.vertex_tags = std::move(tags);
  for (std::size_t t = 0; t < w.data.triangles.size(); ++t) {
    Triangle& v = w.data.triangles[t];
    for (Index& i : v) i = w.target[i];
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
      throw UserError(
          fmt::format("{}: a seam would sew two corners of triangle {} to each other; make the cells smaller "
                      "there",
                      mesh.source, t < mesh.triangle_tags.size() ? mesh.triangle_tags[t] : t + 1));
  }
  for (Group& g : w.data.groups) renumber(g, w.target);
  for (Seam& seam : w.data.seams) renumber(seam, w.target);
  std::erase_if(w.data.seams, [&](const Seam& seam) { return contains(seams, seam.name) || seam.pairs.empty(); });
  return w;
}

std::vector<double> merged_means(const std::vector<Index>& target, const std::vector<double>& mass,
                                 const std::vector<double>& values, std::size_t width) {
  if (values.empty()) return {};
  const auto count = static_cast<std::size_t>(*std::max_element(target.begin(), target.end())) + 1;
  std::vector<double> sum(width * count, 0.0), total(count, 0.0);
  std::vector<int> members(count, 0);
  for (std::size_t v = 0; v < target.size(); ++v) {
    const auto to = static_cast<std::size_t>(target[v]);
    total[to] += mass[v];
    ++members[to];
    for (std::size_t k = 0; k < width; ++k) sum[width * to + k] += mass[v] * values[width * v + k];
  }
  // A vertex on its own keeps its value to the last digit.
  for (std::size_t v = 0; v < target.size(); ++v) {
    const auto to = static_cast<std::size_t>(target[v]);
    for (std::size_t k = 0; k < width; ++k)
      if (members[to] == 1) sum[width * to + k] = values[width * v + k];
  }
  for (std::size_t to = 0; to < count; ++to)
    for (std::size_t k = 0; k < width && members[to] > 1; ++k) sum[width * to + k] /= total[to];
  return sum;
}

SeamGap widest_gap(const MeshData& mesh, const std::vector<std::string>& seams, const std::vector<Vec3>& places) {
  SeamGap widest;
  for (const Seam& seam : mesh.seams) {
    if (!contains(seams, seam.name)) continue;
    for (const auto& [v, w] : seam.pairs) {
      const double gap = (places[v] - places[w]).norm();
      if (gap > widest.gap) widest = {seam.name, gap, {v, w}, 0.5 * (places[v] + places[w])};
    }
  }
  return widest;
}

std::vector<Index> joined_vertices(const MeshData& mesh, const std::vector<std::string>& seams) {
  const std::vector<std::string> open = open_seams(mesh, seams);
  if (open.empty()) return {};
  return roots(mesh, [&](const std::string& name) { return contains(open, name); });
}

}  // namespace voile::mesh
