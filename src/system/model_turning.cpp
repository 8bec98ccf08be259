// Clamps that turn.
//
// Symbols   Q(t)    rotation of a clamp;  R_0, R(t) = Q R_0 Q^T reflection of its mirror points, at the start and now
//           A, f    apex and foot of a mirror point (patch.hpp), at the start A - f = p                         [m]
//           C(t)    displacements of all points of an element from those of vertices;  k its stiffness
//           f_s     forces of its points where the start is bent (bending.hpp)                                  [N]
//   x_g = f + R (x_A - f)   gives   u_g = u_f + R (u_A - u_f) + d,   d = (R - R_0) p
// so that the bending energy 1/2 (C a + d).k (C a + d) + f_s.(C a + d) of an element with such a point has the stiffness
// C^T k C, which changes with time, and the force C^T (k d + f_s). If everything turns as a rigid body, x_g is at Q X_g, without energy.
#include <algorithm>

#include "voile/base/mpi.hpp"
#include "voile/energy/bending.hpp"
#include "voile/system/model.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

void Model::turn_clamps() {
  if (!turns_ || conditions_->rotations() == turns_now_) return;
  turns_now_ = conditions_->rotations();
  on_->turn_mirrors(turns_now_);
  assemble_turning();
}

void Model::assemble_turning() {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  BlockMatrix& bending = constant_.bending_blocks();
  const BlockMatrix::Values values = bending.open();
  bending.copy_values_from(steady_bending_);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  double twice = 0.0;
  for (const TurningElement& e : turning_)
    for (std::size_t i = 0; i < e.points.size(); ++i)
      for (std::size_t j = 0; j < e.points.size(); ++j) {
        const double k = e.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        add_block(dofs(), bending, e.points[i], e.points[j], k * Mat3::Identity(), values);
        const Vec3 force = k * dofs().offset(e.points[j]);
        force_[e.points[i]] += force;
        if (e.owned) twice += force.dot(dofs().offset(e.points[i]));
      }
  for (const TurningElement& e : turning_)
    for (Eigen::Index i = 0; i < e.start_force.rows(); ++i) {
      const Index p = e.points[static_cast<std::size_t>(i)];
      const Vec3 force = e.start_force.row(i).transpose();
      force_[p] += force;
      if (e.owned) twice += 2.0 * force.dot(dofs().offset(p));
    }
  bending.close();
  VOILE_PETSC(VecCopy(steady_force_, bending_force_));
  dofs().add_forces(force_, bending_force_);
  bending_offset_ = steady_offset_ + mpi::sum(comm(), twice);
  count_energy_from(reference_);
}

}  // namespace voile::system
