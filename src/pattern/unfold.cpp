// Halves of pieces, drawn up to a fold line.
#include <fmt/format.h>

#include <algorithm>

#include "readers.hpp"
#include "voile/base/error.hpp"

namespace voile::pattern {

void unfold(const std::string& where, Piece& piece, std::size_t fold) {
  const std::size_t n = piece.edges.size();
  const Curve& line = piece.edges[fold].curve;
  const Vec2 from = line.start(), along = (line.end() - from).normalized(), across(-along[1], along[0]);
  for (int i = 0, steps = line.steps(); i < steps; ++i)
    if (std::abs(across.dot(line.at(static_cast<double>(i) / steps) - from)) > 1e-4 * line.length())
      throw UserError(fmt::format(
          "{}: edge {} is bent, and a piece unfolds across a straight one; correct the fold line", where, fold));
  const Mat2 mirror = Mat2::Identity() - 2.0 * across * across.transpose();
  const Vec2 shift = from - mirror * from;
  const std::vector<Edge> half = std::move(piece.edges);
  const std::vector<std::string> names = std::move(piece.point_names);
  piece.edges.clear();
  piece.point_names.clear();
  const auto twin = [](const std::string& name) { return name.empty() ? name : name + "'"; };
  for (std::size_t k = 1; k < n; ++k) {
    piece.edges.push_back(half[(fold + k) % n]);
    if (!names.empty()) piece.point_names.push_back(names[(fold + k) % n]);
  }
  for (std::size_t k = n - 1; k > 0; --k) {
    const Edge& e = half[(fold + k) % n];
    piece.edges.push_back({e.curve.mapped(mirror, shift).reversed(), twin(e.label)});
    const std::size_t start = (fold + k + 1) % n;  // the end of the edge is where its twin starts
    if (!names.empty()) piece.point_names.push_back(start == fold ? names[start] : twin(names[start]));
  }
}

void unfold_pieces(Pattern& pattern, const std::string& edge) {
  for (Piece& piece : pattern.pieces) {
    const std::string where = fmt::format("{}: piece '{}'", pattern.file.string(), piece.name);
    const std::size_t n = piece.edges.size();
    std::size_t fold = n;
    if (const auto k = number_below(edge, n)) fold = *k;
    for (std::size_t k = 0; fold == n && k < n; ++k)
      if (piece.edges[k].label == edge) fold = k;
    if (fold == n)
      throw UserError(
          fmt::format("{}: unfold = \"{}\": it has no such edge; it has {}, counted from 0", where, edge, n));
    unfold(where, piece, fold);
    std::erase_if(pattern.stitches, [&](const Stitch& s) {
      const bool on_fold = std::any_of(s.sides.begin(), s.sides.end(),
                                       [&](const StitchEnd& e) { return e.piece == piece.name && e.edge == fold; });
      if (on_fold)
        pattern.notes.push_back(
            fmt::format("{}: stitch {} is on its fold line, edge {}: it is no seam", where, s.number, fold));
      return on_fold;
    });
    for (Stitch& s : pattern.stitches)
      for (StitchEnd& e : s.sides)
        if (e.piece == piece.name) e.edge = (e.edge + n - fold - 1) % n;
  }
}

}  // namespace voile::pattern
