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

/// How far a point follows the turn of each joint, 0 to 1, on its own side.
struct Following {
  double chest = 0.0, head = 0.0, thigh = 0.0, shin = 0.0, foot = 0.0, arm = 0.0, forearm = 0.0;
  std::size_t side = 0;
};

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

Following following(const Shape& shape, const Vec3& p) {
  const Joints& j = shape.joints();
  const Levels& l = shape.levels();
  const double size = std::max(shape.measurements().height / 1.74, shape.measurements().hip / 0.94);
  Following f;
  f.side = p.x() >= 0.0 ? 0 : 1;
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  // An arm moves what is nearer to it than to the trunk, beyond the shoulder.
  const Vec3 along = (j.elbow - j.shoulder).normalized();
  const double beyond = (q - j.shoulder).dot(along), fore = (q - j.elbow).dot((j.wrist - j.elbow).normalized());
  f.arm = smooth_step(0.5 + (shape.body(p) - shape.arm(p)) / (0.05 * size)) *
          smooth_step((beyond + 0.04 * size) / (0.12 * size));
  f.forearm = f.arm * smooth_step(0.5 + fore / (0.10 * size));
  // The line of the groin rises outwards; at the crotch both legs hand over to the pelvis.
  const double groin = l.crotch + 0.005 * size + 0.85 * q.x() * std::min(1.0, q.x() / (0.03 * size));
  const double rest = 1.0 - f.arm;
  f.thigh = rest * smooth_step((groin + 0.02 * size - q.z()) / (0.16 * size));
  f.shin = rest * smooth_step(0.5 + (j.knee.z() - q.z()) / (0.16 * size));
  f.foot = rest * smooth_step(0.5 + (j.ankle.z() - q.z()) / (0.07 * size));
  f.head = rest * smooth_step((q.z() - l.neck) / (l.chin + 0.02 - l.neck));
  f.chest = f.arm + rest * smooth_step((q.z() - l.waist + 0.10 * size) / (0.24 * size));
  return f;
}

/// Angles of all joints [rad], and where the pelvis is.
struct Pose {
  Vec3 shift = Vec3::Zero();  ///< [m]
  double yaw = 0.0, tilt = 0.0;
  double chest_yaw = 0.0, head_yaw = 0.0;                                            ///< against the pelvis
  std::array<double, sides> hip{}, knee{}, ankle{}, shoulder{}, elbow{}, arm_out{};  ///< forwards, except knee
  Vec3 hip_crease = Vec3::Zero(), knee_crease = Vec3::Zero(),
       arm_crease = Vec3::Zero();  ///< from joints to where skin folds over them [m]
};

Eigen::Affine3d about(const Vec3& point, const Eigen::AngleAxisd& turn) {
  return Eigen::Translation3d(point) * turn * Eigen::Translation3d(-point);
}

/// Joints turn a point by the part of their angle with which it follows them: skin keeps its distance from the joint.
Vec3 moved(const Shape& shape, const Pose& pose, const Following& f, const Vec3& at_rest) {
  const Joints& j = shape.joints();
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const double mirror = f.side == 0 ? 1.0 : -1.0;
  const auto here = [&](const Vec3& joint) { return Vec3(mirror * joint.x(), joint.y(), joint.z()); };
  // Forwards is -y: a positive turn about -x lifts a leg that hangs down to the front.
  const auto forwards = [&](const Vec3& joint, double angle) {
    return about(here(joint), Eigen::AngleAxisd(-angle, x));
  };
  const Vec3 middle(0.0, 0.0, shape.levels().hip), waist(0.0, 0.0, shape.levels().waist),
      neck(0.0, 0.015, shape.levels().neck), hip = j.hip + pose.hip_crease, shoulder = j.shoulder + pose.arm_crease;
  const std::size_t s = f.side;
  Eigen::Affine3d t = Eigen::Translation3d(pose.shift) * about(middle, Eigen::AngleAxisd(pose.yaw, z)) *
                      about(middle, Eigen::AngleAxisd(pose.tilt, y));
  if (f.chest > 0.0)
    t = t * about(waist, Eigen::AngleAxisd(-f.chest * pose.tilt, y)) *
        about(waist, Eigen::AngleAxisd(f.chest * pose.chest_yaw, z));
  if (f.head > 0.0) t = t * about(neck, Eigen::AngleAxisd(f.head * pose.head_yaw, z));
  if (f.thigh > 0.0)  // legs hang straight down from a tilted pelvis
    t = t * about(here(j.hip), Eigen::AngleAxisd(-f.thigh * pose.tilt, y)) * forwards(hip, f.thigh * pose.hip[s]);
  if (f.shin > 0.0) t = t * forwards(j.knee + pose.knee_crease, -f.shin * pose.knee[s]);
  if (f.foot > 0.0) t = t * forwards(j.ankle, f.foot * pose.ankle[s]);
  if (f.arm > 0.0) {
    // Skin folds over the crease, but the arm turns about its joint.
    const Eigen::AngleAxisd out(-mirror * pose.arm_out[s], y);
    const Vec3 slip = about(here(j.shoulder), out) * here(j.shoulder) - about(here(shoulder), out) * here(j.shoulder);
    t = t * Eigen::Translation3d(f.arm * slip) *
        about(here(shoulder), Eigen::AngleAxisd(-mirror * f.arm * pose.arm_out[s], y)) *
        forwards(j.shoulder, f.arm * pose.shoulder[s]);
  }
  if (f.forearm > 0.0) t = t * forwards(j.elbow, f.forearm * pose.elbow[s]);
  return t * at_rest;
}

/// Of ankles: those of infants are short and thick, so that skin would fold over itself.
double suppleness(const Shape& shape) {
  return std::min(1.0, shape.measurements().inseam / 0.65);
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
    p.ankle[s] = suppleness(shape) * (0.6 * p.knee[s] - 0.65 * p.hip[s]);
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

/// As walking(), with bent arms, heels that swing up behind, and a flight between steps.
Pose running(const Shape& shape, const MotionOptions& o, double t) {
  constexpr double start = 0.8,
                   contact = 0.55;  // until it is under way [s]; fraction of a step with a foot on the ground
  const double leg = shape.joints().hip.z(), rate = pi * o.cadence, size = leg / 0.85;
  const double full = std::asin(std::min(0.7, 0.5 * contact * o.speed / (o.cadence * leg)));
  const double fraction = smooth_step(t / start), phase = rate * start * smooth_step_integral(t / start);
  const double swing = fraction * full;
  Pose p;
  for (std::size_t s = 0; s < sides; ++s) {
    const double own = phase + (s == 0 ? 0.0 : pi);
    const double lifted = 0.5 * (1.0 + std::cos(own + 0.6));
    p.knee[s] = fraction * (0.30 + 3.2 * full * lifted * lifted);
    p.hip[s] = swing * std::sin(own) + 0.45 * p.knee[s];
    p.ankle[s] = suppleness(shape) * (0.5 * p.knee[s] - 0.55 * p.hip[s]);
    p.shoulder[s] = -1.1 * swing * std::sin(own) - 0.10 * fraction;
    p.elbow[s] = fraction * (1.25 - 0.25 * std::sin(own));
  }
  p.yaw = 0.35 * swing * std::sin(phase);
  p.chest_yaw = -0.75 * swing * std::sin(phase);
  p.head_yaw = -(p.yaw + p.chest_yaw);
  p.knee_crease = {0.0, 0.020 * shape.measurements().hip / 0.94, 0.0};
  const double bounce = 0.03 * size * fraction * std::cos(2.0 * phase);
  p.shift = {0.0, -o.speed * start * smooth_step_integral(t / start), bounce - 0.02 * size * fraction};
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

/// The left arm rises outwards.
Pose lifting(const Shape& shape, const MotionOptions& o, double t) {
  Pose p;
  p.arm_out[0] = (o.angle - shape.measurements().arm_angle) * smooth_step(t / o.seconds);
  p.arm_crease = {-0.02, 0.0, 0.03};
  return p;
}

/// Onto a stool as high as the knees: shins stay upright and feet where they are.
Pose sitting(const Shape& shape, const MotionOptions& o, double t) {
  const Joints& j = shape.joints();
  const double bend = 0.5 * pi * smooth_step(t / o.seconds), thick = shape.measurements().hip / 0.94;
  Pose p;
  p.hip = {bend, bend};
  p.knee = {bend, bend};
  p.hip_crease = {0.0, -0.05 * thick, 0.0};
  p.knee_crease = {0.0, 0.025 * thick, 0.0};
  Following foot;
  foot.thigh = foot.shin = foot.foot = 1.0;
  p.shift = j.ankle - moved(shape, p, foot, j.ankle);
  return p;
}

Pose pose_at(const Shape& shape, const MotionOptions& o, double t) {
  switch (o.motion) {
    case Motion::walk:
      return walking(shape, o, t);
    case Motion::run:
      return running(shape, o, t);
    case Motion::turn:
      return turning(o, t);
    case Motion::lift:
      return lifting(shape, o, t);
    case Motion::sit:
      return sitting(shape, o, t);
  }
  return {};
}

void check(const MotionOptions& o) {
  const auto within = [](const char* name, double value, double low, double high, const char* unit) {
    if (!(value >= low && value <= high))
      throw UserError(fmt::format("{} = {:g} {} is outside {:g} to {:g} {}", name, value, unit, low, high, unit));
  };
  within("seconds", o.seconds, 0.1, 60.0, "s");
  within("fps", o.frames_per_second, 10.0, 1000.0, "1/s");
  const bool runs = o.motion == Motion::run;
  within("speed", o.speed, 0.1, runs ? 4.0 : 1.6, "m/s");
  within("cadence", o.cadence, 0.8, runs ? 3.5 : 2.4, "1/s");
  if (o.motion == Motion::lift)
    within("angle of lift", o.angle * 180.0 / pi, 0.0, 120.0, "degrees");
  else
    within("angle", o.angle * 180.0 / pi, -720.0, 720.0, "degrees");
}

}  // namespace

MotionOptions usual_motion(Motion motion, double inseam) {
  MotionOptions o;
  o.motion = motion;
  if (motion == Motion::run) o.speed = 2.5, o.cadence = 2.7;
  o.speed *= std::min(1.0, inseam / 0.65);  // children take smaller steps
  if (motion == Motion::lift) o.angle = 0.5 * pi;
  return o;
}

namespace {

double lowest(const std::vector<Vec3>& x) {
  return std::min_element(x.begin(), x.end(), [](const Vec3& a, const Vec3& b) { return a[2] < b[2]; })->z();
}

}  // namespace

std::vector<std::vector<Vec3>> frames(const Figure& figure, const MotionOptions& options) {
  check(options);
  const Shape& shape = figure.shape;
  std::vector<Following> all_following;
  for (const Vec3& x : figure.surface.positions)
    all_following.push_back(shape.kind() == Kind::figure ? following(shape, x) : Following{});
  const int count = static_cast<int>(std::floor(options.seconds * options.frames_per_second + 1e-9)) + 1;
  std::vector<std::vector<Vec3>> all;
  for (int f = 0; f < count; ++f) {
    const double t = f / options.frames_per_second;
    const Pose pose = pose_at(shape, options, t);
    std::vector<Vec3>& frame = all.emplace_back();
    for (std::size_t v = 0; v < all_following.size(); ++v)
      frame.push_back(moved(shape, pose, all_following[v], figure.surface.positions[v]));
    // A foot that bends would reach below the floor.
    if (const double below = lowest(figure.surface.positions) - lowest(frame); below > 0.0)
      for (Vec3& x : frame) x[2] += below;
  }
  return all;
}

}  // namespace voile::manikin
