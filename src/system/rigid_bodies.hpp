// Groups of vertices that move as rigid bodies: exact in large rotations, without a stiffness of their own.
//
// Symbols   C, c     reference point at the start [m], its displacement [m];  xi = X - C arm of a vertex at the start [m]
//           q        quaternion (q_0, p) of the rotation, of any length;  n = |q|^2
//           l        length [m], twice the radius of gyration of the arms, so that all unknowns are alike
//           B        axes of the rotation's unknowns, the first along a given axis of turning
//           c_1, R_1 where the body is as the stage begins
//   R    = (I + 2 (q_0 [p] + [p]^2)/n) R_1,  [p] w = p x w                x = C + c + R xi
//   c    = c_1 + b_0,  p = B b_1/l,  q_0 = 1 + b_2x/l
// b_0, b_1 and b_2x are the unknowns of three vertices of the group, its carriers; the other unknowns of the group are fixed.
// R does not depend on |q|, so that E_n = k/2 (l (n - 1)/2)^2 holds |q| at 1 without doing anything else.
//   df   = F.dc + G:dR,   F = sum f,  G = sum f xi^T        of forces f on the points of the body
//   df   = F.dc + M.dw,   dw = 2 (q_0 dp - dq_0 p + p x dp)/n      of a moment M about the reference point
// Source: A.A. Shabana, Dynamics of Multibody Systems, 4th ed. (2013), chapter 2 (Euler parameters).
#pragma once

#include <array>
#include <vector>

#include "base/types.hpp"
#include "conditions.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::system {

struct Constraints;

/// One group on a mesh, the same on every rank.
struct RigidBody {
  std::vector<Index> members;              ///< vertices, ascending
  std::array<Index, 3> carriers{};         ///< three of them
  Vec3 point = Vec3::Zero();               ///< C [m]
  Mat3 basis = Mat3::Identity();           ///< B
  double length = 1.0;                     ///< l [m]
  double stiffness = 1.0;                  ///< k [N/m]
  double mass = 0.0;                       ///< at the reference point [kg]
  RigidPlace place;                        ///< c_1, R_1
  std::vector<mesh::TriangleSide> slopes;  ///< boundary sides whose slope turns with the body
  /// Points that move with it besides the vertices: C and C + l times each axis.
  static constexpr int frame_points = 4;
  [[nodiscard]] Vec3 frame_point(int k) const { return k == 0 ? point : Vec3(point + length * Vec3::Unit(k - 1)); }
};

/// Finds the bodies of a mesh and adds what they fix to `constraints`. Not collective. Throws UserError for unknown groups,
/// vertices that something else holds, and slopes that cannot be held.
void resolve_rigid_groups(const mesh::SurfaceMesh& mesh, const std::vector<RigidGroup>& groups,
                          Constraints& constraints);

/// Forces on the points of a body, or what acts alike.
struct BodyForce {
  Vec3 force = Vec3::Zero();    ///< F [N]
  Mat3 moments = Mat3::Zero();  ///< G [N m]
  void add(const Vec3& f, const Vec3& arm) {
    force += f;
    moments += f * arm.transpose();
  }
  void add(double factor, const BodyForce& other) {
    force += factor * other.force;
    moments += factor * other.moments;
  }
};

/// Mass of a body: sums of m, m xi, m xi xi^T over its vertices [kg], [kg m], [kg m^2].
struct BodyMass {
  double mass = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  void add(double m, const Vec3& arm) {
    mass += m;
    first += m * arm;
    second += m * arm * arm.transpose();
  }
};

/// The kinematics of one body. Numbers of the rotation's unknowns: 0 to 2 are those of the second carrier, 3 is the first of the
/// third.
class RigidMotion {
 public:
  static constexpr int turns = 4;

  explicit RigidMotion(const RigidBody& body);
  /// Takes the unknowns of the three carriers [m].
  void set(const Vec3& b0, const Vec3& b1, const Vec3& b2);

  [[nodiscard]] const Vec3& displacement() const { return displacement_; }
  /// R - I, without round-off near R = I.
  [[nodiscard]] const Mat3& turned() const { return turned_; }
  /// Of R as a unit quaternion, q_0 first.
  [[nodiscard]] Eigen::Vector4d quaternion() const;
  /// Rotation vector of R [rad], of a size up to 2 pi.
  [[nodiscard]] Vec3 rotation_vector() const;
  /// Likewise of the turn since R_1.
  [[nodiscard]] Vec3 turn_in_stage() const;
  /// dR/db and d2R/db2 [1/m], [1/m^2].
  [[nodiscard]] const Mat3& slope(int i) const { return slope_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Mat3 curvature(int i, int j) const;
  /// dw/db: column i is the rotation vector of a change of unknown i [1/m].
  [[nodiscard]] Eigen::Matrix<double, 3, turns> spin() const;
  /// Derivative of the generalised force of a constant moment about the reference point, by the unknowns [N/m].
  [[nodiscard]] Eigen::Matrix4d moment_slope(const Vec3& moment) const;
  /// Unknowns of the second and third carrier of a rotation.
  [[nodiscard]] std::array<Vec3, 2> unknowns_of(const Vec3& axis, double angle) const;
  /// E_n, its derivatives by the unknowns [J], [N], [N/m].
  [[nodiscard]] double length_energy() const;
  [[nodiscard]] Eigen::Vector4d length_force() const;
  [[nodiscard]] Eigen::Matrix4d length_tangent() const;

  /// The unknowns of a body in one row: three of the displacement, then those of the rotation.
  using Row = Eigen::Matrix<double, 3 + turns, 1>;
  using Block = Eigen::Matrix<double, 3 + turns, 3 + turns>;
  /// M with the kinetic energy 1/2 db/dt.M db/dt [kg].
  [[nodiscard]] Block mass(const BodyMass& of) const;
  /// Forces of inertia besides M d2b/dt2, at rates of the unknowns [N].
  [[nodiscard]] Row gyration(const BodyMass& of, const Row& rates) const;

 private:
  [[nodiscard]] Eigen::Vector4d direction(int i) const { return map_.col(i); }

  Eigen::Matrix4d map_;  ///< dq/db, q_0 first
  double length_, stiffness_;
  RigidPlace place_;
  Mat3 first_;  ///< R_1
  Vec3 displacement_ = Vec3::Zero();
  Eigen::Vector4d q_;
  Mat3 since_ = Mat3::Zero();  ///< R R_1^T - I
  Mat3 turned_ = Mat3::Zero();
  std::array<Mat3, turns> slope_;
};

}  // namespace voile::system
