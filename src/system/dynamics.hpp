// Motion in time: inertia, damping, and loads and supports that follow the time. Theory: docs/theory/time-integration.md (1).
//
// Symbols   u, v, a   unknowns, their velocities and accelerations;  M mass;  K_b constant bending stiffness
//           lambda(t) load factor;  r static residual (model.hpp)
//   F(t, u, v, a) = M a + alpha M v + beta K_b v + C_b v + r_visc(u) + r(u, lambda(t)) + drag(v)  = 0      free
//   components
//                   u - prescribed(t)                                                            fixed components
// C_b is the sum of each material's own beta times its K_b, and its own tau adds to tau. alpha [1/s] damps with the
// mass (air), beta [s] with the constant bending stiffness. beta turns against the change of u in space axes, so it
// also brakes a bent sheet that turns as a whole. Membrane viscosity (relaxation time tau [s]) and drag are
// constant-coefficient within a step, see membrane.hpp and drag.hpp: first order in the step. With v and a affine in u
// over a step (dv/du = s_v, da/du = s_a), F is the gradient in u of the incremental potential
//   E(u) = W(u) + 1/2 a.M a/s_a + 1/2 v.(alpha M + beta K_b + C_b) v/s_v + drag power/s_v.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynamics_options.hpp"
#include "energy/term.hpp"
#include "model.hpp"
#include "state.hpp"
#include "work.hpp"

namespace voile::energy {
class DragTerm;
}  // namespace voile::energy

namespace voile::system {

/// Throws UserError if a material has no mass.
void require_mass(const Model& model);

/// Before a motion that begins at state u and this time, at the model's load factor: contact lets out what starts
/// nearer than its distance and is not at rest there (Contact::begin_settling). Collective.
void settle_contact(Model& model, Vec u, double time);

/// Of a step: prescribed motions hardly change over it.
inline constexpr double short_moment = 1e-3;

class Dynamics {
 public:
  /// The model must outlive it. Collective. Throws UserError if a material has no mass.
  Dynamics(Model& model, DynamicsOptions options);
  ~Dynamics();
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  [[nodiscard]] Model& model() const { return model_; }
  [[nodiscard]] const DynamicsOptions& options() const { return options_; }

  /// Time of all later evaluations. Collective.
  void set_time(double time);
  /// Remembers the start of a step of size dt. Collective.
  void start_step(Vec u, Vec v, double dt);
  /// Damping and drag become those of the end of a step that began so. Contact is left alone. Collective.
  void resume_step(const StepStart& start);
  /// F. Collective.
  void residual(Vec u, Vec v, Vec a, Vec f);
  /// Adds to f what damping and drag do at velocities v, on what is held too, where it is a part of the reaction. Collective. [N]
  void add_damping(Vec v, Vec f) const;
  /// Adds to f what inertia does at accelerations a and velocities v, also on what is held, whose accelerations are those of the
  /// prescribed motions; `a` is overwritten there. Collective. [N]
  void add_inertia(Vec a, Vec v, const MotionTime& at, Vec f) const;
  /// Sets velocities, and accelerations if given, of what is held to those of the prescribed motions. Collective.
  void prescribe_rates(const MotionTime& at, bool from_here, Vec v, Vec a = nullptr) const;
  /// Adds to f what free vertices that accelerate push held ones with, by the consistent mass. Collective. [N]
  void add_coupled_inertia(Vec a, Vec v, Vec f) const;
  /// E(u). Collective.
  [[nodiscard]] double energy(Vec u, Vec v, Vec a, double s_v, double s_a);
  /// Tangent dF/du at u into the model's tangent matrix. Collective.
  void assemble_tangent(Vec u, energy::Tangent kind, double s_v, double s_a);
  /// y = M x on the free components. Collective.
  void apply_mass(Vec x, Vec y) const;
  /// Relaxation time of the most viscous material, the motion's own included [s].
  [[nodiscard]] double longest_viscous_time() const;
  /// Time in force [s].
  [[nodiscard]] double time() const { return time_.value_or(0.0); }
  /// What a residual is small against: the largest of applied forces, reactions and inertia of the last residual. [N]
  [[nodiscard]] double force_scale() const { return force_scale_; }

  /// Works of the forces at (u, v, a) in a displacement [J]; positive where they take energy from the motion.
  struct Work {
    ForceWork model;
    double inertia = 0.0, damping = 0.0, drag = 0.0;
    double reactions = 0.0;  ///< of supports; positive where they give energy
  };
  /// Damping and drag also on what is held, whose supports then do that work. `loads` and `reactions`, unless null, take these forces [N].
  /// Collective.
  [[nodiscard]] Work work(Vec u, Vec v, Vec a, Vec displacement, Vec loads = nullptr, Vec reactions = nullptr);
  /// Of what is free.
  [[nodiscard]] double kinetic_energy(Vec v) const;
  /// What it has besides because held components move, at the time in force; their velocities are those of the prescribed motions,
  /// taken over dt. Collective. [J]
  [[nodiscard]] double kinetic_energy_of_held(Vec v, double dt) const;
  /// Of all vertices, in global axes; supports included. Collective.
  [[nodiscard]] Vec3 momentum(Vec v) const;
  /// About the origin of space. Collective.
  [[nodiscard]] Vec3 angular_momentum(Vec u, Vec v) const;

 private:
  void remember(Vec u, Vec v, double dt);
  void build_drag();
  void add_drag(Vec v, Vec f) const;
  void multiply_mass(Vec x, Vec y) const;  ///< of held components too
  void apply_body_mass(Vec x, Vec y) const;
  void add_gyration(Vec v, Vec f) const;
  /// Velocities of the local points instead of positions, for the drag.
  [[nodiscard]] energy::Configuration moving(Vec v) const;
  /// Whether C_b is there and is to act.
  [[nodiscard]] bool material_damping() const {
    return options_.material_damping && model_.potential().constant().has_damping();
  }

  Model& model_;
  DynamicsOptions options_;
  std::optional<BlockMatrix> consistent_;
  std::unique_ptr<ElementTerm<energy::DragTerm>> drag_;
  mutable std::vector<Vec3> velocity_, position_, force_;  ///< of the local points, for the drag
  mutable petsc::VecHandle work_, sum_;
  double force_scale_ = 0.0;
  std::optional<double> time_;  ///< in force; none before the first set_time()
};

}  // namespace voile::system
