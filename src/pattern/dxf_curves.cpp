// What the entities of a DXF draw, and how that joins to outlines.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "dxf_entities.hpp"
#include "dxf_slits.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Steps back of a polyline that are shorter than this fraction of its extent are no shape, but the hand that digitised it.
constexpr double hook = 2e-4;
/// Curves of one layer beyond which they are no outlines.
constexpr std::size_t most_curves = 20000;

/// Of a point at a bulge, the tangent of a quarter of the angle that the arc to the next one sweeps, > 0 to the left.
struct Corner {
  Vec2 place;
  double bulge;
};

Curve bulged(const Vec2& a, const Vec2& b, double bulge) {
  if (bulge == 0.0) return Curve::bezier({a, b});
  const Vec2 e = b - a;
  const Vec2 centre = 0.5 * (a + b) + (1.0 - bulge * bulge) / (4.0 * bulge) * Vec2(-e[1], e[0]);
  const Vec2 from = a - centre;
  return Curve::arc(centre, from.norm() * Mat2::Identity(), std::atan2(from[1], from[0]), 4.0 * std::atan(bulge));
}

/// The corners of a polyline without those that have no length between them, and without slits and hooks.
class CleanCorners {
 public:
  CleanCorners(const std::vector<Corner>& corners, bool closed) {
    double longest = 0.0;
    for (std::size_t k = 0; k + (closed ? 0 : 1) < corners.size(); ++k)
      longest = std::max(longest, (corners[(k + 1) % corners.size()].place - corners[k].place).norm());
    near_ = same_place * longest;
    for (const Corner& c : corners) add(c);
    while (closed && close()) continue;
    remove_hooks(closed);
  }

  [[nodiscard]] std::vector<Corner> corners() const {
    std::vector<Corner> all;
    for (const Kept& k : kept_) all.push_back(k.corner);
    return all;
  }
  /// Where slits begin.
  [[nodiscard]] std::vector<Vec2> slits() const {
    std::vector<Vec2> all;
    for (const Kept& k : kept_)
      if (k.slit) all.push_back(k.corner.place);
    return all;
  }

 private:
  struct Kept {
    Corner corner;
    bool slit = false;
  };

  [[nodiscard]] bool same(const Kept& a, const Vec2& b) const { return (a.corner.place - b).norm() <= near_; }

  void add(const Corner& c) {
    const std::size_t n = kept_.size();
    if (n > 0 && same(kept_[n - 1], c.place)) {
      kept_[n - 1].corner.bulge = c.bulge;  // that of the way on
    } else if (n > 1 && kept_[n - 1].corner.bulge == 0.0 && kept_[n - 2].corner.bulge == 0.0 &&
               same(kept_[n - 2], c.place)) {
      kept_.pop_back();  // the tip of a slit
      kept_.back().corner.bulge = c.bulge;
      kept_.back().slit = true;
    } else {
      kept_.push_back({c});
    }
  }

  /// Whether something was to be mended where the end meets the beginning.
  bool close() {
    const std::size_t n = kept_.size();
    if (n < 3) return false;
    if (same(kept_[n - 1], kept_[0].corner.place)) {
      kept_[0].slit = kept_[0].slit || kept_[n - 1].slit;
      kept_.pop_back();
      return true;
    }
    const bool straight = kept_[n - 1].corner.bulge == 0.0;
    if (straight && kept_[n - 2].corner.bulge == 0.0 && same(kept_[n - 2], kept_[0].corner.place)) {
      kept_.pop_back();  // the last corner is a tip
      kept_[0].slit = true;
      return true;
    }
    if (straight && kept_[0].corner.bulge == 0.0 && same(kept_[n - 1], kept_[1].corner.place)) {
      kept_.erase(kept_.begin());  // the first one
      kept_[0].slit = true;
      return true;
    }
    return false;
  }

  /// Corners that a short straight step leads back to, or from which the way leads back after one.
  void remove_hooks(bool closed) {
    if (kept_.empty()) return;
    Vec2 low = kept_.front().corner.place, high = low;
    for (const Kept& k : kept_) low = low.cwiseMin(k.corner.place), high = high.cwiseMax(k.corner.place);
    const double longest = hook * (high - low).norm();
    for (std::size_t k = 0; k < kept_.size() && kept_.size() > 3;) {
      const std::size_t n = kept_.size(), before = (k + n - 1) % n, after = (k + 1) % n, last = (k + 2) % n;
      const bool is_inside = closed || (k > 0 && k + 2 < n);
      const Vec2 step = place(after) - place(k);
      const bool straight = kept_[before].corner.bulge == 0.0 && kept_[k].corner.bulge == 0.0 &&
                            kept_[after].corner.bulge == 0.0 && !kept_[k].slit && !kept_[after].slit;
      const bool back = step.dot(place(k) - place(before)) < 0.0 || step.dot(place(last) - place(after)) < 0.0;
      if (is_inside && straight && back && step.norm() <= longest)
        kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(after));
      else
        ++k;
    }
  }
  [[nodiscard]] const Vec2& place(std::size_t k) const { return kept_[k].corner.place; }

  std::vector<Kept> kept_;
  double near_ = 0.0;
};

std::vector<Curve> polyline(const std::vector<Corner>& given, bool closed, std::vector<Vec2>* slits) {
  const CleanCorners clean(given, closed);
  const std::vector<Corner> corners = clean.corners();
  if (slits)
    for (const Vec2& x : clean.slits()) slits->push_back(x);
  std::vector<Curve> curves;
  for (std::size_t k = 0; k + (closed ? 0 : 1) < corners.size(); ++k) {
    const Corner &a = corners[k], &b = corners[(k + 1) % corners.size()];
    if (a.place != b.place) curves.push_back(bulged(a.place, b.place, a.bulge));
  }
  return curves;
}

std::vector<Curve> light_polyline(const DxfEntity& e, std::vector<Vec2>* slits) {
  std::vector<Corner> corners;
  const std::vector<double> x = e.reals(10), y = e.reals(20);
  if (x.size() != y.size())
    e.fail(fmt::format("it has {} x and {} y coordinates; export it again", x.size(), y.size()));
  for (std::size_t k = 0; k < x.size(); ++k) corners.push_back({{x[k], y[k]}, 0.0});
  std::size_t k = 0;
  for (const DxfGroup& g : e.groups) {
    if (g.code == 10) ++k;
    if (g.code == 42 && k > 0) corners[k - 1].bulge = DxfEntity{e.type, e.layer, e.where, {g}}.real(42, 0.0);
  }
  return polyline(corners, (e.whole(70, 0) & 1) != 0, slits);
}

std::vector<Curve> old_polyline(const DxfEntity& e, std::vector<Vec2>* slits) {
  constexpr int closed = 1, meshes = 16 | 64, control_point = 16;
  const int flags = e.whole(70, 0);
  if (flags & meshes) return {};
  std::vector<Corner> corners;
  for (const DxfEntity& v : e.vertices)
    if (!(v.whole(70, 0) & control_point)) corners.push_back({v.point(10, 20), v.real(42, 0.0)});
  return polyline(corners, (flags & closed) != 0, slits);
}

/// Control points of the part of a B-spline between knots i and i + 1, by its polar form.
Curve span(const std::vector<Vec2>& points, const std::vector<double>& knots, std::size_t degree, std::size_t i) {
  std::vector<Vec2> control;
  for (std::size_t ends = 0; ends <= degree; ++ends) {
    std::vector<Vec2> d;
    for (std::size_t j = 0; j <= degree; ++j) d.push_back(points[i - degree + j]);
    for (std::size_t r = 1; r <= degree; ++r)
      for (std::size_t j = degree; j >= r; --j) {
        const double u = knots[r <= degree - ends ? i : i + 1];
        const double low = knots[i - degree + j], high = knots[i + 1 + j - r], f = (u - low) / (high - low);
        d[j] = (1.0 - f) * d[j - 1] + f * d[j];
      }
    control.push_back(d[degree]);
  }
  return Curve::bezier(std::move(control));
}

std::vector<Curve> spline(const DxfEntity& e) {
  const int degree = e.whole(71, 3);
  const std::vector<double> x = e.reals(10), y = e.reals(20), knots = e.reals(40), weights = e.reals(41);
  if (degree < 1 || degree > 3)
    e.fail(fmt::format("its degree is {}; export it with the third degree at most", degree));
  const auto p = static_cast<std::size_t>(degree);
  if (x.size() != y.size() || x.size() < p + 1 || knots.size() != x.size() + p + 1 ||
      !std::is_sorted(knots.begin(), knots.end()))
    e.fail(
        fmt::format("{} control points and {} knots are no spline of degree {}; export it with its control points, or "
                    "as a polyline",
                    x.size(), knots.size(), degree));
  for (const double w : weights)
    if (std::abs(w - weights.front()) > 1e-9 * std::abs(w))
      e.fail("its weights differ; export it as arcs, a spline without weights or a polyline");
  std::vector<Vec2> points;
  for (std::size_t k = 0; k < x.size(); ++k) points.emplace_back(x[k], y[k]);
  std::vector<Curve> spans;
  for (std::size_t i = p; i < points.size(); ++i)
    if (knots[i + 1] > knots[i])
      if (Curve c = span(points, knots, p, i); c.length() > 0.0) spans.push_back(std::move(c));
  if (spans.empty()) return {};
  if (spans.size() > 1 && spans.front().start() == spans.back().end()) return spans;  // an outline has two edges
  return {Curve::chain(std::move(spans))};
}

std::vector<Curve> ellipse(const DxfEntity& e, const Vec2& centre, const Mat2& axes, double begin, double end) {
  constexpr double whole = 2.0 * std::numbers::pi;
  double sweep = std::fmod(end - begin, whole);
  if (sweep <= 1e-12) sweep += whole;
  if (!(std::abs(axes.determinant()) > 0.0)) e.fail("its radius must not be zero");
  if (sweep < whole - 1e-9) return {Curve::arc(centre, axes, begin, sweep)};
  return {Curve::arc(centre, axes, begin, 0.5 * whole), Curve::arc(centre, axes, begin + 0.5 * whole, 0.5 * whole)};
}

std::vector<Curve> arc(const DxfEntity& e) {
  constexpr double degree = std::numbers::pi / 180.0;
  const bool circle = e.type == "CIRCLE";
  const Mat2 axes = e.real(40, 0.0) * Mat2::Identity();
  return ellipse(e, e.point(10, 20), axes, circle ? 0.0 : degree * e.real(50, 0.0),
                 circle ? 0.0 : degree * e.real(51, 0.0));
}

Mat2 axes_of_ellipse(const DxfEntity& e) {
  const Vec2 major = e.point(11, 21);
  Mat2 axes;
  axes << major[0], -major[1] * e.real(40, 1.0), major[1], major[0] * e.real(40, 1.0);
  if (e.real(230, 1.0) < 0.0) axes.col(1) *= -1.0;
  return axes;
}

/// Joins one outline after another.
class Joiner {
 public:
  Joiner(const std::string& where, std::vector<Curve> curves, const std::vector<Curve>& bridge)
      : where_(where), curves_(std::move(curves)), bridge_(bridge), used_(curves_.size()) {
    if (curves_.size() > most_curves)
      throw UserError(
          fmt::format("{}: {} curves are more than outlines have; simplify the drawing", where, curves_.size()));
    for (const Curve& c : curves_) size_ = std::max({size_, (c.start() - c.end()).norm(), c.length()});
    // What is shorter than ends may be apart would make three curves meet.
    std::erase_if(curves_, [&](const Curve& c) { return c.length() <= same_place * size_; });
    used_.resize(curves_.size());
  }

  std::vector<std::vector<Curve>> run() {
    std::vector<std::vector<Curve>> outlines;
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      if (used_[k]) continue;
      used_[k] = true;
      outlines.push_back({curves_[k]});
      while (!meets(outlines.back().back().end(), outlines.back().front().start())) {
        if (extend(outlines.back())) continue;
        close(outlines.back());
        break;
      }
    }
    return outlines;
  }

 private:
  [[nodiscard]] bool meets(const Vec2& a, const Vec2& b) const { return (a - b).norm() <= same_place * size_; }

  bool extend(std::vector<Curve>& outline) {
    const Vec2 end = outline.back().end();
    std::size_t next = curves_.size();
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      if (used_[k] || (!meets(curves_[k].start(), end) && !meets(curves_[k].end(), end))) continue;
      if (next < curves_.size())
        throw UserError(
            fmt::format("{}: three curves or more meet near ({:.6g}, {:.6g}) in the file's units, and an "
                        "outline does not branch; put other lines on another layer, or remove doubles",
                        where_, end[0], end[1]));
      next = k;
    }
    if (next == curves_.size()) return false;
    used_[next] = true;
    outline.push_back(meets(curves_[next].start(), end) ? curves_[next] : curves_[next].reversed());
    return true;
  }

  void close(std::vector<Curve>& outline) const {
    const Vec2 from = outline.back().end(), to = outline.front().start();
    const auto is_on = [&](const Curve& line, const Vec2& x) {
      const Vec2 along = (line.end() - line.start()).normalized(), d = x - line.start();
      return std::abs(along[0] * d[1] - along[1] * d[0]) <= same_place * size_;
    };
    for (const Curve& b : bridge_)
      if (is_on(b, from) && is_on(b, to)) return outline.push_back(Curve::bezier({from, to}));
    throw UserError(
        fmt::format("{}: the outline is open: it ends at ({:.6g}, {:.6g}) in the file's units, {:.4g} away from its "
                    "beginning, where no curve begins; close it",
                    where_, from[0], from[1], (from - to).norm()));
  }

  const std::string& where_;
  std::vector<Curve> curves_;
  const std::vector<Curve>& bridge_;
  std::vector<bool> used_;
  double size_ = 0.0;
};

}  // namespace

std::vector<Curve> curves_of(const DxfEntity& e, std::vector<Vec2>* slits) {
  const bool in_own_plane = e.type == "LWPOLYLINE" || e.type == "POLYLINE" || e.type == "ARC" || e.type == "CIRCLE";
  std::vector<Curve> curves;
  if (e.type == "LINE") {
    const Vec2 a = e.point(10, 20), b = e.point(11, 21);
    if (a != b) curves.push_back(Curve::bezier({a, b}));
  } else if (e.type == "LWPOLYLINE") {
    curves = light_polyline(e, slits);
  } else if (e.type == "POLYLINE") {
    curves = old_polyline(e, slits);
  } else if (e.type == "SPLINE") {
    curves = spline(e);
  } else if (e.type == "ELLIPSE") {
    curves = ellipse(e, e.point(10, 20), axes_of_ellipse(e), e.real(41, 0.0), e.real(42, 0.0));
  } else if (in_own_plane) {
    curves = arc(e);
  }
  if (curves.empty()) return curves;
  if (std::abs(e.real(210, 0.0)) > 1e-9 || std::abs(e.real(220, 0.0)) > 1e-9)
    e.fail("it does not lie in the plane of the drawing; lay it flat");
  if (in_own_plane && e.real(230, 1.0) < 0.0)  // drawn from below: x points the other way
    for (Curve& c : curves) c = c.mapped(Vec2(-1.0, 1.0).asDiagonal(), Vec2::Zero());
  return curves;
}

std::vector<std::vector<Curve>> join_curves(const std::string& where, std::vector<Curve> curves,
                                            const std::vector<Curve>& bridge) {
  return Joiner(where, std::move(curves), bridge).run();
}

}  // namespace voile::pattern
