#include "support_forces.hpp"

#include <utility>
#include <vector>

#include "base/mpi.hpp"
#include "state_change.hpp"

namespace voile::record {

namespace {

system::DynamicsOptions without_air(system::DynamicsOptions options, const solve::MassMatrix& mass) {
  options.mass = mass.blocks() ? system::Mass::consistent : system::Mass::lumped;
  options.drag = {};
  return options;
}

}  // namespace

SupportForces::SupportForces(system::Model& model, Vec a, const system::DynamicsOptions& options,
                             const solve::MassMatrix& mass)
    : model_(model), a_(a), dynamics_(model, without_air(options, mass)) {}

petsc::VecHandle SupportForces::held(petsc::VecHandle f) const {
  model_.dofs().clear_free(f);
  return f;
}

SupportForces::Rows SupportForces::of(Vec q) {
  const system::Dofs& dofs = model_.dofs();
  Rows rows{dofs.create_vector(), dofs.create_vector(), dofs.create_vector()};
  StateChange change(model_, a_, q);
  change.force(rows.stiffness);
  dynamics_.start_step(a_, a_, 1.0);  // of one second: rates are what a step adds
  change.force(rows.damping);
  model_.potential().start_step(a_, 0.0, 0.0);
  VOILE_PETSC(VecAXPY(rows.damping, -1.0, rows.stiffness));
  dynamics_.add_damping(q, rows.damping);
  (void)model_.potential().configuration(a_);  // where rigid bodies have their mass
  dynamics_.add_coupled_inertia(q, dofs.create_vector(), rows.inertia);
  VOILE_PETSC(VecAXPY(rows.damping, dynamics_.options().mass_damping, rows.inertia));
  return {held(std::move(rows.stiffness)), held(std::move(rows.damping)), held(std::move(rows.inertia))};
}

petsc::VecHandle SupportForces::of_loads() {
  petsc::VecHandle f = model_.dofs().create_vector();
  StateChange(model_, a_).force(f);
  return held(std::move(f));
}

petsc::VecHandle SupportForces::of_base(const Vec3& acceleration) {
  const system::Dofs& dofs = model_.dofs();
  petsc::VecHandle f = dofs.create_vector();
  std::vector<double> everywhere;
  mpi::on_root(dofs.comm(), [&] {
    for (Index v = 0; v < dofs.mesh().vertex_count(); ++v)
      everywhere.insert(everywhere.end(), acceleration.begin(), acceleration.end());
  });
  dofs.scatter(everywhere, f);
  VOILE_PETSC(VecPointwiseMult(f, f, model_.potential().constant().mass()));
  return held(std::move(f));
}

}  // namespace voile::record
