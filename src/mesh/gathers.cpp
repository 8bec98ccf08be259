#include "gathers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "weld.hpp"

namespace voile::mesh {

namespace {

/// Width of the gathered rows over the length of their cells.
constexpr double rows = 3.0;
/// Height of a triangle over its longest side that it may not fall below.
constexpr double least_height = 0.1;

/// Width of the rows of cells whose edges on the seam are so long.
double width_of_rows(double length) {
  return rows * 0.5 * std::sqrt(3.0) * length;
}

/// Side s of triangle t, the length that it gets, and the width of the gathered rows.
struct GatheredSide {
  Index t;
  int s;
  double length, width;
};

/// A node of a chart near a gathered seam.
struct Node {
  double remains = 1.0;  ///< c
  Vec3 along, seam;      ///< direction of the seam, and the nearest node on it
  double k = 1.0, width = 0.0;
};

class Gathering {
 public:
  explicit Gathering(const SurfaceMesh& mesh)
      : mesh_(mesh), lengths_(3 * static_cast<std::size_t>(mesh.triangle_count())) {
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      for (int s = 0; s < 3; ++s) lengths_[3 * t + s] = length(t, s);
    wanted_ = lengths_;
  }

  void add(const Gather& gather);
  [[nodiscard]] bool empty() const { return sides_.empty(); }
  [[nodiscard]] double mean_width() const;
  [[nodiscard]] Gathered result();

 private:
  using Key = std::pair<Index, Index>;  ///< chart and vertex

  [[nodiscard]] Vec3 side(Index t, int s) const {
    return mesh_.rest_corner(t, (s + 2) % 3) - mesh_.rest_corner(t, (s + 1) % 3);
  }
  [[nodiscard]] double length(Index t, int s) const { return side(t, s).norm(); }
  [[nodiscard]] Key key(Index t, int i) const { return {chart_[t], mesh_.triangles()[t][i]}; }
  void find_charts();
  void begin_nodes();
  void grow_nodes();
  void set_lengths();
  void keep_shapes();
  [[nodiscard]] bool is_slim(Index t) const;
  [[nodiscard]] std::array<Vec3, 3> corners(Index t) const;

  const SurfaceMesh& mesh_;
  std::vector<GatheredSide> sides_;
  std::vector<std::string> seams_;
  std::vector<double> lengths_, wanted_;  ///< per side: as it is cut, as it is gathered

  std::vector<Index> chart_;
  std::map<Key, Node> nodes_;
};

void Gathering::add(const Gather& gather) {
  const std::string name = seam_group(gather.seam);
  if (!mesh_.has_group(name)) return;
  const std::vector<Index> joined = joined_vertices(mesh_.data(), {gather.seam});
  const auto root = [&](Index v) { return joined.empty() ? v : joined[v]; };
  std::map<Segment, std::vector<GatheredSide>> edges;
  for (const Segment& e : mesh_.group(name, 1).segments) {
    const Index a = root(e[0]), b = root(e[1]);
    for (const Index t : mesh_.triangles_of_vertex(e[0]))
      if (const int s = mesh_.side_of(t, e[0], e[1]); s >= 0)
        edges[{std::min(a, b), std::max(a, b)}].push_back({t, s, length(t, s), gather.width});
  }
  const std::size_t before = sides_.size();
  for (const auto& [edge, sides] : edges) {
    double shortest = sides.front().length;
    for (const GatheredSide& g : sides) shortest = std::min(shortest, g.length);
    for (const GatheredSide& g : sides)
      if (g.length > gather.least_ratio * shortest) sides_.push_back({g.t, g.s, shortest, g.width});
  }
  if (sides_.size() > before) seams_.push_back(gather.seam);
}

double Gathering::mean_width() const {
  double cut = 0.0;
  for (const GatheredSide& g : sides_) cut += length(g.t, g.s);
  return sides_.empty() ? 0.0 : width_of_rows(cut / static_cast<double>(sides_.size()));
}

void Gathering::find_charts() {
  chart_.assign(static_cast<std::size_t>(mesh_.triangle_count()), no_index);
  for (Index first = 0; first < mesh_.triangle_count(); ++first) {
    if (chart_[first] != no_index) continue;
    std::vector<Index> queue{first};
    chart_[first] = first;
    while (!queue.empty()) {
      const Index t = queue.back();
      queue.pop_back();
      for (int s = 0; s < 3; ++s) {
        const Index n = mesh_.neighbour(t, s);
        if (n == no_index || chart_[n] != no_index || !mesh_.chart_join(t, s).same_chart) continue;
        chart_[n] = first;
        queue.push_back(n);
      }
    }
  }
}

/// Those on the seam.
void Gathering::begin_nodes() {
  std::map<Key, double> cut, gathered;
  std::map<Key, int> count;
  for (const GatheredSide& g : sides_)
    for (const int i : {(g.s + 1) % 3, (g.s + 2) % 3}) {
      const Key at = key(g.t, i);
      Node& node = nodes_.try_emplace(at, Node{1.0, Vec3::Zero(), mesh_.rest_corner(g.t, i)}).first->second;
      node.width = std::max(node.width, g.width);
      node.along += side(g.t, g.s);
      cut[at] += length(g.t, g.s);
      gathered[at] += g.length;
      ++count[at];
    }
  for (auto& [at, node] : nodes_) {
    node.along.normalize();
    node.k = node.remains = gathered[at] / cut[at];
    if (node.width == 0.0) node.width = width_of_rows(cut[at] / count[at]);
  }
}

/// Those within the width, each from the nearest node on the seam.
void Gathering::grow_nodes() {
  for (bool grows = true; grows;) {
    std::map<Key, Node> found;
    for (Index t = 0; t < mesh_.triangle_count(); ++t)
      for (int i = 0; i < 3; ++i) {
        const auto from = nodes_.find(key(t, i));
        if (from == nodes_.end() || !(from->second.remains < 1.0)) continue;
        for (const int j : {(i + 1) % 3, (i + 2) % 3}) {
          if (nodes_.contains(key(t, j))) continue;
          Node node = from->second;
          const Vec3 away = mesh_.rest_corner(t, j) - node.seam;
          const double y = away.cross(node.along).norm();
          node.remains = 1.0 - (1.0 - node.k) * std::max(0.0, 1.0 - y / node.width);
          const auto [at, is_new] = found.try_emplace(key(t, j), node);
          if (!is_new && away.norm() < (mesh_.rest_corner(t, j) - at->second.seam).norm()) at->second = node;
        }
      }
    grows = !found.empty();
    nodes_.merge(found);
  }
}

void Gathering::set_lengths() {
  for (Index t = 0; t < mesh_.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const auto a = nodes_.find(key(t, (s + 1) % 3)), b = nodes_.find(key(t, (s + 2) % 3));
      if (a == nodes_.end() && b == nodes_.end()) continue;
      Vec3 along = Vec3::Zero();
      double remains = 0.0;
      for (const auto& at : {a, b}) {
        remains += at == nodes_.end() ? 0.5 : 0.5 * at->second.remains;
        if (at != nodes_.end()) along += at->second.along;
      }
      const double fraction = along.norm() > 0.0 ? along.normalized().dot(side(t, s).normalized()) : 0.0;
      wanted_[3 * t + s] = lengths_[3 * t + s] * std::sqrt(1.0 - (1.0 - remains * remains) * fraction * fraction);
    }
  for (const GatheredSide& g : sides_) wanted_[3 * g.t + g.s] = g.length;
}

/// Twice the area over the square of the longest side.
double height_of(const double* sides) {
  const double a = sides[0], b = sides[1], c = sides[2], half = 0.5 * (a + b + c);
  const double squared = half * (half - a) * (half - b) * (half - c), longest = std::max({a, b, c});
  return squared > 0.0 ? 2.0 * std::sqrt(squared) / (longest * longest) : 0.0;
}

/// Slimmer than it may be, and than it is cut.
bool Gathering::is_slim(Index t) const {
  const double height = height_of(&wanted_[3 * t]);
  return height < least_height && height < 0.99 * height_of(&lengths_[3 * t]);
}

/// Slim triangles gather less.
void Gathering::keep_shapes() {
  constexpr int most = 20;
  for (int k = 0; k < most; ++k) {
    std::vector<char> gives(wanted_.size(), 0);
    bool any = false;
    for (Index t = 0; t < mesh_.triangle_count(); ++t) {
      if (!nodes_.contains(key(t, 0)) && !nodes_.contains(key(t, 1)) && !nodes_.contains(key(t, 2))) continue;
      if (!is_slim(t)) continue;
      any = true;
      for (int s = 0; s < 3; ++s) {
        gives[3 * t + s] = 1;
        const Index n = mesh_.neighbour(t, s);
        if (n != no_index && chart_[n] == chart_[t]) gives[3 * n + mesh_.side_in_neighbour(t, s)] = 1;
      }
    }
    if (!any) return;
    for (std::size_t h = 0; h < gives.size(); ++h)
      if (gives[h]) wanted_[h] = k + 1 < most ? 0.5 * (wanted_[h] + lengths_[h]) : lengths_[h];
  }
}

/// A triangle of the wanted lengths, turned and put where the one that it is cut as lies best.
std::array<Vec3, 3> Gathering::corners(Index t) const {
  const Vec3 x = mesh_.rest_corner(t, 0), normal = mesh_.rest_normal(t),
             e1 = (mesh_.rest_corner(t, 1) - x).normalized(), e2 = normal.cross(e1);
  const double a = wanted_[3 * t], b = wanted_[3 * t + 1], c = wanted_[3 * t + 2];
  const double along = (b * b + c * c - a * a) / (2.0 * c);
  std::array<Vec2, 3> to{Vec2(0.0, 0.0), Vec2(c, 0.0), Vec2(along, std::sqrt(b * b - along * along))}, from;
  Vec2 mean_to = Vec2::Zero(), mean_from = Vec2::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 d = mesh_.rest_corner(t, i) - x;
    from[i] = Vec2(d.dot(e1), d.dot(e2));
    mean_to += to[i] / 3.0;
    mean_from += from[i] / 3.0;
  }
  double sine = 0.0, cosine = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vec2 p = to[i] - mean_to, q = from[i] - mean_from;
    sine += p[0] * q[1] - p[1] * q[0];
    cosine += p.dot(q);
  }
  const Eigen::Rotation2Dd turn(std::atan2(sine, cosine));
  std::array<Vec3, 3> corners;
  for (int i = 0; i < 3; ++i) {
    const Vec2 at = mean_from + turn * (to[i] - mean_to);
    corners[i] = x + at[0] * e1 + at[1] * e2;
  }
  return corners;
}

Gathered Gathering::result() {
  find_charts();
  begin_nodes();
  grow_nodes();
  set_lengths();
  keep_shapes();
  MeshData data = mesh_.data();
  for (Index t = 0; t < mesh_.triangle_count(); ++t)
    if (wanted_[3 * t] != lengths_[3 * t] || wanted_[3 * t + 1] != lengths_[3 * t + 1] ||
        wanted_[3 * t + 2] != lengths_[3 * t + 2])
      data.rest[static_cast<std::size_t>(t)] = corners(t);
  return {std::move(data), seams_};
}

}  // namespace

double gather_width(const SurfaceMesh& mesh, const Gather& gather) {
  if (!mesh.has_charts()) return 0.0;
  Gathering gathering(mesh);
  gathering.add(gather);
  return gathering.mean_width();
}

std::optional<Gathered> gathered(const SurfaceMesh& mesh, const std::vector<Gather>& seams) {
  if (!mesh.has_charts()) return std::nullopt;
  Gathering gathering(mesh);
  for (const Gather& gather : seams) gathering.add(gather);
  if (gathering.empty()) return std::nullopt;
  return gathering.result();
}

}  // namespace voile::mesh
