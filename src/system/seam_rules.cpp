#include "seam_rules.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/text.hpp"
#include "base/wildcard.hpp"
#include "mesh/weld.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

const SeamRule* rule_of(const std::string& seam, const std::vector<SeamRule>& rules) {
  const SeamRule *general = nullptr, *starred = nullptr;
  for (const SeamRule& rule : rules) {
    if (rule.seam == seam) return &rule;
    if (rule.seam.empty()) general = &rule;
    if (star_of(rule.seam, seam)) starred = &rule;
  }
  return starred ? starred : general;
}

const SeamRule* rule_of(const mesh::Group& group, const std::vector<SeamRule>& rules) {
  const std::string prefix = mesh::seam_group("");
  if (group.dimension != 1 || !group.name.starts_with(prefix)) return nullptr;
  return rule_of(group.name.substr(prefix.size()), rules);
}

/// Calls visit(triangle, side) for the triangles on either side of an edge.
template <class Visit>
void for_sides(const mesh::SurfaceMesh& mesh, const mesh::Segment& edge, const Visit& visit) {
  for (const Index t : mesh.triangles_of_vertex(edge[0]))
    if (const int s = mesh.side_of(t, edge[0], edge[1]); s >= 0) visit(t, s);
}

/// The part of a convex polygon where normal . x <= bound.
std::vector<Vec2> clipped(const std::vector<Vec2>& polygon, const Vec2& normal, double bound) {
  std::vector<Vec2> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = normal.dot(a) - bound, db = normal.dot(b) - bound;
    if (da <= 0.0) kept.push_back(a);
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) kept.push_back(a + da / (da - db) * (b - a));
  }
  return kept;
}

double area_of(const std::vector<Vec2>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * std::abs(twice);
}

/// The strip along one side of a triangle, in the plane of that triangle: [0, length] x [0, width].
class Strip {
 public:
  Strip(const mesh::SurfaceMesh& mesh, Index t, int s, double width) : mesh_(mesh), width_(width) {
    origin_ = mesh.rest_corner(t, (s + 1) % 3);
    const Vec3 side = mesh.rest_corner(t, (s + 2) % 3) - origin_;
    length_ = side.norm();
    along_ = side / length_;
    inward_ = mesh.rest_normal(t).cross(along_);
  }

  /// Area that it has of a triangle.
  [[nodiscard]] double cover(Index t) {
    std::vector<Vec2> polygon;
    for (int i = 0; i < 3; ++i) {
      const Vec3 x = mesh_.rest_corner(t, i) - origin_;
      polygon.emplace_back(x.dot(along_), x.dot(inward_));
    }
    polygon = clipped(clipped(polygon, -Vec2::UnitX(), 0.0), Vec2::UnitX(), length_);
    polygon = clipped(clipped(polygon, -Vec2::UnitY(), 0.0), Vec2::UnitY(), width_);
    for (const Vec2& x : polygon) depth_ = std::max(depth_, x[1]);
    return area_of(polygon);
  }
  /// How far it reaches inwards in the triangles that it covers [m].
  [[nodiscard]] double depth() const { return depth_; }

 private:
  const mesh::SurfaceMesh& mesh_;
  double width_, length_ = 0.0, depth_ = 0.0;
  Vec3 origin_, along_, inward_;
};

/// Spreads a strip from triangle t over the triangles of its chart that it reaches. Returns its depth there [m].
double lay(const mesh::SurfaceMesh& mesh, Index t, int s, double width, std::vector<double>& areas) {
  Strip strip(mesh, t, s, width);
  std::vector<Index> queue{t};
  std::set<Index> seen{t};
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const double area = strip.cover(queue[k]);
    if (!(area > 0.0)) continue;
    areas[queue[k]] += area;
    for (int i = 0; i < 3; ++i) {
      const Index n = mesh.neighbour(queue[k], i);
      if (n != no_index && mesh.chart_join(queue[k], i).same_chart && seen.insert(n).second) queue.push_back(n);
    }
  }
  return strip.depth();
}

/// The piece that a triangle is cut from; empty if it has no name.
std::string piece_of(const mesh::SurfaceMesh& mesh, Index t) {
  for (const mesh::Group& group : mesh.groups())
    if (std::binary_search(group.triangles.begin(), group.triangles.end(), t)) return group.name;
  return "";
}

/// `depths`: of the deepest strip of the seam in each piece [m].
void require_room(const mesh::SurfaceMesh& mesh, const mesh::Group& seam, double width,
                  const std::map<std::string, double>& depths) {
  constexpr double enough = 0.98;  // of the width, where the mesh cuts corners off the piece
  for (const auto& [piece, depth] : depths)
    if (depth < enough * width)
      throw UserError(fmt::format(
          "{}: seam '{}': its allowance of {:g} m is wider than piece '{}', which ends {:.3g} m from the seam; make "
          "allowance of [[seam]] or [sewing] smaller",
          mesh.source(), seam.name.substr(mesh::seam_group("").size()), width, piece, depth));
}

}  // namespace

std::vector<energy::BendingSide> bending_across_seams(const mesh::SurfaceMesh& mesh,
                                                      const std::vector<SeamRule>& rules) {
  std::vector<energy::BendingSide> sides;
  for (const mesh::Group& group : mesh.groups()) {
    const SeamRule* rule = rule_of(group, rules);
    if (!rule || rule->bending == 1.0) continue;
    for (const mesh::Segment& edge : group.segments)
      for_sides(mesh, edge, [&](Index t, int s) {
        if (mesh.neighbour(t, s) != no_index) sides.push_back({{t, s}, rule->bending});
      });
  }
  return sides;
}

double bending_of(const std::string& seam, const std::vector<SeamRule>& rules) {
  const SeamRule* rule = rule_of(seam, rules);
  return rule ? rule->bending : 1.0;
}

double allowance_of(const std::string& seam, const std::vector<SeamRule>& rules) {
  const SeamRule* rule = rule_of(seam, rules);
  return rule ? rule->allowance : 0.0;
}

std::vector<double> bending_of_joints(const mesh::SurfaceMesh& mesh, const std::vector<SeamRule>& rules) {
  const std::vector<mesh::Joint>& joints = mesh.joints();
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<double> factors(joints.size(), none);
  for (const mesh::Group& group : mesh.groups()) {
    const SeamRule* rule = joints.empty() ? nullptr : rule_of(group, rules);
    if (!rule) continue;
    for (const mesh::Segment& segment : group.segments) {
      const mesh::Segment edge{std::min(segment[0], segment[1]), std::max(segment[0], segment[1])};
      const auto at = std::lower_bound(joints.begin(), joints.end(), edge,
                                       [](const mesh::Joint& j, const mesh::Segment& e) { return j.edge < e; });
      if (at == joints.end() || at->edge != edge) continue;
      double& factor = factors[static_cast<std::size_t>(at - joints.begin())];
      factor = std::max(least_factor, std::min(factor, rule->bending));
    }
  }
  for (double& factor : factors)
    if (factor == none) factor = 1.0;
  return factors;
}

std::vector<double> allowance_areas(const mesh::SurfaceMesh& mesh, const std::vector<SeamRule>& rules) {
  std::vector<double> areas;
  std::set<mesh::TriangleSide> laid;  // a side in two seams has one strip
  for (const mesh::Group& group : mesh.groups()) {
    const SeamRule* rule = rule_of(group, rules);
    if (!rule || rule->allowance == 0.0) continue;
    areas.resize(static_cast<std::size_t>(mesh.triangle_count()), 0.0);
    std::map<std::string, double> depths;
    for (const mesh::Segment& edge : group.segments)
      for_sides(mesh, edge, [&](Index t, int s) {
        if (!laid.insert({t, s}).second) return;
        double& depth = depths[piece_of(mesh, t)];
        depth = std::max(depth, lay(mesh, t, s, rule->allowance, areas));
      });
    require_room(mesh, group, rule->allowance, depths);
  }
  return areas;
}

std::vector<mesh::Gather> gathers(const mesh::SurfaceMesh& mesh, const Seams& seams) {
  const std::vector<std::string> open = mesh::open_seams(mesh.data(), {"all"}),
                                 closing = mesh::open_seams(mesh.data(), seams.pulled);
  std::vector<mesh::Gather> found;
  const std::size_t prefix = mesh::seam_group("").size();
  for (const mesh::Group& group : mesh.groups()) {
    const SeamRule* rule = rule_of(group, seams.rules);
    if (!rule || !std::isfinite(rule->gather_from)) continue;
    const std::string seam = group.name.substr(prefix);
    if (!contains(open, seam) || contains(closing, seam))
      found.push_back({seam, rule->gather_from, rule->gather_width});
  }
  return found;
}

std::vector<SeamRule> with_gather_widths(std::vector<SeamRule> rules, const mesh::SurfaceMesh& first) {
  for (const mesh::Gather& gather : gathers(first, {rules, {"all"}})) {
    const double width = mesh::gather_width(first, gather);
    if (width == 0.0) continue;
    const auto own =
        std::find_if(rules.begin(), rules.end(), [&](const SeamRule& rule) { return rule.seam == gather.seam; });
    if (own != rules.end()) {
      own->gather_width = width;
      continue;
    }
    SeamRule rule = *rule_of(first.group(mesh::seam_group(gather.seam), 1), rules);
    rule.seam = gather.seam;
    rule.gather_width = width;
    rules.push_back(std::move(rule));
  }
  return rules;
}

void add_allowances(const mesh::SurfaceMesh& mesh, const std::vector<SeamRule>& rules,
                    std::vector<energy::Material>& materials, std::vector<int>& material_of) {
  const std::vector<double> areas = allowance_areas(mesh, rules);
  for (std::size_t t = 0; t < areas.size(); ++t) {
    if (areas[t] == 0.0) continue;
    energy::Material m = materials[static_cast<std::size_t>(material_of[t])];
    const double layers = 1.0 + areas[t] / mesh.area(static_cast<Index>(t));
    m.membrane *= layers;
    m.bending *= layers;
    m.areal_density *= layers;
    m.rubber.scale(layers);
    for (energy::YarnFriction::Slider& slider : m.friction.sliders) {
      slider.stiffness *= layers;
      slider.limit *= layers;
    }
    for (auto& knots : m.yarns.knots)
      for (energy::YarnLaw::Knot& knot : knots) knot.bend *= layers;
    for (double* figure : {&m.yarns.stiffness, &m.yarns.limit, &m.yarns.rise}) *figure *= layers;
    material_of[t] = static_cast<int>(materials.size());
    materials.push_back(std::move(m));
  }
}

}  // namespace voile::system
