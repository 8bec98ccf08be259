#include "layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/unions.hpp"
#include "mesh/weld.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

using mesh::ascending;
using mesh::Segment;

class Layers {
 public:
  Layers(const mesh::MeshData& mesh, const std::vector<SewnPair>& pairs, const std::vector<std::string>& seams)
      : mesh_(mesh),
        target_(mesh::joined_vertices(mesh)),
        pairs_(pairs),
        seams_(seams),
        lines_(3 * mesh.triangles.size()) {
    for (const SewnPair& pair : pairs)
      for (const Segment& s : pair.segments) at_.try_emplace(s, mesh::TriangleSide{});
    for (Index t = 0; t < static_cast<Index>(mesh.triangles.size()); ++t)
      for (int s = 0; s < 3; ++s)
        if (const auto found = at_.find(segment(t, s)); found != at_.end()) found->second = {t, s};
  }

  /// Sides that lie on the second side of an edge of three and more.
  [[nodiscard]] std::vector<mesh::TriangleSide> run() {
    for (const SewnPair& pair : pairs_)
      if (!lines_.join(number(pair.segments[0]), number(pair.segments[1]))) refuse_circle(pair);
    check_welded();
    std::map<Segment, std::vector<Segment>> next;
    for (const SewnPair& pair : pairs_) {
      next[pair.segments[0]].push_back(pair.segments[1]);
      next[pair.segments[1]].push_back(pair.segments[0]);
    }
    std::map<Segment, int> sides;
    std::vector<mesh::TriangleSide> folded;
    for (const auto& entry : next) {
      if (sides.contains(entry.first)) continue;
      std::vector<Segment> line{entry.first};
      sides[entry.first] = 0;
      for (std::size_t k = 0; k < line.size(); ++k)
        for (const Segment& s : next.at(line[k]))
          if (sides.try_emplace(s, 1 - sides.at(line[k])).second) line.push_back(s);
      for (const Segment& s : line)
        if (line.size() > 2 && sides.at(s) == 1) folded.push_back(at_.at(s));
    }
    std::sort(folded.begin(), folded.end());
    return folded;
  }

 private:
  [[nodiscard]] Segment segment(Index t, int s) const {
    const mesh::Triangle& v = mesh_.triangles[static_cast<std::size_t>(t)];
    return ascending(v[static_cast<std::size_t>((s + 1) % 3)], v[static_cast<std::size_t>((s + 2) % 3)]);
  }
  [[nodiscard]] Index number(const Segment& s) const { return 3 * at_.at(s).triangle + at_.at(s).side; }
  [[nodiscard]] Index target(Index v) const { return target_.empty() ? v : target_[static_cast<std::size_t>(v)]; }

  [[nodiscard]] std::string piece_of(Index t) const {
    for (const mesh::Group& group : mesh_.groups)
      if (std::binary_search(group.triangles.begin(), group.triangles.end(), t)) return group.name;
    return "";
  }

  [[noreturn]] void refuse_circle(const SewnPair& pair) const {
    const mesh::TriangleSide a = at_.at(pair.segments[0]), b = at_.at(pair.segments[1]);
    const Vec2 &x = mesh_.texture[a.triangle][(a.side + 1) % 3], &y = mesh_.texture[a.triangle][(a.side + 2) % 3];
    throw UserError(fmt::format(
        "{}: pieces '{}' and '{}' would be sewn together twice along one line, near ({:.4g}, {:.4g}) m of the "
        "first: directly, or through the pieces that seams join there; remove this seam or another of them",
        seams_.at(pair.seam), piece_of(a.triangle), piece_of(b.triangle), 0.5 * (x[0] + y[0]), 0.5 * (x[1] + y[1])));
  }

  void check_welded() {
    std::map<Segment, std::vector<mesh::TriangleSide>> edges;
    for (Index t = 0; t < static_cast<Index>(mesh_.triangles.size()); ++t) {
      const Vec2 x = (mesh_.texture[t][0] + mesh_.texture[t][1] + mesh_.texture[t][2]) / 3.0;
      for (int s = 0; s < 3; ++s) {
        const Segment own = segment(t, s);
        const Index a = target(own[0]), b = target(own[1]);
        if (a == b)
          throw UserError(
              fmt::format("{}: piece '{}': its seams would sew two corners of one cell near ({:.4g}, {:.4g}) m to "
                          "each other and fold it; make the cells smaller there, or correct which edges are sewn",
                          mesh_.source, piece_of(t), x[0], x[1]));
        edges[ascending(a, b)].push_back({t, s});
      }
    }
    for (const auto& entry : edges) check_edge(entry.second);
  }

  /// More than two sheets meet only where seams join all of them.
  void check_edge(const std::vector<mesh::TriangleSide>& sides) {
    if (sides.size() <= 2) return;
    const auto line = [&](const mesh::TriangleSide& s) { return lines_.find(3 * s.triangle + s.side); };
    if (std::all_of(sides.begin(), sides.end(), [&](const auto& s) { return line(s) == line(sides[0]); })) return;
    throw UserError(fmt::format(
        "{}: pieces '{}', '{}' and '{}' would be sewn together along one line, and no seam joins all of "
        "them there; remove one of the seams there, or make the cells smaller",
        mesh_.source, piece_of(sides[0].triangle), piece_of(sides[1].triangle), piece_of(sides[2].triangle)));
  }

  const mesh::MeshData& mesh_;
  std::vector<Index> target_;  ///< that each vertex becomes; empty: there are no seams
  const std::vector<SewnPair>& pairs_;
  const std::vector<std::string>& seams_;     ///< what they are called in messages
  std::map<Segment, mesh::TriangleSide> at_;  ///< of the segments of pairs
  Unions lines_;                              ///< of the numbers of sides
};

}  // namespace

void take_layers(mesh::MeshData& mesh, const std::vector<SewnPair>& pairs, const std::vector<std::string>& seams) {
  mesh.folded = Layers(mesh, pairs, seams).run();
}

}  // namespace voile::pattern
