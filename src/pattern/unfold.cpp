// Halves of pieces, drawn up to a fold line.
#include <fmt/format.h>

#include <algorithm>

#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

std::string twin(const std::string& name) {
  return name.empty() ? name : name + "'";
}

/// The straight line across which a half unfolds.
class FoldLine {
 public:
  explicit FoldLine(const Curve& edge) : from_(edge.start()), length_(edge.length()) {
    const Vec2 along = (edge.end() - from_).normalized();
    across_ = Vec2(-along[1], along[0]);
  }
  [[nodiscard]] bool holds(const Curve& c) const {
    for (int i = 0, steps = c.steps(); i <= steps; ++i)
      if (std::abs(across_.dot(c.at(static_cast<double>(i) / steps) - from_)) > 1e-4 * length_) return false;
    return true;
  }
  /// Drawn the other way round.
  [[nodiscard]] Edge mirrored(const Edge& e) const {
    const Mat2 m = Mat2::Identity() - 2.0 * across_ * across_.transpose();
    return {e.curve.mapped(m, from_ - m * from_).reversed(), twin(e.label)};
  }

 private:
  Vec2 from_, across_;
  double length_;
};

/// Makes the whole from the half, loop by loop.
class Unfolder {
 public:
  Unfolder(const Piece& half, const FoldLine& line) : half_(half), line_(line), numbers_(half.edges.size(), no_edge) {}

  /// A loop without its edge on the fold line, and the mirror image of the rest.
  void join(std::size_t fold) {
    begin();
    for (std::size_t k = half_.next(fold); k != fold; k = half_.next(k)) keep(k);
    std::vector<std::size_t> back;
    for (std::size_t k = half_.next(fold); k != fold; k = half_.next(k)) back.push_back(k);
    for (; !back.empty(); back.pop_back()) mirror(back.back(), fold);
    end();
  }

  /// A loop clear of the fold line, and its mirror image.
  void repeat(const Piece::Loop& loop) {
    begin();
    for (std::size_t k = loop.begin; k < loop.end; ++k) keep(k);
    end();
    begin();
    for (std::size_t k = loop.end; k > loop.begin; --k) mirror(k - 1, no_edge);
    end();
  }

  std::vector<std::size_t> take(Piece& piece) {
    piece.edges.clear();
    piece.further_loops.clear();
    for (std::vector<Edge>& loop : loops_) piece.add_loop(std::move(loop));
    piece.point_names = std::move(names_);
    return std::move(numbers_);
  }

 private:
  void begin() { loops_.emplace_back(); }
  void end() { count_ += loops_.back().size(); }
  void keep(std::size_t k) {
    numbers_[k] = count_ + loops_.back().size();
    loops_.back().push_back(half_.edges[k]);
    if (!half_.point_names.empty()) names_.push_back(half_.point_names[k]);
  }
  /// `fold`: the point where it begins lies on the fold line and is its own image.
  void mirror(std::size_t k, std::size_t fold) {
    loops_.back().push_back(line_.mirrored(half_.edges[k]));
    const std::size_t start = half_.next(k);  // the end of the edge is where its twin starts
    if (!half_.point_names.empty())
      names_.push_back(start == fold ? half_.point_names[start] : twin(half_.point_names[start]));
  }

  const Piece& half_;
  const FoldLine& line_;
  std::vector<std::size_t> numbers_;
  std::vector<std::vector<Edge>> loops_;
  std::vector<std::string> names_;
  std::size_t count_ = 0;  ///< of edges in finished loops
};

}  // namespace

std::vector<std::size_t> unfold(const std::string& where, Piece& piece, std::size_t fold) {
  const FoldLine line(piece.edges[fold].curve);
  if (!line.holds(piece.edges[fold].curve))
    throw UserError(fmt::format("{}: edge {} is bent, and a piece unfolds across a straight one; correct the fold line",
                                where, fold));
  if (!piece.is_in_outline(fold))
    throw UserError(fmt::format(
        "{}: edge {} belongs to a hole, and a piece unfolds across an edge of its outline; name that", where, fold));
  const Piece half = piece;
  Unfolder whole(half, line);
  whole.join(fold);
  for (const Piece::Loop& loop : half.loops()) {
    if (fold >= loop.begin && fold < loop.end) continue;
    std::size_t on_line = loop.begin;
    while (on_line < loop.end && !line.holds(half.edges[on_line].curve)) ++on_line;
    if (on_line < loop.end)
      whole.join(on_line);
    else
      whole.repeat(loop);
  }
  return whole.take(piece);
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
    const std::vector<std::size_t> numbers = unfold(where, piece, fold);
    std::erase_if(pattern.stitches, [&](const Stitch& s) {
      const auto on_fold = std::find_if(s.sides.begin(), s.sides.end(), [&](const StitchEnd& e) {
        return e.piece == piece.name && numbers[e.edge] == no_edge;
      });
      if (on_fold != s.sides.end())
        pattern.notes.push_back(
            fmt::format("{}: stitch {} is on its fold line, edge {}: it is no seam", where, s.number, on_fold->edge));
      return on_fold != s.sides.end();
    });
    for (Stitch& s : pattern.stitches)
      for (StitchEnd& e : s.sides)
        if (e.piece == piece.name) e.edge = numbers[e.edge];
  }
}

}  // namespace voile::pattern
