// Bending at joints (surface_mesh.hpp): springs between the slopes of the sheets that meet there.
//
// Symbols   a, b     ends of the edge, e = x_b - x_a
//           T, s     triangle of a sheet and its side on the edge;  n its outward normal in the plane of T, N that of T
//           g_s      derivative of the positions along n at the middle of the side, as a free edge has it: linear in positions
//           C_T      A S^T D S, stiffness of slopes of the free sides of T, S what a slope adds to the curvature (curvature.hpp) [N m];
//                    its part C_J of sides on joints when the other free sides follow, times the factor of the joint
//           psi_s    turn of g_s about e since the rest, less that of the first sheet at this edge;  sigma_s = +-1: slope = sigma_s psi_s
//           theta_J  turn of the edge J, likewise
// Each sheet ends with a free edge. The edges turn so that the sheets store least:
//   E = min_theta sum_T 1/2 d.C_J d,   d_s = sigma_s (theta_J - psi_s),   = 1/2 psi.Q psi
// With one joint side in each triangle, c_s = l^2 D_nn/A: E = 1/2 sum_(s<r) c_s c_r / sum c (psi_s - psi_r)^2. The moments
// about the edge balance. Angles are those of edge_angle.hpp: large rotations, no energy in rigid ones. A natural curvature
// kappa adds sigma_s (C_T^-1 A S^T D kappa)_s to psi_s. Theory: docs/theory/edge-slopes.md.
// A hinge of length l and stiffness k is a spring 2 k l between each of its two sheets and the edge: 1/(2 k l) joins the
// diagonal of C_J^-1, or 1/(k l) where the ground is the other side. Where its fold without moment is phi, sigma_s phi joins psi_s of the second sheet.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "curvature.hpp"
#include "edge_angle.hpp"
#include "term.hpp"

namespace voile::energy {

/// Joints that share triangles, of which all must be solved together; each a list of numbers of mesh.joints(). Joints that are clamped
/// are left out. More than `most_joints` are parted, and their common triangles approximated.
[[nodiscard]] std::vector<std::vector<Index>> joint_clusters(const Sheet& sheet);
inline constexpr std::size_t most_joints = 8;

/// The springs of one cluster, in mesh point numbering.
struct JointElement {
  struct Angle {  ///< psi of a side
    Index triangle;
    int edge, reference, vector;  ///< rows of `weights`; reference = vector: the first sheet, zero
    double rest;                  ///< angle at rest [rad]
    Index joint;                  ///< number of mesh.joints(), or beyond them, or no_index
    double fold;                  ///< what it adds of phi: sigma_s, or 0 for the first sheet
    Vec3 natural;                 ///< what a natural curvature of the triangle adds to psi [m]
  };
  struct Bend {  ///< what the joints add to the curvature of a triangle
    Index triangle;
    Eigen::Matrix<double, 3, Eigen::Dynamic> of_angles;  ///< [1/m]
  };
  std::vector<Index> points;
  Eigen::MatrixXd weights;  ///< e and g as functions of the points
  Eigen::MatrixX3d start;   ///< e and g at the start
  std::vector<Angle> angles;
  Eigen::MatrixXd stiffness;  ///< Q [N m]
  std::vector<Bend> bends;
};

/// Of each of mesh.joints().
struct JointStiffness {
  std::vector<double> hinges;   ///< k, infinite where it is none [N]
  std::vector<double> factors;  ///< > 0, of the energy that the joint stores beyond that of free edges
};

/// `cluster`: one of joint_clusters(). Throws UserError where a material couples stretching and bending.
[[nodiscard]] JointElement make_joint_element(const Sheet& sheet, CurvatureBuilder& curvatures,
                                              const std::vector<Index>& cluster, const JointStiffness& stiffness);

/// Four points that move as one rigid body: an origin, and one along each axis at the same distance.
struct RigidFrame {
  std::array<Index, 4> points;
  std::array<Vec3, 4> start;  ///< [m]
};
/// Springs between the slopes of free sides of one triangle and a rigid body that holds the sides: psi_s is the turn of g_s
/// against the body, and theta = 0. For small rotations that is a clamped edge. Throws as make_joint_element().
[[nodiscard]] JointElement make_rigid_slopes(const Sheet& sheet, CurvatureBuilder& curvatures, Index triangle,
                                             const std::vector<int>& sides, const RigidFrame& frame);

/// Free sides of a triangle that hinges hold against the ground.
struct GroundedSides {
  std::vector<int> sides;
  std::vector<double> stiffness;  ///< k [N]
  std::vector<Index> joints;      ///< their numbers for JointTerm::set_fold()
};
/// The same with the ground, which stays, and springs k l. Throws as make_joint_element().
[[nodiscard]] JointElement make_grounded_slopes(const Sheet& sheet, CurvatureBuilder& curvatures, Index triangle,
                                                const GroundedSides& grounded);

class JointTerm {
 public:
  /// `local`: the points in local numbering, in their order.
  void add(JointElement element, std::vector<Index> local, bool owned);

  [[nodiscard]] Index size() const { return static_cast<Index>(items_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return items_[e].local.data(); }
  [[nodiscard]] int stencil_size(Index e) const { return static_cast<int>(items_[e].local.size()); }
  [[nodiscard]] bool owned(Index e) const { return items_[e].owned; }
  [[nodiscard]] const JointElement& element(Index e) const { return items_[e].of; }
  /// psi [rad].
  [[nodiscard]] Eigen::VectorXd angles(Index e, const Configuration& c) const;
  /// Triangles at the joints, each once.
  [[nodiscard]] std::vector<Index> triangles() const;
  /// Natural curvature of one of them [1/m].
  void set_natural(Index triangle, const Vec3& curvature);
  /// Whether a joint of the mesh is among those here; its phi [rad].
  [[nodiscard]] bool has(Index joint) const { return at_joint_.count(joint) > 0; }
  void set_fold(Index joint, double angle);
  /// Squared size of the moments that hold the owned ones against their phi [N^2 m^2].
  [[nodiscard]] double squared_fold_moment() const;

  [[nodiscard]] double energy(Index e, const Configuration& c) const;
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const Eigen::MatrixX3d forces = this->forces(e, c);
    for (int i = 0; i < stencil_size(e); ++i) emit(i, Vec3(forces.row(i)));
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const Eigen::MatrixXd blocks = tangent(e, c);
    for (int i = 0; i < stencil_size(e); ++i)
      for (int j = 0; j < stencil_size(e); ++j) emit(i, j, Mat3(blocks.block<3, 3>(3 * i, 3 * j)));
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    for (int i = 0; i < stencil_size(e); ++i)
      for (int j = 0; j < stencil_size(e); ++j) emit(i, j);
  }

 private:
  struct Item {
    JointElement of;
    std::vector<Index> local;
    bool owned;
    Eigen::VectorXd natural;  ///< psi of natural curvatures
    Eigen::VectorXd folds;    ///< and of phi
  };
  [[nodiscard]] static EdgePoints points_of(const JointElement::Angle& a, const Eigen::MatrixX3d& z);
  [[nodiscard]] Eigen::MatrixX3d vectors(Index e, const Configuration& c) const;
  [[nodiscard]] Eigen::VectorXd angles_of(Index e, const Eigen::MatrixX3d& z) const;
  [[nodiscard]] Eigen::MatrixX3d forces(Index e, const Configuration& c) const;
  [[nodiscard]] Eigen::MatrixXd tangent(Index e, const Configuration& c) const;

  std::vector<Item> items_;
  std::map<Index, std::vector<std::pair<Index, Eigen::Index>>> angles_of_,
      at_joint_;  ///< element and angle, by triangle, joint
};

}  // namespace voile::energy
