#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "operations.hpp"

namespace voile::adapt {

namespace {

/// Chord error of a line that a collapse may leave, relative to the edge: L/(8 R) of an arc, with the longest edge that is not halved,
/// 1.4 times the tenth of R that curved free edges get (sizing.hpp).
constexpr double largest_chord_error = 1.4 / 80.0;
constexpr int largest_valence = 9;

/// A fan of the star and which of its ring the centre becomes; on lines also the other end of the line.
struct Part {
  Fan fan;
  int at = 0;
  int other = -1;
};

std::vector<Part> parts_of(const Surface& s, const Star& star, int k) {
  const int n = star.triangles();
  std::vector<Part> parts;
  if (!s.on_feature[star.vertex]) {
    parts.push_back({make_fan(s, star, 0, n), k, -1});
  } else if (!star.closed) {
    parts.push_back({make_fan(s, star, 0, n), k, k == 0 ? n : 0});
  } else {
    const int j = other_line(s, star, k), count = (j - k + n) % n;
    parts.push_back({make_fan(s, star, k, count), 0, count});
    parts.push_back({make_fan(s, star, j, n - count), n - count, 0});
  }
  for (Part& p : parts) {
    if (p.other < 0) continue;
    // In the plane the vertex is first slid onto the chord, so that both fans cover the same.
    const Vec2 &a = p.fan.plane[p.at], &b = p.fan.plane[p.other];
    const double to_a = (p.fan.centre - a).norm(), to_b = (p.fan.centre - b).norm();
    p.fan.centre = a + to_a / (to_a + to_b) * (b - a);
  }
  return parts;
}

bool topology_allows(const Surface& s, const Star& star, int k) {
  const Index v = star.vertex, u = star.ring[k];
  const int n = star.triangles(), m = static_cast<int>(star.ring.size());
  if (s.fixed[v]) return false;
  if (u < static_cast<Index>(s.features.pinched.size()) && s.features.pinched[u]) return false;
  if (n < (star.closed ? 3 : 2)) return false;
  if (!star.closed && k != 0 && k != n) return false;
  if (s.on_feature[v]) {
    if (star.closed && s.side_class[star.spokes[k]] == 0) return false;
    const int j = star.closed ? other_line(s, star, k) : (k == 0 ? n : 0);
    if (j < 0 || std::abs(j - k) == 1 || (star.closed && std::abs(j - k) == n - 1)) return false;
  }
  for (int i = 0; i < m; ++i) {
    const int apart = std::min(std::abs(i - k), star.closed ? m - std::abs(i - k) : m);
    if (apart > 1 && (s.joined(s.leaving[u], star.ring[i]) || !s.can_join(u, star.ring[i]))) return false;
  }
  return true;
}

bool valences_allow(const Surface& s, const Star& star, int k) {
  const Index u = star.ring[k];
  const int m = static_cast<int>(star.ring.size());
  for (const int i : {k - 1, k + 1}) {
    if (!star.closed && (i < 0 || i >= m)) continue;
    const Index r = star.ring[(i + m) % m];
    const Surface::Valence valence = s.valence(s.leaving[r]);
    if (valence.edges - 1 < (valence.inside ? 4 : s.fixed[r] ? 2 : 3)) return false;
  }
  const Surface::Valence valence = s.valence(s.leaving[u]);
  const int after = valence.edges + m - (star.closed ? 4 : 3);
  return after <= largest_valence && after >= (valence.inside ? 4 : 2);
}

bool lines_allow(const Surface& s, const std::vector<Part>& parts) {
  for (const Part& p : parts) {
    if (p.other < 0) continue;
    const Vec3 &a = p.fan.rest[p.at], &b = p.fan.rest[p.other];
    const Vec3 x = p.fan.centre_rest - a, along = (b - a).normalized();
    const double error = std::max((x - x.dot(along) * along).norm(), s.first->curve_deviation(a, b));
    if (!(error < largest_chord_error * (b - a).norm())) return false;
  }
  return true;
}

/// Smallest angles before and after, and whether new triangles fit the smooth piece.
bool shape_allows(const Surface& s, const Star& star, const Part& p, double angle, double least) {
  const Fan& fan = p.fan;
  const Vec3& u = fan.rest[p.at];
  double before = std::numeric_limits<double>::infinity(), after = before;
  Vec3 last = Vec3::Zero();
  const int n = fan.triangle_count();
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % fan.size();
    before = std::min(before, smallest_angle(fan.centre_rest, fan.rest[i], fan.rest[j], fan.normal));
    if (i == p.at || j == p.at) continue;
    after = std::min(after, smallest_angle(u, fan.rest[i], fan.rest[j], fan.normal));
    if (after < 0.0 || after < std::min(angle, before)) return false;
    const Vec2 a = fan.plane[i] - fan.plane[p.at], b = fan.plane[j] - fan.plane[p.at];
    if (a.x() * b.y() - a.y() * b.x() <= 0.0) return false;
    if (!s.first->curved()) continue;
    const Vec3 normal = (fan.rest[i] - u).cross(fan.rest[j] - u).normalized();
    const double limit = std::cos(largest_rest_dihedral);
    const Index outer = next(star.spokes[fan.triangles[i]]);
    if (s.side_class[outer] == 0 && normal.dot(s.rest_normal(s.twin[outer] / 3)) < limit) return false;
    if (last != Vec3::Zero() && normal.dot(last) < limit) return false;
    last = normal;
  }
  return after >= std::max(least, std::min(angle, before));
}

bool lengths_allow(const Surface& s, const Star& star, const Part& p, double longest) {
  const Fan& fan = p.fan;
  const Index u = star.ring[fan.ring[p.at]];
  for (int i = 0; i < fan.size(); ++i) {
    if (i == p.at) continue;
    const Index r = star.ring[fan.ring[i]];
    const int apart = std::abs(i - p.at);
    if (apart == 1 || (fan.closed && apart == fan.size() - 1)) continue;
    if (2.0 * (fan.rest[i] - fan.rest[p.at]).norm() >= longest * (s.size[u] + s.size[r])) return false;
  }
  return true;
}

/// Joins what lies on both outer sides of a triangle that goes: `inner` is its side at the removed vertex.
void close(Surface& s, Index inner, Index outer) {
  const Index a = s.twin[inner], b = s.twin[outer];
  const int line = s.side_class[outer];
  if (a != no_index) {
    s.twin[a] = b;
    s.side_class[a] = line;
    s.leaving[s.origin(a)] = a;
    s.leaving[s.dest(a)] = next(a);
  }
  if (b != no_index) s.twin[b] = a;
  s.dead[inner / 3] = 1;
}

void perform(Surface& s, const Star& star, int k, const std::vector<Part>& parts) {
  const int n = star.triangles();
  const Index u = star.ring[k];
  const bool has_left = k < n, has_right = star.closed || k > 0;
  const int right = (k - 1 + n) % n;
  for (const Part& p : parts) {
    // Texture coordinates of the vertex that takes over, from the triangle of this part that goes.
    const bool from_left = p.fan.closed || p.at == 0;
    const Index corner = from_left ? prev(star.spokes[k]) : star.spokes[right];
    const Vec2 texture = s.texture.empty() ? Vec2::Zero() : s.texture[corner];
    for (int i : p.fan.triangles) {
      const Index c = next(star.spokes[i]);
      s.touched[c / 3] = 1;
      if ((has_left && i == k) || (has_right && i == right)) continue;
      s.rest[c] = p.fan.rest[p.at];
      if (!s.texture.empty()) s.texture[c] = texture;
    }
  }
  for (int i = 0; i < n; ++i)
    if (!((has_left && i == k) || (has_right && i == right))) s.vertex[next(star.spokes[i])] = u;
  if (has_left) close(s, prev(star.spokes[k]), next(star.spokes[k]));
  if (has_right) close(s, star.spokes[right], next(star.spokes[right]));
  s.gone[star.vertex] = 1;
  for (Index r : star.ring) s.dirty[r] = 1;
  ++s.counts.collapses;
}

}  // namespace

Outcome try_collapse(Surface& s, const Star& star, int k, const Options& options, const CollapseRule& rule) {
  if (!topology_allows(s, star, k)) return Outcome::feature;
  if (!valences_allow(s, star, k)) return Outcome::quality;
  const std::vector<Part> parts = parts_of(s, star, k);
  if (!lines_allow(s, parts)) return Outcome::feature;
  for (const Part& p : parts)
    if ((rule.sizes && !lengths_allow(s, star, p, options.longest_after)) ||
        !shape_allows(s, star, p, options.smallest_angle, rule.angle))
      return Outcome::quality;
  if (!s.allowed.empty()) {
    std::vector<Index> triangles;
    for (Index e : star.spokes) triangles.push_back(e / 3);
    const Surface::Budget budget = s.budget(triangles);
    double moved = 0.0;
    for (const Part& p : parts)
      moved = std::max(moved, displacement(p.fan, p.fan.plane[p.at], p.fan.place[p.at], p.at));
    if (!(budget.moved + moved <= budget.allowed)) return Outcome::clearance;
    s.charge(triangles, budget, moved);
  }
  perform(s, star, k, parts);
  return Outcome::done;
}

Outcome try_collapse_edge(Surface& s, Index h, const Options& options) {
  const Index o = s.origin(h), d = s.dest(h);
  const bool other_first = s.old[o] != no_index && s.old[d] == no_index;
  Outcome last = Outcome::feature;
  for (const bool swap : {other_first, !other_first}) {
    const Index v = swap ? d : o, u = swap ? o : d;
    if (s.fixed[v] || (s.on_feature[v] && s.side_class[h] == 0)) continue;
    const Star star = star_of(s, v);
    const auto k = std::find(star.ring.begin(), star.ring.end(), u) - star.ring.begin();
    last = try_collapse(s, star, static_cast<int>(k), options);
    if (last == Outcome::done) return last;
  }
  return last;
}

}  // namespace voile::adapt
