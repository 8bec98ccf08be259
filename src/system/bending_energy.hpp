// The quadratic part of the potential: bending with a constant stiffness, and springs to the ground.
//
// Symbols   K_b   constant stiffness (constant_matrices.hpp), the springs to the ground among it                 [N/m]
//           f_b   constant force at a = 0: where the start is not the rest shape (bending.hpp), and of clamps that
//                 turn                                                                                             [N]
//           E_0   energy at a = 0                                                                                  [J]
//   E(a) = 1/2 a.K_b a + f_b.a + E_0,   counted from a reference state a_0 by
//   E(a) = E(a_0) + 1/2 (K_b (a + a_0) + 2 f_b).(a - a_0)
// Clamps that turn: Q(t) rotation of a clamp;  R_0, R(t) = Q R_0 Q^T reflection of its mirror points, at the start and now;
// A, f apex and foot of a mirror point (patch.hpp), at the start A - f = p [m];  C(t) displacements of all points of an
// element from those of vertices;  k its stiffness;  f_s forces of its points where the start is bent [N].
//   x_g = f + R (x_A - f)   gives   u_g = u_f + R (u_A - u_f) + d,   d = (R - R_0) p
// so that the bending energy 1/2 (C a + d).k (C a + d) + f_s.(C a + d) of an element with such a point has the stiffness
// C^T k C, which changes with time, and the force C^T (k d + f_s). If everything turns as a rigid body, x_g is at Q X_g,
// without energy.
// Theory: docs/theory/curvature.md (1), docs/theory/edge-slopes.md, clamped edges.
#pragma once

#include <vector>

#include "base/petsc.hpp"
#include "base/types.hpp"
#include "block_matrix.hpp"
#include "conditions.hpp"

namespace voile::energy {
struct BendingElement;
struct CurvatureOperator;
}  // namespace voile::energy

namespace voile::system {

class ConstantMatrices;
class Discretisation;

class BendingEnergy {
 public:
  /// Assembles the stiffness, and the damping of materials that have some, into `constant`, whose pattern must have room
  /// for them. `curvatures`: of on.elements(). Both references must outlive it. Collective. Throws UserError.
  BendingEnergy(Discretisation& on, ConstantMatrices& constant,
                const std::vector<energy::CurvatureOperator>& curvatures, const std::vector<Spring>& springs);

  /// f = K_b a + f_b. Collective. [N]
  void force(Vec a, Vec f) const;
  /// From now on energies are found by the change since a: K_b a sums stiff forces that nearly cancel, and near a the
  /// differences of energies would be lost in its round-off. Collective.
  void count_from(Vec a);
  /// E(a), the springs to the ground among it. Collective. [J]
  [[nodiscard]] double energy(Vec a) const;
  /// The springs to the ground alone. Collective. [J]
  [[nodiscard]] double ground_energy(Vec a) const;
  /// y = K_b x without the springs to the ground, which nothing damps [N/m]. Collective.
  void multiply_sheet(Vec x, Vec y) const;
  /// Takes `factor` times the springs to the ground from the open values of a tangent. Not collective.
  void take_springs_from(const BlockMatrix& tangent, const BlockMatrix::Values& values, double factor) const;
  /// Whether clamps turn in this model.
  [[nodiscard]] bool turns() const { return turns_; }
  /// Turns clamps: the rotation of each support, by number. Assembles again if that changes anything. Collective.
  void turn(const std::vector<Mat3>& rotations);

 private:
  void assemble(const std::vector<energy::CurvatureOperator>& curvatures, const std::vector<Spring>& springs);
  void take_start(const energy::BendingElement& element, bool owned);
  void add_springs(const std::vector<Spring>& springs, const BlockMatrix::Values& values);
  void assemble_turning();

  Discretisation* on_;
  ConstantMatrices* constant_;
  petsc::VecHandle reference_, force_;  ///< a_0 and f_b
  mutable petsc::VecHandle product_, sum_;
  double reference_energy_ = 0.0, offset_ = 0.0;  ///< twice E(a_0) and E_0 [J]
  struct TurningElement {  ///< bending of a triangle whose stencil has a mirror point that turns; local points
    std::vector<Index> points;
    Eigen::MatrixXd stiffness;
    Eigen::MatrixX3d start_force;  ///< empty where the start is bent as the rest shape is
    bool owned;
  };
  std::vector<TurningElement> turning_;
  bool turns_ = false;           ///< on some rank there are such elements
  std::vector<Mat3> turns_now_;  ///< rotation of each support
  BlockMatrix steady_;           ///< K_b without them
  petsc::VecHandle steady_force_;
  double steady_offset_ = 0.0;
  std::vector<Vec3> forces_;  ///< of the local points [N]
  struct NodalSpring {
    Index vertex;    ///< owned, local
    Mat3 stiffness;  ///< in the vertex's own axes [N/m]
  };
  std::vector<NodalSpring> springs_;
  bool any_spring_ = false;
};

}  // namespace voile::system
