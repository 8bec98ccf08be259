#include "rigid_bodies.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace voile::system {

namespace {

using Quaternion = Eigen::Vector4d;

Mat3 cross(const Vec3& p) {
  Mat3 m;
  m << 0.0, -p.z(), p.y(), p.z(), 0.0, -p.x(), -p.y(), p.x(), 0.0;
  return m;
}

/// The symmetric form h(q, q) = 2 (q_0 [p] + [p]^2).
Mat3 form(const Quaternion& a, const Quaternion& b) {
  const Mat3 p = cross(a.tail<3>()), r = cross(b.tail<3>());
  return a[0] * r + b[0] * p + p * r + r * p;
}

/// S(M) with the generalised force 2 S q/n of a moment.
Eigen::Matrix4d moment_form(const Vec3& m) {
  Eigen::Matrix4d s = Eigen::Matrix4d::Zero();
  s.block<1, 3>(0, 1) = -m.transpose();
  s.block<3, 1>(1, 0) = m;
  s.block<3, 3>(1, 1) = cross(m);
  return s;
}

/// The rotation vector of a quaternion of any length.
Vec3 vector_of(const Quaternion& q) {
  const Vec3 p = q.tail<3>();
  const double size = p.norm();
  return size > 0.0 ? Vec3(2.0 * std::atan2(size, q[0]) / size * p) : Vec3(Vec3::Zero());
}

}  // namespace

RigidMotion::RigidMotion(const RigidBody& body)
    : length_(body.length),
      stiffness_(body.stiffness),
      place_(body.place),
      first_(Mat3::Identity() + form(place_.turn, place_.turn)) {
  map_.setZero();
  map_.block<3, 3>(1, 0) = body.basis / length_;
  map_(0, 3) = 1.0 / length_;
  set(Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
}

void RigidMotion::set(const Vec3& b0, const Vec3& b1, const Vec3& b2) {
  displacement_ = place_.displacement + b0;
  q_ = map_ * Quaternion(b1[0], b1[1], b1[2], b2[0]) + Quaternion::UnitX();
  const double n = q_.squaredNorm();
  since_ = form(q_, q_) / n;
  turned_ = since_ * first_ + (first_ - Mat3::Identity());
  for (int i = 0; i < turns; ++i)
    slope_[static_cast<std::size_t>(i)] =
        (2.0 * form(q_, direction(i)) - 2.0 * q_.dot(direction(i)) * since_) / n * first_;
}

Quaternion RigidMotion::quaternion() const {
  const Vec3 p = q_.tail<3>(), first = place_.turn.tail<3>();
  Quaternion all;
  all << q_[0] * place_.turn[0] - p.dot(first), q_[0] * first + place_.turn[0] * p + p.cross(first);
  return all.normalized();
}

Vec3 RigidMotion::rotation_vector() const {
  return vector_of(quaternion());
}

Vec3 RigidMotion::turn_in_stage() const {
  return vector_of(q_);
}

Mat3 RigidMotion::curvature(int i, int j) const {
  const Quaternion a = direction(i), b = direction(j);
  const double n = q_.squaredNorm(), na = 2.0 * q_.dot(a), nb = 2.0 * q_.dot(b);
  const Mat3 second = (2.0 * form(a, b) - 2.0 * a.dot(b) * since_) * first_;
  return (second - na * slope_[static_cast<std::size_t>(j)] - nb * slope_[static_cast<std::size_t>(i)]) / n;
}

Eigen::Matrix<double, 3, RigidMotion::turns> RigidMotion::spin() const {
  Eigen::Matrix<double, 3, turns> w;
  const Vec3 p = q_.tail<3>();
  for (int i = 0; i < turns; ++i) {
    const Quaternion d = direction(i);
    const Vec3 dp = d.tail<3>();
    w.col(i) = 2.0 / q_.squaredNorm() * (q_[0] * dp - d[0] * p + p.cross(dp));
  }
  return w;
}

Eigen::Matrix4d RigidMotion::moment_slope(const Vec3& moment) const {
  const double n = q_.squaredNorm();
  const Eigen::Matrix4d s = moment_form(moment);
  return map_.transpose() * (2.0 / n * s - 4.0 / (n * n) * (s * q_) * q_.transpose()) * map_;
}

std::array<Vec3, 2> RigidMotion::unknowns_of(const Vec3& axis, double angle) const {
  const Vec3 p = std::sin(0.5 * angle) * axis;
  const Mat3 basis = length_ * map_.block<3, 3>(1, 0);
  return {Vec3(length_ * (basis.transpose() * p)), Vec3(length_ * (std::cos(0.5 * angle) - 1.0), 0.0, 0.0)};
}

double RigidMotion::length_energy() const {
  const double s = 0.5 * length_ * (q_.squaredNorm() - 1.0);
  return 0.5 * stiffness_ * s * s;
}

Eigen::Vector4d RigidMotion::length_force() const {
  const double s = 0.5 * length_ * (q_.squaredNorm() - 1.0);
  return stiffness_ * s * length_ * (map_.transpose() * q_);
}

Eigen::Matrix4d RigidMotion::length_tangent() const {
  const double s = 0.5 * length_ * (q_.squaredNorm() - 1.0);
  const Eigen::Vector4d first = length_ * (map_.transpose() * q_);
  return stiffness_ * (first * first.transpose() + s * length_ * map_.transpose() * map_);
}

RigidMotion::Block RigidMotion::mass(const BodyMass& of) const {
  Block m = Block::Zero();
  m.topLeftCorner<3, 3>() = of.mass * Mat3::Identity();
  for (int i = 0; i < turns; ++i) {
    m.block<3, 1>(0, 3 + i) = slope(i) * of.first;
    m.block<1, 3>(3 + i, 0) = m.block<3, 1>(0, 3 + i).transpose();
    for (int j = 0; j < turns; ++j) m(3 + i, 3 + j) = (slope(i) * of.second).cwiseProduct(slope(j)).sum();
  }
  return m;
}

RigidMotion::Row RigidMotion::gyration(const BodyMass& of, const Row& rates) const {
  Mat3 turning = Mat3::Zero();  // d2R/dt2 at constant rates
  for (int i = 0; i < turns; ++i)
    for (int j = 0; j < turns; ++j) turning += rates[3 + i] * rates[3 + j] * curvature(i, j);
  Row f;
  f.head<3>() = turning * of.first;
  for (int i = 0; i < turns; ++i) f[3 + i] = (slope(i) * of.second).cwiseProduct(turning).sum();
  return f;
}

}  // namespace voile::system
