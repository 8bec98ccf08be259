#include "garment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include "base/text.hpp"
#include "formats/gmsh_polygon.hpp"
#include "layers.hpp"
#include "mesh/weld.hpp"
#include "outline.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Room between pieces in the plane of their charts, as a fraction of their width.
constexpr double chart_room = 0.1;

/// Fraction of the length of an edge below which two nodes are one.
constexpr double near_node = 1e-7;

/// Nodes of one edge in its own direction: fractions of its length, and vertices of the mesh.
struct EdgeNodes {
  std::vector<double> fractions;
  std::vector<Index> vertices;
};

/// Of all panels, for messages: "a.svg", "a.svg and b.svg", "a.svg and 3 more files".
std::string files_of(const std::vector<Panel>& panels) {
  const std::string& first = panels.front().file;
  std::set<std::string> others;
  for (const Panel& p : panels)
    if (p.file != first) others.insert(p.file);
  if (others.empty()) return first;
  if (others.size() > 1) return fmt::format("{} and {} more files", first, others.size());
  return first + " and " + std::filesystem::path(*others.begin()).filename().string();
}

/// Cells of a panel beyond which its size must be a mistake.
constexpr double most_cells = 2e6;

std::string where(const Panel& p) {
  return fmt::format("{}: piece '{}'", p.file, p.piece.name);
}

/// Of each vertex the others of its triangles.
std::vector<std::vector<Index>> neighbours(const mesh::MeshData& mesh) {
  std::vector<std::vector<Index>> all(mesh.positions.size());
  for (const mesh::Triangle& t : mesh.triangles)
    for (const Index v : t)
      for (const Index w : t)
        if (v != w && !contains(all[static_cast<std::size_t>(v)], w)) all[static_cast<std::size_t>(v)].push_back(w);
  return all;
}

class Cutter {
 public:
  Cutter(Garment& garment, const std::vector<Mark>& marks) : g_(garment), marks_(marks), nodes_(garment.panels.size()) {
    for (std::size_t p = 0; p < nodes_.size(); ++p) nodes_[p].resize(panel(p).piece.edges.size());
  }

  void run() {
    seam_fractions_ = seam_nodes(g_.panels, g_.seams.lines);
    for (std::size_t k = 0; k < seam_fractions_.size(); ++k) {
      const SeamLine& seam = g_.seams.lines[k];
      for (std::size_t s = 0; s < 2; ++s) spread(seam.sides[s], seam.lengths[s], seam_fractions_[k][s]);
    }
    std::vector<formats::Polygon> polygons;
    for (std::size_t p = 0; p < nodes_.size(); ++p) polygons.push_back(polygon(p));
    const std::vector<formats::Triangulation> cut = formats::mesh_polygons(g_.mesh.source, polygons);
    double x = 0.0;
    for (std::size_t p = 0; p < nodes_.size(); ++p) add_panel(p, cut[p], x);
    neighbours_ = neighbours(g_.mesh);
    for (std::size_t k = 0; k < seam_fractions_.size(); ++k) add_seam(k);
    for (mesh::Group& group : mark_groups_) g_.mesh.groups.push_back(std::move(group));
  }

  /// Segments that seams make one.
  [[nodiscard]] std::vector<SewnPair> take_pairs() { return std::move(pairs_); }

 private:
  [[nodiscard]] const Panel& panel(std::size_t p) const { return g_.panels[p]; }
  [[nodiscard]] const Curve& curve(const EdgeUse& e) const { return panel(e.panel).piece.edges[e.edge].curve; }

  /// Gives the nodes of a side of a seam to its edges.
  void spread(const std::vector<EdgeUse>& side, double total, const std::vector<double>& fractions) {
    double before = 0.0;
    for (const EdgeUse& e : side) {
      const double length = curve(e).length();
      std::vector<double>& own = nodes_[e.panel][e.edge].fractions;
      for (const double f : fractions) {
        const double local = (f * total - before) / length;
        if (local > near_node && local < 1.0 - near_node) own.push_back(e.reversed ? 1.0 - local : local);
      }
      own.insert(own.end(), {0.0, 1.0});
      std::sort(own.begin(), own.end());  // seams with a common edge have the same nodes there
      own.erase(std::unique(own.begin(), own.end(), [](double a, double b) { return b - a < near_node; }), own.end());
      before += length;
    }
  }

  [[nodiscard]] formats::Polygon polygon(std::size_t p) {
    const Piece& piece = panel(p).piece;
    formats::Polygon polygon{fmt::format("piece '{}'", piece.name), {}, piece.outline(), panel(p).size};
    bool is_too_coarse = false;
    for (const Piece::Loop& loop : piece.loops()) {
      polygon.loops.push_back(nodes_of(p, loop));
      is_too_coarse = is_too_coarse || polygon.loops.back().size() < 3;
    }
    if (is_too_coarse || find_crossing(polygon.loops) || find_stray(polygon.loops, polygon.outline))
      throw UserError(fmt::format("{}: cells of {:.4g} m are too coarse for its outline; make its key size smaller",
                                  where(panel(p)), panel(p).size));
    for (const Mark& mark : marks_)
      if (mark.panel == p && !mark.point) polygon.inside.push_back(mark.at);
    return polygon;
  }

  [[nodiscard]] std::vector<Vec2> nodes_of(std::size_t p, const Piece::Loop& loop) {
    std::vector<Vec2> points;
    for (std::size_t k = loop.begin; k < loop.end; ++k) {
      const Curve& c = panel(p).piece.edges[k].curve;
      std::vector<double>& fractions = nodes_[p][k].fractions;
      if (fractions.empty()) {
        const int cells =
            std::max(c.is_line() ? 1 : least_on_curve, static_cast<int>(std::ceil(c.length() / panel(p).size - 0.2)));
        for (int i = 0; i <= cells; ++i) fractions.push_back(static_cast<double>(i) / cells);
      }
      const std::vector<double> t = c.parameters_at(fractions);
      for (std::size_t i = 0; i + 1 < t.size(); ++i) points.push_back(c.at(t[i]));
    }
    return points;
  }

  /// `x`: where the next chart begins.
  void add_panel(std::size_t p, const formats::Triangulation& cut, double& x) {
    mesh::MeshData& m = g_.mesh;
    auto first = static_cast<Index>(m.positions.size());
    const Extent e = extent_of(panel(p).piece);
    const Vec3 shift(x - e.low[0], -e.low[1], 0.0);
    x += (1.0 + chart_room) * (e.high[0] - e.low[0]);
    for (const Vec2& at : cut.points) m.positions.push_back(panel(p).place(at));
    const Vec2& grain = panel(p).piece.grain;
    const Mat2 upright = (Mat2() << grain[1], -grain[0], grain[0], grain[1]).finished();  // the grain line along y
    mesh::Group whole{panel(p).piece.name, 2, {}, {}, {}};
    for (mesh::Triangle t : cut.triangles) {
      if (panel(p).piece.turned) std::swap(t[1], t[2]);
      whole.triangles.push_back(static_cast<Index>(m.triangles.size()));
      const auto at = [&](std::size_t i) { return cut.points[static_cast<std::size_t>(t[i])]; };
      const auto chart = [&](std::size_t i) { return Vec3(Vec3(at(i)[0], at(i)[1], 0.0) + shift); };
      m.texture.push_back({upright * at(0), upright * at(1), upright * at(2)});
      m.rest.push_back({chart(0), chart(1), chart(2)});
      m.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    whole.vertices.resize(cut.points.size());
    std::iota(whole.vertices.begin(), whole.vertices.end(), first);
    m.groups.push_back(std::move(whole));
    for (const Piece::Loop& loop : panel(p).piece.loops()) add_edges(p, loop, first);
    for (const Mark& mark : marks_)
      if (mark.panel == p)
        mark_groups_.push_back({mark.name, 0, {mark.point ? corner_of(p, *mark.point) : first++}, {}, {}});
  }

  /// Vertex of a point of a panel.
  [[nodiscard]] Index corner_of(std::size_t p, std::size_t point) const { return nodes_[p][point].vertices.front(); }

  /// `first`: the vertex at which the loop begins; then that of the next loop.
  void add_edges(std::size_t p, const Piece::Loop& loop, Index& first) {
    Index begin = 0, count = 0;
    for (std::size_t k = loop.begin; k < loop.end; ++k) count += static_cast<Index>(nodes_[p][k].fractions.size()) - 1;
    for (std::size_t k = loop.begin; k < loop.end; ++k) {
      EdgeNodes& e = nodes_[p][k];
      mesh::Group group{fmt::format("{}/{}", panel(p).piece.name, k), 1, {}, {}, {}};
      for (std::size_t i = 0; i < e.fractions.size(); ++i)
        e.vertices.push_back(first + (begin + static_cast<Index>(i)) % count);
      begin += static_cast<Index>(e.fractions.size()) - 1;
      for (std::size_t i = 0; i + 1 < e.vertices.size(); ++i)
        group.segments.push_back({e.vertices[i], e.vertices[i + 1]});
      group.vertices = e.vertices;
      std::sort(group.vertices.begin(), group.vertices.end());
      g_.mesh.groups.push_back(group);
      const std::string& label = panel(p).piece.edges[k].label;
      if (!label.empty()) add_label(fmt::format("{}/{}", panel(p).piece.name, label), group);
    }
    first += count;
  }

  /// Edges with the same label are one group.
  void add_label(const std::string& name, mesh::Group group) {
    auto& groups = g_.mesh.groups;
    const auto at = std::find_if(groups.begin(), groups.end(), [&](const mesh::Group& g) { return g.name == name; });
    group.name = name;
    if (at == groups.end()) {
      groups.push_back(std::move(group));
      return;
    }
    at->vertices.insert(at->vertices.end(), group.vertices.begin(), group.vertices.end());
    std::sort(at->vertices.begin(), at->vertices.end());
    at->vertices.erase(std::unique(at->vertices.begin(), at->vertices.end()), at->vertices.end());
    at->segments.insert(at->segments.end(), group.segments.begin(), group.segments.end());
  }

  /// Vertices of a side, one after the other; two where one edge ends and another begins elsewhere.
  [[nodiscard]] std::vector<std::vector<Index>> vertices_of(const std::vector<EdgeUse>& side) const {
    std::vector<std::vector<Index>> all;
    for (const EdgeUse& e : side) {
      std::vector<Index> own = nodes_[e.panel][e.edge].vertices;
      if (e.reversed) std::reverse(own.begin(), own.end());
      std::size_t i = 0;
      if (!all.empty()) {
        if (all.back().front() != own.front()) all.back().push_back(own.front());
        i = 1;
      }
      for (; i < own.size(); ++i) all.push_back({own[i]});
    }
    return all;
  }

  /// Whether sewing two vertices of one piece would put edges of more than two cells onto each other. `tip`: sewn between them.
  [[nodiscard]] bool would_fold(Index v, Index w, Index tip) const {
    const std::vector<Index>&near = neighbours_[static_cast<std::size_t>(v)],
          &other = neighbours_[static_cast<std::size_t>(w)];
    if (contains(near, w)) return true;
    return std::any_of(near.begin(), near.end(), [&](Index n) { return n != tip && contains(other, n); });
  }

  /// How many pairs beside a corner that is sewn to itself stay open, as too few cells lie between them.
  [[nodiscard]] std::size_t open_at_tip(const std::vector<std::vector<Index>>& a,
                                        const std::vector<std::vector<Index>>& b, bool at_end) const {
    const std::size_t n = a.size();
    const auto at = [&](std::size_t i) { return at_end ? n - 1 - i : i; };
    if (a[at(0)] != b[at(0)]) return 0;
    std::size_t open = 0;
    for (std::size_t i = 1; i < n / 2; ++i)
      if (would_fold(a[at(i)].front(), b[at(i)].front(), i == 1 ? a[at(0)].front() : no_index)) open = i;
    return open;
  }

  /// What a user should know of a tip.
  void note_open(const SeamLine& line, const std::vector<double>& fractions, std::size_t last, std::size_t tip) {
    const double length = std::abs(fractions[last] - fractions[tip]) * std::min(line.lengths[0], line.lengths[1]);
    g_.mesh.notes.push_back(
        fmt::format("seam '{}': {:.3g} m of it at its {} stay open: where its two sides meet in a corner of one piece "
                    "too few cells "
                    "lie between them",
                    line.name, length, tip == 0 ? "beginning" : "end"));
  }

  void add_seam(std::size_t k) {
    const SeamLine& line = g_.seams.lines[k];
    const auto a = vertices_of(line.sides[0]), b = vertices_of(line.sides[1]);
    const auto& fractions = seam_fractions_[k];
    if (a.size() != b.size() || a.size() != fractions[0].size())
      throw InternalError(fmt::format("seam '{}': {} and {} nodes", line.name, a.size(), b.size()));
    mesh::Seam seam{line.name, {}, {}, {}};
    const std::size_t open = open_at_tip(a, b, false), open_end = a.size() - open_at_tip(a, b, true);
    if (open > 0) note_open(line, fractions[0], open + 1, 0);
    if (open_end < a.size()) note_open(line, fractions[0], open_end - 2, a.size() - 1);
    const double length = 0.5 * (line.lengths[0] + line.lengths[1]);
    for (std::size_t i = 0; i < a.size(); ++i) {
      if ((i > 0 && i <= open) || (i + 1 >= open_end && i + 1 < a.size())) continue;
      const double low = i > 0 ? fractions[0][i - 1] : 0.0, high = i + 1 < a.size() ? fractions[0][i + 1] : 1.0;
      const auto pair = [&](Index v, Index w) {
        if (v == w) return;
        const double own = 0.5 * (high - low) * length;
        if (!seam.pairs.empty() && seam.pairs.front() == std::array{v, w}) {  // round a hole, and back
          seam.lengths.front() += own;
          return;
        }
        seam.pairs.push_back({v, w});
        seam.lengths.push_back(own);
        seam.stations.push_back(fractions[0][i] * length);
      };
      pair(a[i].front(), b[i].front());
      if (a[i].size() > 1) pair(a[i].back(), b[i].back());
      if (a[i].size() == 1 && b[i].size() > 1) pair(a[i].front(), b[i].back());
      if (a[i].size() > 1 && b[i].size() > 1) pair(a[i].front(), b[i].back());
      if (i > 0 && (open == 0 || i > open + 1) && (open_end == a.size() || i + 1 < open_end))
        pairs_.push_back({{segment(a[i - 1], a[i]), segment(b[i - 1], b[i])}, k});
    }
    g_.mesh.seams.push_back(std::move(seam));
    add_seam_group(line);
  }

  static mesh::Segment segment(const std::vector<Index>& from, const std::vector<Index>& to) {
    return mesh::ascending(from.back(), to.front());
  }

  /// Both sides of a seam, which a weld makes one line of.
  void add_seam_group(const SeamLine& line) {
    mesh::Group group{mesh::seam_group(line.name), 1, {}, {}, {}};
    for (const auto& side : line.sides)
      for (const EdgeUse& e : side) {
        const std::vector<Index>& v = nodes_[e.panel][e.edge].vertices;
        group.vertices.insert(group.vertices.end(), v.begin(), v.end());
        for (std::size_t i = 0; i + 1 < v.size(); ++i) group.segments.push_back({v[i], v[i + 1]});
      }
    std::sort(group.vertices.begin(), group.vertices.end());
    group.vertices.erase(std::unique(group.vertices.begin(), group.vertices.end()), group.vertices.end());
    g_.mesh.groups.push_back(std::move(group));
  }

  Garment& g_;
  const std::vector<Mark>& marks_;
  std::vector<mesh::Group> mark_groups_;
  std::vector<std::vector<EdgeNodes>> nodes_;
  std::vector<std::array<std::vector<double>, 2>> seam_fractions_;
  std::vector<SewnPair> pairs_;
  std::vector<std::vector<Index>> neighbours_;  ///< of each vertex
};

}  // namespace

Garment make_garment(std::vector<Panel> panels, const std::vector<SeamRequest>& seams,
                     const std::vector<MarkRequest>& mark_requests) {
  Garment g;
  if (panels.empty()) throw InternalError("a garment without panels");
  for (std::size_t p = 0; p < panels.size(); ++p) {
    panels[p].check_wrap();
    if (const double cells = 2.3 * std::abs(panels[p].piece.signed_area()) / std::pow(panels[p].size, 2);
        cells > most_cells)
      throw UserError(fmt::format("{}: cells of {:.3g} m would be about {:.2g} in number; make the key size larger",
                                  where(panels[p]), panels[p].size, cells));
    for (std::size_t q = 0; q < p; ++q)
      if (panels[p].piece.name == panels[q].piece.name)
        throw UserError(
            fmt::format("{}: another piece has this name; give one of them the key name", where(panels[p])));
  }
  g.mesh.source = files_of(panels);
  g.seams = resolve_seams(panels, seams);
  const std::vector<Mark> marks = resolve_marks(panels, mark_requests);
  g.panels = std::move(panels);
  g.mesh.notes = g.seams.notes;
  Cutter cutter(g, marks);
  cutter.run();
  for (std::size_t k = 0; k < g.mesh.groups.size(); ++k)
    for (std::size_t l = 0; l < k; ++l)
      if (g.mesh.groups[k].dimension == 0 && g.mesh.groups[l].name == g.mesh.groups[k].name)
        throw UserError(fmt::format("{}: mark '{}': a piece, edge or seam has this name; choose another", g.mesh.source,
                                    g.mesh.groups[k].name));
  std::vector<std::string> wheres;
  for (const SeamRequest& seam : seams) wheres.push_back(seam.where);
  take_layers(g.mesh, cutter.take_pairs(), wheres);
  return g;
}

std::map<std::string, std::vector<std::string>> layered_edges(const Garment& g) {
  std::map<std::string, std::vector<std::string>> seams;
  for (const SeamLine& line : g.seams.lines)
    for (const auto& side : line.sides)
      for (const EdgeUse& e : side)
        seams[fmt::format("{}/{}", g.panels[e.panel].piece.name, e.edge)].push_back(line.name);
  std::erase_if(seams, [](const auto& entry) { return entry.second.size() < 2; });
  return seams;
}

std::string garment_text(const Garment& g, const std::vector<double>& densities,
                         const std::vector<double>& allowances) {
  std::string text = "panels:\n";
  double area = 0.0, boxes = 0.0, mass = 0.0, added = 0.0;
  for (std::size_t k = 0; k < g.panels.size(); ++k) {
    const Panel& p = g.panels[k];
    const Extent e = extent_of(p.piece);
    const Vec2 size = e.high - e.low;
    double around = 0.0;
    for (const Edge& edge : p.piece.edges) around += edge.curve.length();
    const double own = std::abs(p.piece.signed_area());
    const std::size_t holes = p.piece.further_loops.size();
    const double own_mass = (own + allowances[k]) * densities[k];
    text += fmt::format("  '{}': {:.6g} m^2, {:.4g} kg, {:.4g} m x {:.4g} m, {} edges of {:.5g} m together{}\n",
                        p.piece.name, own, own_mass, size[0], size[1], p.piece.edges.size(), around,
                        holes > 0 ? fmt::format(", {} hole{}", holes, holes > 1 ? "s" : "") : "");
    area += own;
    added += allowances[k];
    mass += own_mass;
    boxes += size[0] * size[1];
  }
  if (!g.seams.lines.empty()) text += "seams:\n";
  double sewn = 0.0;
  for (const SeamLine& s : g.seams.lines) {
    text += fmt::format("  '{}': {:.5g} m to {:.5g} m, at most {:.4g} m apart at the start\n", s.name, s.lengths[0],
                        s.lengths[1], s.farthest);
    sewn += 0.5 * (s.lengths[0] + s.lengths[1]);
  }
  text += fmt::format(
      "fabric: {:.6g} m^2 in {} panels{}, {:.4g} kg, {:.6g} m^2 of rectangles round them; {:.5g} m of seams\n", area,
      g.panels.size(), added > 0.0 ? fmt::format(" and {:.4g} m^2 of seam allowances", added) : "", mass, boxes, sewn);
  return text;
}

}  // namespace voile::pattern
