// The commands of an SVG path, and its arcs (W3C, Scalable Vector Graphics 1.1, 8.3 and F.6).
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

Curve svg_arc(const Vec2& a, const Vec2& b, Vec2 radii, double turn, bool large, bool sweep) {
  if (radii[0] == 0.0 || radii[1] == 0.0) return Curve::bezier({a, b});
  radii = radii.cwiseAbs();
  const Mat2 r = Eigen::Rotation2Dd(turn).toRotationMatrix();
  // In units of the half axes the ellipse is a circle of radius 1.
  const Mat2 axes = r * radii.asDiagonal();
  const Mat2 back = radii.cwiseInverse().asDiagonal() * r.transpose();
  const Vec2 p = back * a, q = back * b;
  const double grow = std::max(1.0, 0.5 * (q - p).norm());  // radii that do not reach are made larger
  return Curve::circle(p, q, grow, large, sweep).mapped(axes, Vec2::Zero());
}

namespace {

class PathReader {
 public:
  PathReader(const std::string& where, const std::string& text) : where_(where), text_(text) {}

  std::vector<std::vector<Curve>> run() {
    while (skip(), at_ < text_.size()) {
      const char c = text_[at_];
      if (std::isalpha(static_cast<unsigned char>(c))) {
        command_ = c;
        ++at_;
      } else if (command_ == 0 || command_ == 'Z' || command_ == 'z') {
        fail(fmt::format("'{}' at character {} is no command", c, at_));
      }
      step();
    }
    if (!curves_.empty()) close(true);
    if (loops_.empty()) fail("the path draws nothing; give it an outline");
    return std::move(loops_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw UserError(fmt::format("{}: {}", where_, message)); }

  void skip() {
    while (at_ < text_.size() && (std::isspace(static_cast<unsigned char>(text_[at_])) || text_[at_] == ',')) ++at_;
  }
  double number() {
    skip();
    const char* begin = text_.c_str() + at_;
    char* end = nullptr;
    const bool starts =
        *begin == '-' || *begin == '+' || *begin == '.' || std::isdigit(static_cast<unsigned char>(*begin));
    const double x = starts ? std::strtod(begin, &end) : NAN;
    if (!starts || end == begin || !std::isfinite(x))
      fail(fmt::format("a number is expected at character {} of the path, after command {}", at_, command_));
    at_ += static_cast<std::size_t>(end - begin);
    return x;
  }
  /// The flags of an arc may stand without a space between them.
  bool flag() {
    skip();
    if (at_ >= text_.size() || (text_[at_] != '0' && text_[at_] != '1'))
      fail(fmt::format("0 or 1 is expected at character {} of the path, as a flag of an arc", at_));
    return text_[at_++] == '1';
  }
  [[nodiscard]] bool relative() const { return std::islower(static_cast<unsigned char>(command_)) != 0; }
  Vec2 point() {
    const double x = number(), y = number();
    return relative() ? Vec2(here_ + Vec2(x, y)) : Vec2(x, y);
  }

  void draw(Curve curve, const Vec2& to) {
    if (closed_)
      fail(
          "something is drawn after a loop is closed (command Z); begin each hole by a command M, and put each piece "
          "into "
          "a path of its own");
    if (curve.length() > 0.0) curves_.push_back(std::move(curve));
    here_ = to;
  }
  void line(const Vec2& to) { draw(Curve::bezier({here_, to}), to); }

  void begin(const Vec2& at) {
    if (!curves_.empty()) close(true);
    closed_ = false;
    start_ = here_ = at;
  }

  /// `by_end`: the path just stops.
  void close(bool by_end) {
    double size = 0.0;
    for (const Curve& c : curves_) size += c.length();
    const double gap = (here_ - start_).norm();
    if (by_end && gap > 1e-6 * size)
      fail(
          fmt::format("the outline is open: its end is {:.4g} units away from its beginning, after edge {}; close the "
                      "path (command Z)",
                      gap, edges_before_ + curves_.size() - 1));
    if (gap > 1e-6 * size) line(start_);
    edges_before_ += curves_.size();
    if (!curves_.empty()) loops_.push_back(std::move(curves_));
    curves_.clear();
    closed_ = true;
    here_ = start_;
  }

  void cubic(const Vec2& p, const Vec2& q, const Vec2& to) {
    draw(Curve::bezier({here_, p, q, to}), to);
    mirror_ = 2.0 * to - q;
  }
  void quadratic(const Vec2& p, const Vec2& to) {
    draw(Curve::bezier({here_, p, to}), to);
    mirror_ = 2.0 * to - p;
  }

  void step() {
    const char kind = static_cast<char>(std::toupper(static_cast<unsigned char>(command_)));
    const Vec2 smooth =
        previous_ == kind || (kind == 'S' && previous_ == 'C') || (kind == 'T' && previous_ == 'Q') ? mirror_ : here_;
    const double none = relative() ? 1.0 : 0.0;
    switch (kind) {
      case 'M':
        begin(point());
        command_ = relative() ? 'l' : 'L';  // further pairs are lines
        break;
      case 'L':
        line(point());
        break;
      case 'H':
        line({none * here_[0] + number(), here_[1]});
        break;
      case 'V':
        line({here_[0], none * here_[1] + number()});
        break;
      case 'C': {
        const Vec2 p = point(), q = point();
        cubic(p, q, point());
        break;
      }
      case 'S': {
        const Vec2 q = point();
        cubic(smooth, q, point());
        break;
      }
      case 'Q': {
        const Vec2 p = point();
        quadratic(p, point());
        break;
      }
      case 'T':
        quadratic(smooth, point());
        break;
      case 'A': {
        const double rx = number(), ry = number(), turn = number() * std::numbers::pi / 180.0;
        const bool large = flag(), sweep = flag();
        const Vec2 to = point();
        if (to != here_) draw(svg_arc(here_, to, {rx, ry}, turn, large, sweep), to);
        break;
      }
      case 'Z':
        close(false);
        break;
      default:
        fail(fmt::format("unknown command '{}'; export the path with lines, Bezier curves and arcs", command_));
    }
    previous_ = kind;
  }

  const std::string& where_;
  const std::string& text_;
  std::size_t at_ = 0;
  char command_ = 0, previous_ = 0;
  Vec2 start_ = Vec2::Zero(), here_ = Vec2::Zero(), mirror_ = Vec2::Zero();
  bool closed_ = false;
  std::vector<Curve> curves_;  ///< of the loop that is being drawn
  std::vector<std::vector<Curve>> loops_;
  std::size_t edges_before_ = 0;  ///< in loops_
};

}  // namespace

std::vector<std::vector<Curve>> read_svg_path(const std::string& where, const std::string& commands) {
  return PathReader(where, commands).run();
}

}  // namespace voile::pattern
