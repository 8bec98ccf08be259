// Supports that move, and clamps that turn.
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
#include "voile/system/model.hpp"

namespace voile::system {

void Model::set_load_factor(double factor) {
  load_factor_ = factor;
  followers_.kernel.set_factor(energy::FollowerTerm::load_factor, factor);
  if (motion_by_load_) move_supports(factor);
}

void Model::set_time(double time) {
  if (contact_) contact_->set_time(time);
  if (!timed_.empty()) VOILE_PETSC(VecCopy(always_, constant_));
  for (const TimedLoad& load : timed_) {
    const double factor = load.history(time);
    VOILE_PETSC(VecAXPY(constant_, factor, load.force));
    followers_.kernel.set_factor(load.factor, factor);
  }
  move_supports(time);
}

void Model::move_supports(double time) {
  turn_clamps(time);
  if (movers_.empty()) return;
  const petsc::WriteArray motion(motion_);
  for (const Mover& m : movers_) {
    const LocalPoints& local = dofs_->local();
    const Vec3 u = supports_[static_cast<std::size_t>(m.support)].motion(local.start[m.local], time);
    const Vec3 own = dofs_->to_own(local.point_of[m.local], u);
    for (int k = 0; k < 3; ++k) motion[3 * m.local + k] = own[k];
  }
}

void Model::turn_clamps(double time) {
  if (!turns_) return;
  std::vector<Mat3> now = turns_now_;
  for (std::size_t i = 0; i < supports_.size(); ++i)
    if (supports_[i].rotation) now[i] = supports_[i].rotation(time);
  if (now == turns_now_) return;
  turns_now_ = now;
  dofs_->turn_mirrors(now);
  assemble_turning();
}

void Model::assemble_turning() {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  const BlockMatrix::Values values = bending_.open();
  bending_.copy_values_from(steady_bending_);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  double twice = 0.0;
  for (const TurningElement& e : turning_)
    for (std::size_t i = 0; i < e.points.size(); ++i)
      for (std::size_t j = 0; j < e.points.size(); ++j) {
        const double k = e.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        add_block(*dofs_, bending_, e.points[i], e.points[j], k * Mat3::Identity(), values);
        const Vec3 force = k * dofs_->offset(e.points[j]);
        force_[e.points[i]] += force;
        if (e.owned) twice += force.dot(dofs_->offset(e.points[i]));
      }
  for (const TurningElement& e : turning_)
    for (Eigen::Index i = 0; i < e.start_force.rows(); ++i) {
      const Index p = e.points[static_cast<std::size_t>(i)];
      const Vec3 force = e.start_force.row(i).transpose();
      force_[p] += force;
      if (e.owned) twice += 2.0 * force.dot(dofs_->offset(p));
    }
  bending_.close();
  VOILE_PETSC(VecCopy(steady_force_, bending_force_));
  dofs_->add_forces(force_, bending_force_);
  bending_offset_ = steady_offset_ + mpi::sum(comm(), twice);
  count_energy_from(reference_);
}

}  // namespace voile::system
