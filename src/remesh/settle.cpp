// How a state comes to rest on a new mesh, and what that does to its energy.
#include <algorithm>
#include <cmath>

#include "adapt/transfer.hpp"
#include "base/mpi.hpp"
#include "new_mesh.hpp"
#include "remesher.hpp"
#include "solve/relaxation.hpp"
#include "system/contact.hpp"

namespace voile::remesh {

namespace {

/// Relaxations of a drape whose energy has risen, each over a longer time than the one before.
constexpr int most_relaxations = 8;
constexpr double longer = 3.0;

/// Vertices with only old triangles around them and around their neighbours; the same on every rank. `same` on rank 0.
std::vector<char> far_from_change(const mesh::SurfaceMesh& mesh, std::vector<Index> same, MPI_Comm comm) {
  mpi::broadcast(comm, same);
  const auto vertices = static_cast<std::size_t>(mesh.vertex_count());
  std::vector<char> stays(vertices, 1), inner(vertices, 1);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    if (same[t] == no_index)
      for (Index v : mesh.triangles()[t]) stays[v] = 0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (Index v : mesh.triangles()[t])
      for (Index w : mesh.triangles()[t]) inner[v] = static_cast<char>(inner[v] && stays[w]);
  return inner;
}

}  // namespace

/// Energies that are round-off beside what the sheet could store.
double Remesher::negligible_energy(const Epoch& epoch) {
  constexpr double strain = 1e-5;
  double stiffness = 0.0;
  const system::Discretisation& on = epoch.model().discretisation();
  for (const energy::Material& m : on.materials()) stiffness = std::max(stiffness, m.membrane.trace());
  return 0.5 * stiffness * strain * strain * on.mean_area() * on.mesh().triangle_count();
}

/// Relative. In equilibrium it is the potential that counts: under the same loads a softer mesh deflects more and stores
/// more. The same on every rank. Collective.
double Remesher::energy_change(const Ledger& before, const Ledger& after, Epoch& fresh) const {
  const double size = std::max({std::abs(before.total()), std::abs(after.total()), negligible_energy(fresh)});
  const bool moves = stage_.c.analysis == input::Analysis::dynamic;
  const double loads = moves ? 0.0 : after.energies.external - before.energies.external;
  std::vector<double> change{(after.total() - before.total() + loads) / size};
  mpi::broadcast(fresh.model().dofs().comm(), change);
  return change[0];
}

/// By how much internal, contact and applied forces are out of balance on the old mesh, per mass, on the new one: what
/// accelerates the sheet there. Friction is left out, which begins anew. Collective.
petsc::VecHandle Remesher::inertia_force(Epoch& old_epoch, Epoch& fresh, const NewMesh& made) {
  system::Model& model = old_epoch.model();
  const petsc::VecHandle r = model.dofs().create_vector();
  Vec u = old_epoch.state().u;
  model.potential().start_step(u, 0.0);
  // Without slip there is no friction. Taking it off again would leave its round-off, which a restart does not have.
  if (model.contact()) model.contact()->start_step(u, 1.0);
  model.residual(u, r);
  model.dofs().clear_fixed(r);
  VOILE_PETSC(VecPointwiseDivide(r, r, model.potential().constant().mass()));
  std::vector<double> values = model.dofs().gather(r);
  mpi::on_root(model.dofs().comm(), [&] {
    values =
        as_values(adapt::transfer(model.dofs().mesh(), made.from, as_points(values), adapt::Interpolation::linear));
  });
  petsc::VecHandle force = fresh.model().dofs().create_vector();
  fresh.model().dofs().scatter(values, force);
  VOILE_PETSC(VecPointwiseMult(force, force, fresh.model().potential().constant().mass()));
  return force;
}

/// Takes the noise out of the membrane. A motion keeps what is stored away from new triangles, and its momentum; a drape
/// goes on until its energy is not above the old one, since what is left would lead the search elsewhere. Returns the
/// change of energy. Collective.
double Remesher::settle(Epoch& old_epoch, Epoch& fresh, const Ledger& before, const NewMesh& made) {
  const bool moves = fresh.state().v, drapes = stage_.c.analysis == input::Analysis::drape;
  solve::RelaxationOptions options{solve::relaxation_time(fresh.model()), keys_.relaxation_steps};
  petsc::VecHandle inertia;
  if (moves) {
    options.stays = far_from_change(fresh.model().dofs().mesh(), made.from.same_triangle, fresh.model().dofs().comm());
    inertia = inertia_force(old_epoch, fresh, made);
    options.force = inertia;
  }
  for (int k = 0; k < most_relaxations; ++k, options.tau *= longer) {
    if (keys_.relaxation_steps > 0) (void)solve::relax(fresh.model(), fresh.state().u, options);
    if (!drapes || keys_.relaxation_steps == 0 || energy_change(before, ledger(fresh), fresh) <= 0.0) break;
  }
  if (moves) keep_momentum(old_epoch, fresh, before);
  return energy_change(before, ledger(fresh), fresh);
}

}  // namespace voile::remesh
