#include "curve.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <numbers>

#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// De Casteljau's algorithm.
Vec2 point_of(std::vector<Vec2> p, double t) {
  for (std::size_t left = p.size(); left > 1; --left)
    for (std::size_t i = 0; i + 1 < left; ++i) p[i] = (1.0 - t) * p[i] + t * p[i + 1];
  return p.front();
}

}  // namespace

Curve Curve::bezier(std::vector<Vec2> control) {
  if (control.size() < 2 || control.size() > 4) throw InternalError("a Bezier curve has 2 to 4 control points");
  Curve c;
  c.control_ = std::move(control);
  c.length_ = c.length_between(0.0, 1.0);
  return c;
}

Curve Curve::arc(const Vec2& centre, const Mat2& axes, double begin, double sweep) {
  Curve c;
  c.centre_ = centre;
  c.axes_ = axes;
  c.begin_ = begin;
  c.sweep_ = sweep;
  c.length_ = c.length_between(0.0, 1.0);
  return c;
}

Curve Curve::circle(const Vec2& a, const Vec2& b, double radius, bool large, bool counter_clockwise) {
  const Vec2 e = b - a, left(-e[1], e[0]);
  const double half = 0.5 * e.norm(), height = std::sqrt(std::max(0.0, radius * radius - half * half));
  const Vec2 centre = 0.5 * (a + b) + (counter_clockwise != large ? height : -height) / e.norm() * left;
  const Vec2 from = a - centre, to = b - centre;
  const double begin = std::atan2(from[1], from[0]);
  double sweep = std::atan2(cross(from, to), from.dot(to));
  if (counter_clockwise && sweep < 0.0) sweep += 2.0 * std::numbers::pi;
  if (!counter_clockwise && sweep > 0.0) sweep -= 2.0 * std::numbers::pi;
  return arc(centre, from.norm() * Mat2::Identity(), begin, sweep);
}

Curve Curve::chain(std::vector<Curve> parts) {
  if (parts.empty()) throw InternalError("a chain of no curves");
  if (parts.size() == 1) return std::move(parts.front());
  Curve c;
  c.parts_ = std::move(parts);
  for (const Curve& part : c.parts_) c.length_ += part.length();
  return c;
}

int Curve::steps() const {
  constexpr int of_curve = 64;
  if (parts_.empty()) return is_line() ? 1 : of_curve;
  int most = 1;
  for (const Curve& part : parts_) most = std::max(most, part.is_line() ? 1 : of_curve / 4);
  return most * static_cast<int>(parts_.size());
}

std::pair<std::size_t, double> Curve::part_at(double t) const {
  const double s = t * static_cast<double>(parts_.size());
  const auto k = static_cast<std::size_t>(std::clamp(std::floor(s), 0.0, static_cast<double>(parts_.size() - 1)));
  return {k, s - static_cast<double>(k)};
}

Curve Curve::reversed() const {
  if (is_arc()) return arc(centre_, axes_, begin_ + sweep_, -sweep_);
  if (parts_.empty()) return bezier({control_.rbegin(), control_.rend()});
  std::vector<Curve> parts;
  for (auto part = parts_.rbegin(); part != parts_.rend(); ++part) parts.push_back(part->reversed());
  return chain(std::move(parts));
}

Vec2 Curve::at(double t) const {
  if (!parts_.empty()) {
    const auto [k, s] = part_at(t);
    return parts_[k].at(s);
  }
  if (is_arc()) return centre_ + axes_ * Vec2(std::cos(begin_ + t * sweep_), std::sin(begin_ + t * sweep_));
  if (t == 0.0) return control_.front();
  if (t == 1.0) return control_.back();
  return point_of(control_, t);
}

Vec2 Curve::derivative(double t) const {
  if (!parts_.empty()) {
    const auto [k, s] = part_at(t);
    return static_cast<double>(parts_.size()) * parts_[k].derivative(s);
  }
  if (is_arc()) return sweep_ * (axes_ * Vec2(-std::sin(begin_ + t * sweep_), std::cos(begin_ + t * sweep_)));
  std::vector<Vec2> d;
  for (std::size_t i = 0; i + 1 < control_.size(); ++i)
    d.push_back(static_cast<double>(control_.size() - 1) * (control_[i + 1] - control_[i]));
  return point_of(std::move(d), t);
}

double Curve::length_between(double t0, double t1) const {
  if (control_.size() == 2) return (t1 - t0) * (control_[1] - control_[0]).norm();
  using Rule = boost::math::quadrature::gauss_kronrod<double, 15>;
  // On an interval of its own: Boost compares the error without the interval's width with a tolerance that has it, and
  // would halve an interval below 1/500 to the last level.
  const double width = t1 - t0;
  return width * Rule::integrate([&](double s) { return derivative(t0 + s * width).norm(); }, 0.0, 1.0, 15, 1e-13);
}

std::vector<double> Curve::parameters_at(const std::vector<double>& fractions) const {
  std::vector<double> parameters;
  if (!parts_.empty()) {
    std::size_t k = 0;
    double before = 0.0;
    for (const double fraction : fractions) {
      while (k + 1 < parts_.size() && fraction * length_ > before + parts_[k].length()) before += parts_[k++].length();
      const double own = std::clamp((fraction * length_ - before) / parts_[k].length(), 0.0, 1.0);
      const double t = fraction >= 1.0 ? 1.0 : parts_[k].parameters_at({own}).front();
      parameters.push_back(fraction >= 1.0 ? 1.0 : (static_cast<double>(k) + t) / static_cast<double>(parts_.size()));
    }
    return parameters;
  }
  double t = 0.0, done = 0.0;  // where the last point lies
  for (const double fraction : fractions) {
    if (fraction >= 1.0) {
      parameters.push_back(1.0);
      continue;
    }
    // Newton's method on the length from the last point, kept between bounds that it narrows.
    const double from = t, wanted = fraction * length_ - done;
    double low = from, high = 1.0;
    t = is_line() ? fraction : std::min(1.0, from + wanted / length_);
    for (int k = 0; k < 60 && !is_line(); ++k) {
      const double error = length_between(from, t) - wanted;
      (error > 0.0 ? high : low) = t;
      if (std::abs(error) <= 1e-13 * length_) break;
      const double speed = derivative(t).norm(), next = t - error / speed;
      t = next > low && next < high ? next : 0.5 * (low + high);
    }
    done = fraction * length_;
    parameters.push_back(t);
  }
  return parameters;
}

std::pair<double, double> Curve::nearest(const Vec2& x) const {
  const auto distance = [&](double t) { return (at(t) - x).norm(); };
  const int parts = std::max(steps(), 64);
  double best = 0.0;
  for (int i = 1; i <= parts; ++i)
    if (const double t = static_cast<double>(i) / parts; distance(t) < distance(best)) best = t;
  for (double step = 0.5 / parts; step > 1e-14; step *= 0.5)
    for (const double t : {best - step, best + step})
      if (t >= 0.0 && t <= 1.0 && distance(t) < distance(best)) best = t;
  return {best, distance(best)};
}

std::pair<Curve, Curve> Curve::split(double t) const {
  if (is_arc())
    return {arc(centre_, axes_, begin_, t * sweep_), arc(centre_, axes_, begin_ + t * sweep_, (1.0 - t) * sweep_)};
  if (!parts_.empty()) {
    const auto [k, s] = part_at(t);
    const auto middle = parts_.begin() + static_cast<std::ptrdiff_t>(k);
    std::vector<Curve> before(parts_.begin(), middle), after(middle + 1, parts_.end());
    if (s > 0.0 && s < 1.0) {
      auto [first, second] = middle->split(s);
      before.push_back(std::move(first));
      after.insert(after.begin(), std::move(second));
    } else {
      (s > 0.0 ? before.insert(before.end(), *middle) : after.insert(after.begin(), *middle));
    }
    return {chain(std::move(before)), chain(std::move(after))};
  }
  std::vector<Vec2> p = control_, first, second;
  for (; !p.empty(); p.pop_back()) {
    first.push_back(p.front());
    second.insert(second.begin(), p.back());
    for (std::size_t i = 0; i + 1 < p.size(); ++i) p[i] = (1.0 - t) * p[i] + t * p[i + 1];
  }
  return {bezier(std::move(first)), bezier(std::move(second))};
}

double Curve::area() const {
  if (!parts_.empty()) {
    double sum = 0.0;
    for (const Curve& part : parts_) sum += part.area();
    return sum;
  }
  if (is_arc()) return 0.5 * cross(centre_, end() - start()) + 0.5 * axes_.determinant() * sweep_;
  // x cross x' is of the fifth degree at most: three points integrate it exactly.
  static const std::array<double, 3> place{0.5 - std::sqrt(0.15), 0.5, 0.5 + std::sqrt(0.15)};
  static const std::array<double, 3> weight{5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) sum += weight[i] * cross(at(place[i]), derivative(place[i]));
  return 0.5 * sum;
}

Curve Curve::mapped(const Mat2& m, const Vec2& shift) const {
  if (is_arc()) return arc(m * centre_ + shift, m * axes_, begin_, sweep_);
  if (!parts_.empty()) {
    std::vector<Curve> parts;
    for (const Curve& part : parts_) parts.push_back(part.mapped(m, shift));
    return chain(std::move(parts));
  }
  std::vector<Vec2> p;
  for (const Vec2& x : control_) p.emplace_back(m * x + shift);
  return bezier(std::move(p));
}

}  // namespace voile::pattern
