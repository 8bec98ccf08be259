#include "shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "voile/errors.hpp"

namespace voile::manikin {

namespace {

using std::numbers::pi;

double smooth_min(double a, double b, double k) {
  const double h = std::max(0.0, 1.0 - std::abs(a - b) / k);
  return std::min(a, b) - 0.25 * k * h * h;
}

double smooth_max(double a, double b, double k) {
  return -smooth_min(-a, -b, k);
}

/// About the distance from an ellipsoid.
double ellipsoid(const Vec3& d, const Vec3& axes) {
  const double outside = d.cwiseQuotient(axes).norm();
  const double slope = d.cwiseQuotient(axes.cwiseProduct(axes)).norm();
  return slope > 0.0 ? outside * (outside - 1.0) / slope : -axes.minCoeff();
}

/// Monotone cubic interpolation (F.N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304).
template <class Value>
double interpolate(const std::vector<double>& x, const Value& y, double at) {
  const std::size_t n = x.size();
  if (at <= x.front()) return y(0);
  if (at >= x.back()) return y(n - 1);
  const std::size_t k = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin()) - 1;
  const auto slope = [&](std::size_t i) { return (y(i + 1) - y(i)) / (x[i + 1] - x[i]); };
  const auto tangent = [&](std::size_t i) {
    if (i == 0 || i == n - 1) return 0.0;
    const double a = slope(i - 1), b = slope(i);
    return a * b > 0.0 ? 2.0 * a * b / (a + b) : 0.0;
  };
  const double h = x[k + 1] - x[k], t = (at - x[k]) / h, u = 1.0 - t;
  return y(k) * u * u * (1.0 + 2.0 * t) + y(k + 1) * t * t * (3.0 - 2.0 * t) +
         h * t * u * (u * tangent(k) - t * tangent(k + 1));
}

/// Points and radii of a limb, sampled so finely that its cones look like one curved surface.
struct Sampled {
  std::vector<Vec3> points;
  std::vector<double> radii;
};
struct Station {
  double along;  ///< of the limb
  Vec3 point;
  double radius;
};
Sampled sample(const std::vector<Station>& stations, int count) {
  std::vector<double> along;
  for (const Station& s : stations) along.push_back(s.along);
  Sampled all;
  for (int i = 0; i <= count; ++i) {
    const double at = along.front() + (along.back() - along.front()) * i / count;
    Vec3 p;
    for (int c = 0; c < 3; ++c)
      p[c] = interpolate(
          along, [&](std::size_t k) { return stations[k].point[c]; }, at);
    all.points.push_back(p);
    all.radii.push_back(interpolate(
        along, [&](std::size_t k) { return stations[k].radius; }, at));
  }
  return all;
}

/// Of the half plane on the left; smooth across the middle.
Vec3 folded(const Vec3& p) {
  constexpr double width = 0.006;
  return {std::sqrt(p.x() * p.x() + width * width), p.y(), p.z()};
}

/// From chin to top: a fifth of the height of an infant, a ninth of a grown-up's.
double child_head(double height) {
  static const std::vector<double> heights{0.74, 0.92, 1.16, 1.40, 1.76}, fractions{0.235, 0.205, 0.170, 0.144, 0.116};
  return height * interpolate(
                      heights, [](std::size_t k) { return fractions[k]; }, height);
}

}  // namespace

Levels::Levels(const Measurements& m) {
  // Heads of children are larger; everything below them moves together.
  constexpr double adult = 0.785;
  const double trunk = m.height - m.inseam;
  const double below = m.person == Person::child ? trunk - child_head(m.height) : adult * trunk;
  const auto at = [&](double fraction) { return m.inseam + fraction / adult * below; };
  crotch = m.inseam;
  hip = at(0.085);
  waist = at(0.30);
  under_bust = at(0.41);
  bust = at(0.485);
  armpit = at(0.555);
  shoulder = at(0.665);
  neck = at(0.725);
  chin = at(0.785);
  top = m.height;
}

Limb::Limb(std::vector<Vec3> points, std::vector<double> radii, double stretch)
    : points_(std::move(points)), radii_(std::move(radii)), stretch_(stretch) {
  for (Vec3& p : points_) p.y() /= stretch_;
}

double Limb::distance(const Vec3& p) const {
  const Vec3 q(p.x(), p.y() / stretch_, p.z());
  double nearest = 1e9;
  for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
    const Vec3 along = points_[i + 1] - points_[i], d = q - points_[i];
    const double t = std::clamp(d.dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (d - t * along).norm() - (1.0 - t) * radii_[i] - t * radii_[i + 1]);
  }
  return nearest;
}

Shape::Shape(const Measurements& m, Kind kind) : m_(m), kind_(kind), levels_(m) {
  check(m);
  build();
}

void Shape::build() {
  const Levels& l = levels_;
  const double width = std::pow(m_.height / 1.74, m_.person == Person::child ? 0.6 : 1.0);  // of neck and shoulders
  // Half axes of an ellipse of a girth whose depth is `flat` times its width, by Ramanujan's formula.
  const auto of_girth = [](double girth, double flat, double centre) {
    const double a = 1.0, b = flat, h = (a - b) * (a - b) / ((a + b) * (a + b));
    const double round = pi * (a + b) * (1.0 + 3.0 * h / (10.0 + std::sqrt(4.0 - 3.0 * h)));
    return std::array{girth / round, flat * girth / round, centre};
  };
  const double bust = scale_[0] * m_.bust, waist = scale_[1] * m_.waist, hip = scale_[2] * m_.hip;
  double shoulder = (m_.person == Person::man ? 0.54 : 0.5) * (0.17 * m_.height / 1.74 + 0.19 * m_.bust);
  if (kind_ == Kind::figure)
    shoulder = std::max(shoulder, (clear_shoulder(of_girth(0.90 * bust, 0.84, 0.0)[0]) - 0.008) / 0.865);
  const double nape = 0.053 * width;
  heights_ = {l.crotch - 0.06, l.crotch, l.hip,      l.waist - 0.45 * (l.waist - l.hip), l.waist, l.under_bust,
              l.bust,          l.armpit, l.shoulder, 0.5 * (l.shoulder + l.neck),        l.neck,  l.chin,
              l.top - 0.1};
  sections_ = {of_girth(0.86 * hip, 0.76, 0.012),
               of_girth(0.93 * hip, 0.74, 0.010),
               of_girth(0.97 * hip, 0.72, 0.006),
               of_girth(0.52 * waist + 0.43 * hip, 0.74, 0.004),
               of_girth(waist, 0.74, 0.0),
               of_girth(0.50 * waist + 0.40 * bust, 0.78, 0.0),
               of_girth(0.90 * bust, 0.84, 0.004),
               {0.91 * shoulder, 0.100 * width, 0.012},
               {0.93 * shoulder, 0.064 * width, 0.022},
               {0.60 * shoulder, 0.056 * width, 0.024},
               {nape, 0.058 * width, 0.018},
               {0.90 * nape, 0.052 * width, 0.010},
               {0.90 * nape, 0.052 * width, 0.006}};
  const double cup = bust / 0.88, half = sections_[6][0], front = sections_[6][1];
  breast_ = {Vec3(0.50 * half, -front + 0.024 * cup, l.bust - 0.004), Vec3(0.060, 0.056, 0.062) * cup};
  breast_.centre.y() += sections_[6][2];
  const double back = sections_[2][1] + sections_[2][2];
  seat_ = {Vec3(0.44 * sections_[2][0], back - 0.055 * hip / 0.94, l.hip - 0.005),
           Vec3(0.082, 0.074, 0.092) * hip / 0.94};
  build_legs();
  build_arms();
}

/// How far out the shoulder joint must be for the arm to be clear of the trunk, so wide at the bust, there.
double Shape::clear_shoulder(double trunk) const {
  const double size = m_.height / 1.74, thick = 0.5 * (m_.bust / 0.88 + size);
  const double drop = levels_.shoulder - 0.034 * thick - (levels_.bust + 0.03 * size);
  return trunk + 0.016 + (0.047 * thick - drop * std::sin(m_.arm_angle)) / std::cos(m_.arm_angle);
}

void Shape::build_legs() {
  const double floor = m_.inseam, round = scale_[2] * m_.hip / (2.0 * pi);
  const double thigh = 0.575 * round, flat = 1.16;
  const double out = 0.93 * thigh + 0.013;
  const auto station = [&](double fraction, double girth, double x, double y) {
    return Station{-fraction, Vec3(x, y, fraction * floor), girth * round / std::sqrt(flat)};
  };
  // From the hip joint down; the axis bends back at the calf, as legs do.
  const std::vector<Station> stations{
      station(1.10, 0.55, out - 0.005, 0.006), station(1.0, 0.565, out, 0.008),   station(0.90, 0.540, out, 0.004),
      station(0.75, 0.460, out, -0.004),       station(0.60, 0.385, out, -0.006), station(0.55, 0.365, out, -0.004),
      station(0.50, 0.350, out, 0.004),        station(0.40, 0.362, out, 0.014),  station(0.32, 0.335, out, 0.018),
      station(0.20, 0.250, out, 0.020),        station(0.105, 0.222, out, 0.022), station(0.05, 0.222, out, 0.022)};
  const Sampled leg = sample(stations, 44);
  leg_ = Limb(leg.points, leg.radii, flat);
  const double size = m_.height / 1.74, x = out;
  foot_ = Limb(
      {Vec3(x, 0.040 * size, 0.034 * size), Vec3(x, 0.0, 0.046 * size), Vec3(x + 0.006, -0.060 * size, 0.038 * size),
       Vec3(x + 0.012, -0.125 * size, 0.027 * size), Vec3(x + 0.014, -0.165 * size, 0.022 * size)},
      {0.031 * size, 0.036 * size, 0.035 * size, 0.028 * size, 0.019 * size}, 1.0);
  joints_.hip = {x, 0.008, levels_.crotch + 0.055 * size};
  joints_.knee = {x, -0.004, 0.555 * floor};
  joints_.ankle = {x, 0.022, 0.085 * floor};
}

void Shape::build_arms() {
  const double size = m_.height / 1.74, thick = 0.5 * (m_.bust / 0.88 + size);
  const double c = std::cos(m_.arm_angle), s = std::sin(m_.arm_angle);
  const Vec3 down(s, 0.0, -c), fore = Vec3(s, -0.16, -c).normalized();
  const Vec3 shoulder(0.93 * sections_[8][0] + 0.008, 0.020, levels_.shoulder - 0.034 * thick);
  const Vec3 elbow = shoulder + 0.300 * size * down, wrist = elbow + 0.245 * size * fore;
  const auto upper = [&](double at, double r) { return Station{at, shoulder + at * size * down, r * thick}; };
  const auto lower = [&](double at, double r) { return Station{0.3 + at, elbow + at * size * fore, r * thick}; };
  const Sampled arm =
      sample({upper(0.0, 0.047), upper(0.06, 0.047), upper(0.13, 0.0435), upper(0.22, 0.039), upper(0.30, 0.0355),
              lower(0.07, 0.0355), lower(0.15, 0.030), lower(0.245, 0.0235), lower(0.275, 0.0235)},
             28);
  arm_ = Limb(arm.points, arm.radii, 1.0);
  // A mitten: longer than wide than thick, the palm towards the body.
  const auto palm = [&](double at) { return Vec3(elbow + at * size * fore); };
  hand_ = Limb({palm(0.26), palm(0.31), palm(0.36), palm(0.405)},
               {0.0185 * size, 0.0205 * size, 0.0185 * size, 0.0125 * size}, 1.75);
  joints_.shoulder = shoulder;
  joints_.elbow = elbow;
  joints_.wrist = wrist;
}

Shape::Section Shape::section(double z) const {
  const auto value = [&](std::size_t c) {
    return interpolate(
        heights_, [&](std::size_t k) { return sections_[k][c]; }, z);
  };
  return {value(0), value(1), value(2)};
}

double Shape::trunk(const Vec3& p) const {
  const Section s = section(p.z());
  const double x = p.x(), y = p.y() - s.centre, a2 = s.width * s.width, b2 = s.depth * s.depth;
  const double outside = std::sqrt(x * x / a2 + y * y / b2);
  const double slope = std::sqrt(x * x / (a2 * a2) + y * y / (b2 * b2));
  double d = slope > 1e-12 ? outside * (outside - 1.0) / slope : -std::min(s.width, s.depth);
  // Where sections change quickly with the height, as at the shoulders, the surface is nearer than they are.
  constexpr double h = 1e-3;
  const Section above = section(p.z() + h), below = section(p.z() - h);
  const double lean = 0.5 * (above.width - below.width) / h * std::min(1.0, std::abs(x) / s.width);
  return d / std::sqrt(1.0 + lean * lean);
}

double Shape::head(const Vec3& p) const {
  const double size = (levels_.top - levels_.chin) / 0.225;
  const double middle = 0.5 * (levels_.top + levels_.chin);
  const Vec3 skull(0.0, 0.004, levels_.top - 0.098 * size), jaw(0.0, -0.030 * size, middle - 0.045 * size);
  const double a = ellipsoid(p - skull, Vec3(0.073, 0.094, 0.098) * size);
  const double b = ellipsoid(p - jaw, Vec3(0.050, 0.056, 0.066) * size);
  return smooth_min(a, b, 0.05 * size);
}

double Shape::body(const Vec3& p) const {
  const Vec3 side = folded(p);
  double d = trunk(p);
  if (m_.person == Person::woman) d = smooth_min(d, ellipsoid(side - breast_.centre, breast_.axes), 0.035);
  d = smooth_min(d, ellipsoid(side - seat_.centre, seat_.axes), 0.05);
  if (kind_ == Kind::form) {
    d = smooth_max(d, levels_.crotch + 0.01 - p.z(), 0.03);
    return smooth_max(d, p.z() - (levels_.neck + 0.035), 0.02);
  }
  d = smooth_max(d, levels_.crotch + 0.006 - p.z(), 0.05);
  d = smooth_max(d, p.z() - (levels_.chin + 0.07), 0.02);
  const double leg = smooth_min(leg_.distance(side), foot_.distance(side), 0.04);
  d = smooth_min(d, smooth_max(leg, 0.002 - p.z(), 0.008), 0.035);
  return smooth_min(d, head(p), 0.03);
}

double Shape::arm(const Vec3& p) const {
  const Vec3 side = folded(p);
  return smooth_min(arm_.distance(side), hand_.distance(side), 0.02);
}

double Shape::stand(const Vec3& p) const {
  const double from_axis = std::hypot(p.x(), p.y() - 0.01), size = m_.height / 1.74;
  const double pole = std::max(from_axis - 0.018 * size, p.z() - levels_.hip);
  const double foot = smooth_max(from_axis - 0.15 * size, std::abs(p.z() - 0.018) - 0.016, 0.015);
  return smooth_max(smooth_min(pole, foot, 0.05), 0.002 - p.z(), 0.004);
}

double Shape::operator()(const Vec3& p) const {
  if (kind_ == Kind::form) return smooth_min(body(p), stand(p), 0.03);
  return smooth_min(body(p), arm(p), 0.025);
}

double usual_height(Person person) {
  return person == Person::woman ? Measurements{}.height : person == Person::man ? 1.80 : 1.16;
}

Measurements usual_measurements(Person person, double height) {
  Measurements m;
  m.person = person;
  m.height = height;
  if (person == Person::man) {
    m.bust = 0.98;
    m.waist = 0.84;
    m.hip = 0.98;
    m.inseam = 0.46 * height;
  } else if (person == Person::woman) {
    m.inseam = 0.80 / 1.74 * height;
  } else {
    // Means of the charts of Ottobre design, FWF and Marks & Spencer, to half a centimetre.
    static const std::vector<double> heights{0.74, 0.92, 1.04, 1.16, 1.28, 1.40, 1.52, 1.64, 1.76};
    static const std::vector<std::array<double, 4>> charts{
        {0.470, 0.460, 0.485, 0.270}, {0.540, 0.520, 0.565, 0.370}, {0.575, 0.540, 0.605, 0.445},
        {0.615, 0.560, 0.645, 0.520}, {0.660, 0.585, 0.695, 0.585}, {0.710, 0.615, 0.750, 0.645},
        {0.770, 0.650, 0.810, 0.705}, {0.835, 0.680, 0.875, 0.765}, {0.900, 0.720, 0.930, 0.820}};
    const auto of = [&](std::size_t c) {
      return interpolate(
          heights, [&](std::size_t k) { return charts[k][c]; }, height);
    };
    m.bust = of(0);
    m.waist = of(1);
    m.hip = of(2);
    m.inseam = of(3);
  }
  return m;
}

void check(const Measurements& m) {
  const auto within = [](const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high))
      throw UserError(fmt::format("{} = {:g} m is outside {:g} to {:g} m", name, value, low, high));
  };
  if (m.person == Person::child)
    within("height of a child", m.height, 0.7, 1.8);
  else
    within("height", m.height, 1.2, 2.2);
  within("bust", m.bust, 0.36 * m.height, 0.85 * m.height);
  within("waist", m.waist, 0.28 * m.height, 0.85 * m.height);
  within("hip", m.hip, 0.38 * m.height, 0.85 * m.height);
  within("inseam", m.inseam, (m.person == Person::child ? 0.34 : 0.40) * m.height, 0.52 * m.height);
  if (!(m.arm_angle >= 0.087 && m.arm_angle <= 1.4))
    throw UserError(fmt::format("the angle of the arms is {:.3g} degrees: 5 to 80 keep the armpits open",
                                m.arm_angle * 180.0 / pi));
}

}  // namespace voile::manikin
