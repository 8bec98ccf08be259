// Plane curves that outlines are made of: Bezier curves up to the third degree, arcs of circles and ellipses, and chains
// of these.
//
// Symbols   x(t), 0 <= t <= 1   point of the curve [m]      s   arc length from its start [m]
//   Bezier  x(t) = sum_i B_i(t) p_i with 2 (a line), 3 or 4 control points
//   arc     x(t) = c + A (cos(b + t w), sin(b + t w)),  A the two half axes, w the angle that it sweeps, > 0 from the
//           first axis towards the second
// Lengths are those of the integral of |x'| (Gauss-Kronrod, relative 1e-12 where the curve has no cusp), areas follow
// from Green's theorem, A = 1/2 of the integral of x cross dx, in closed form.
#pragma once

#include <utility>
#include <vector>

#include "base/types.hpp"

namespace voile::pattern {

/// The component out of the plane.
[[nodiscard]] inline double cross(const Vec2& a, const Vec2& b) {
  return a[0] * b[1] - a[1] * b[0];
}

class Curve {
 public:
  /// Through 2 to 4 control points. Not collective, as all of this layer. Throws InternalError for other numbers.
  static Curve bezier(std::vector<Vec2> control);
  static Curve arc(const Vec2& centre, const Mat2& axes, double begin, double sweep);
  /// Circle through two different points; counter-clockwise it bulges to the right of the way from a to b. `large`: by
  /// more than half a turn. The radius must be at least half of their distance.
  static Curve circle(const Vec2& a, const Vec2& b, double radius, bool large, bool counter_clockwise);

  /// One curve after another, each of which begins where the one before ends; t runs through each in an equal part. They
  /// must not be chains.
  static Curve chain(std::vector<Curve> parts);

  [[nodiscard]] Vec2 at(double t) const;
  [[nodiscard]] Vec2 derivative(double t) const;
  [[nodiscard]] Vec2 start() const { return at(0.0); }
  [[nodiscard]] Vec2 end() const { return at(1.0); }
  [[nodiscard]] bool is_line() const { return control_.size() == 2; }
  [[nodiscard]] double length() const { return length_; }
  /// The parameters of points at these fractions of the length, which must ascend from 0 to 1.
  [[nodiscard]] std::vector<double> parameters_at(const std::vector<double>& fractions) const;
  /// Share in the area of a closed outline, positive if that goes round counter-clockwise. [m^2]
  [[nodiscard]] double area() const;
  /// The curve of the points m x + shift.
  [[nodiscard]] Curve mapped(const Mat2& m, const Vec2& shift) const;
  /// The same, drawn from its end to its start.
  [[nodiscard]] Curve reversed() const;
  [[nodiscard]] bool is_arc() const { return control_.empty() && parts_.empty(); }
  /// The parameter of the point that is nearest to x (of 64 steps refined), and the distance.
  [[nodiscard]] std::pair<double, double> nearest(const Vec2& x) const;
  /// The parts before and after t, 0 < t < 1.
  [[nodiscard]] std::pair<Curve, Curve> split(double t) const;
  /// Equal steps of t that show its shape: 1 for a line.
  [[nodiscard]] int steps() const;

 private:
  Curve() = default;
  [[nodiscard]] double length_between(double t0, double t1) const;

  /// The part of a chain in which t lies, and where in it.
  [[nodiscard]] std::pair<std::size_t, double> part_at(double t) const;

  std::vector<Vec2> control_;  ///< empty: an arc, or a chain
  std::vector<Curve> parts_;   ///< of a chain
  Vec2 centre_ = Vec2::Zero();
  Mat2 axes_ = Mat2::Zero();
  double begin_ = 0.0, sweep_ = 0.0;
  double length_ = 0.0;
};

}  // namespace voile::pattern
