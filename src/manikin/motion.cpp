#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "figure.hpp"
#include "voile/errors.hpp"

namespace voile::manikin {

namespace {

using std::numbers::pi;
constexpr std::size_t sides = 2;  // left, right

struct Bone {
  enum : std::size_t {
    pelvis,
    chest,
    head,
    thigh,
    shin = thigh + sides,
    foot = shin + sides,
    upper_arm = foot + sides,
    forearm = upper_arm + sides,
    count = forearm + sides
  };
};
using Weights = std::array<double, Bone::count>;
using Places = std::array<Eigen::Affine3d, Bone::count>;

/// 0 before 0, 1 after 1, with two continuous derivatives.
double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

/// Integral of smooth_step from 0 to t.
double smooth_step_integral(double t) {
  if (t <= 0.0) return 0.0;
  const double s = std::min(t, 1.0);
  return s * s * s * s * (s * s - 3.0 * s + 2.5) + std::max(0.0, t - 1.0);
}

Weights weights(const Shape& shape, const Vec3& p) {
  Weights w{};
  const Joints& j = shape.joints();
  const Levels& l = shape.levels();
  const double size = shape.measurements().height / 1.74;
  const std::size_t side = p.x() >= 0.0 ? 0 : 1;
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  // An arm moves what is nearer to it than to the trunk, beyond the shoulder.
  const Vec3 along = (j.elbow - j.shoulder).normalized();
  const double beyond = (q - j.shoulder).dot(along), fore = (q - j.elbow).dot((j.wrist - j.elbow).normalized());
  const double arm = smooth_step(0.5 + (shape.body(p) - shape.arm(p)) / (0.05 * size)) *
                     smooth_step((beyond + 0.04 * size) / (0.12 * size));
  const double forearm = smooth_step(0.5 + fore / (0.10 * size));
  w[Bone::forearm + side] = arm * forearm;
  w[Bone::upper_arm + side] = arm * (1.0 - forearm);
  // The line of the groin rises outwards; at the crotch both legs hand over to the pelvis.
  const double groin = l.crotch + 0.005 * size + 0.85 * q.x() * std::min(1.0, q.x() / (0.03 * size));
  const double leg = smooth_step((groin + 0.02 * size - q.z()) / (0.16 * size));
  const double shin = smooth_step(0.5 + (j.knee.z() - q.z()) / (0.16 * size));
  const double foot = smooth_step(0.5 + (j.ankle.z() - q.z()) / (0.07 * size));
  const double limb = (1.0 - arm) * leg;
  w[Bone::foot + side] = limb * foot;
  w[Bone::shin + side] = limb * (1.0 - foot) * shin;
  w[Bone::thigh + side] = limb * (1.0 - foot) * (1.0 - shin);
  const double head = smooth_step((q.z() - l.neck) / (l.chin + 0.02 - l.neck));
  const double chest = smooth_step((q.z() - l.waist + 0.10 * size) / (0.24 * size));
  const double trunk = (1.0 - arm) * (1.0 - leg);
  w[Bone::head] = trunk * head;
  w[Bone::chest] = trunk * (1.0 - head) * chest;
  w[Bone::pelvis] = trunk * (1.0 - head) * (1.0 - chest);
  return w;
}

/// Angles of all joints [rad], and where the pelvis is.
struct Pose {
  Vec3 shift = Vec3::Zero();  ///< [m]
  double yaw = 0.0, tilt = 0.0;
  double chest_yaw = 0.0, head_yaw = 0.0;                                            ///< against the pelvis
  std::array<double, sides> hip{}, knee{}, ankle{}, shoulder{}, elbow{}, arm_out{};  ///< forwards, except knee
};

Eigen::Affine3d about(const Vec3& point, const Eigen::AngleAxisd& turn) {
  return Eigen::Translation3d(point) * turn * Eigen::Translation3d(-point);
}

Places places(const Shape& shape, const Pose& pose) {
  const Joints& j = shape.joints();
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  // Forwards is -y: a positive turn about -x lifts a leg that hangs down to the front.
  const auto forwards = [&](const Vec3& joint, double angle) { return about(joint, Eigen::AngleAxisd(-angle, x)); };
  Places at;
  const Vec3 middle(0.0, 0.0, shape.levels().hip), waist(0.0, 0.0, shape.levels().waist),
      neck(0.0, 0.015, shape.levels().neck);
  at[Bone::pelvis] = Eigen::Translation3d(pose.shift) * about(middle, Eigen::AngleAxisd(pose.yaw, z)) *
                     about(middle, Eigen::AngleAxisd(pose.tilt, y));
  at[Bone::chest] = at[Bone::pelvis] * about(waist, Eigen::AngleAxisd(-pose.tilt, y)) *
                    about(waist, Eigen::AngleAxisd(pose.chest_yaw, z));
  at[Bone::head] = at[Bone::chest] * about(neck, Eigen::AngleAxisd(pose.head_yaw, z));
  for (std::size_t s = 0; s < sides; ++s) {
    const double mirror = s == 0 ? 1.0 : -1.0;
    const auto here = [&](const Vec3& joint) { return Vec3(mirror * joint.x(), joint.y(), joint.z()); };
    // Legs hang straight down from a tilted pelvis.
    at[Bone::thigh + s] =
        at[Bone::pelvis] * about(here(j.hip), Eigen::AngleAxisd(-pose.tilt, y)) * forwards(here(j.hip), pose.hip[s]);
    at[Bone::shin + s] = at[Bone::thigh + s] * forwards(here(j.knee), -pose.knee[s]);
    at[Bone::foot + s] = at[Bone::shin + s] * forwards(here(j.ankle), pose.ankle[s]);
    at[Bone::upper_arm + s] = at[Bone::chest] *
                              about(here(j.shoulder), Eigen::AngleAxisd(-mirror * pose.arm_out[s], y)) *
                              forwards(here(j.shoulder), pose.shoulder[s]);
    at[Bone::forearm + s] = at[Bone::upper_arm + s] * forwards(here(j.elbow), pose.elbow[s]);
  }
  return at;
}

/// A gait of sines: legs swing against each other, knees bend as they come forwards, shoulders turn against hips.
Pose walking(const Shape& shape, const MotionOptions& o, double t) {
  constexpr double start = 0.8;  // time until it is under way [s]
  const double leg = shape.joints().hip.z(), rate = pi * o.cadence;
  const double full = std::asin(std::min(0.6, 0.5 * o.speed / (o.cadence * leg)));
  const double fraction = smooth_step(t / start), phase = rate * start * smooth_step_integral(t / start);
  const double swing = fraction * full;
  Pose p;
  for (std::size_t s = 0; s < sides; ++s) {
    const double own = phase + (s == 0 ? 0.0 : pi);
    const double lifted = 0.5 * (1.0 + std::cos(own + 0.45));  // before the leg passes the other one
    p.hip[s] = swing * std::sin(own);
    p.knee[s] = fraction * (0.08 + 2.0 * full * lifted * lifted);
    p.hip[s] += 0.35 * p.knee[s];
    p.ankle[s] = 0.6 * p.knee[s] - 0.65 * p.hip[s];
    p.shoulder[s] = -0.7 * swing * std::sin(own);
    p.elbow[s] = fraction * (0.15 - 0.12 * std::sin(own));
  }
  p.yaw = 0.28 * swing * std::sin(phase);
  p.chest_yaw = -0.55 * swing * std::sin(phase);
  p.head_yaw = -(p.yaw + p.chest_yaw);
  p.tilt = 0.10 * swing * std::cos(phase);
  const double height = leg * (1.0 - std::cos(swing * std::sin(phase)));
  p.shift = {0.02 * fraction * std::cos(phase), -o.speed * start * smooth_step_integral(t / start), -height};
  return p;
}

/// Head and shoulders lead, arms are swept outwards.
Pose turning(const MotionOptions& o, double t) {
  const double fraction = t / o.seconds, lead = smooth_step(1.25 * fraction),
               follow = smooth_step(1.25 * fraction - 0.25);
  constexpr double most = 0.35;  // of shoulders against hips
  Pose p;
  p.yaw = o.angle * follow;
  p.chest_yaw = most * std::tanh(o.angle * (lead - follow) / most);
  p.head_yaw = 0.5 * p.chest_yaw;
  for (double& out : p.arm_out) out = 0.15 * std::abs(p.chest_yaw) / most * fraction * (1.0 - fraction) * 4.0;
  return p;
}

void check(const MotionOptions& o) {
  const auto within = [](const char* name, double value, double low, double high, const char* unit) {
    if (!(value >= low && value <= high))
      throw UserError(fmt::format("{} = {:g} {} is outside {:g} to {:g} {}", name, value, unit, low, high, unit));
  };
  within("seconds", o.seconds, 0.1, 60.0, "s");
  within("fps", o.frames_per_second, 10.0, 1000.0, "1/s");
  within("speed", o.speed, 0.1, 1.6, "m/s");
  within("cadence", o.cadence, 0.8, 2.4, "1/s");
  within("angle", o.angle * 180.0 / pi, -720.0, 720.0, "degrees");
}

}  // namespace

std::vector<std::vector<Vec3>> frames(const Figure& figure, const MotionOptions& options) {
  check(options);
  const Shape& shape = figure.shape;
  std::vector<Weights> fractions;
  for (const Vec3& x : figure.surface.positions) {
    fractions.push_back({1.0});
    if (shape.kind() == Kind::figure) fractions.back() = weights(shape, x);
  }
  const int count = static_cast<int>(std::floor(options.seconds * options.frames_per_second + 1e-9)) + 1;
  std::vector<std::vector<Vec3>> all;
  for (int f = 0; f < count; ++f) {
    const double t = f / options.frames_per_second;
    const Places at = places(shape, options.motion == Motion::walk ? walking(shape, options, t) : turning(options, t));
    std::vector<Vec3>& frame = all.emplace_back();
    for (std::size_t v = 0; v < fractions.size(); ++v) {
      Vec3 x = Vec3::Zero();
      for (std::size_t b = 0; b < Bone::count; ++b)
        if (fractions[v][b] > 0.0) x += fractions[v][b] * (at[b] * figure.surface.positions[v]);
      frame.push_back(x);
    }
  }
  return all;
}

}  // namespace voile::manikin
