#include "weld_settle.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mesh/weld.hpp"
#include "solve/relaxation.hpp"
#include "system/contact.hpp"
#include "system/energy_account.hpp"

namespace voile::simulation {

namespace {

/// Rows of cells beside a seam that unfold, and those of them whose forces know the fold.
constexpr int free_rows = 6, folded_rows = 2;
/// Relaxations, each over a longer time than the one before, until one frees less than this fraction of all.
constexpr int most_unfoldings = 8, iterations = 4;
constexpr double each_longer = 1.5, least_fraction = 0.05;

/// Whether a vertex is more than so many rows from the seams.
std::vector<char> beyond(const mesh::SurfaceMesh& mesh, const std::vector<std::string>& seams, int rows) {
  std::vector<char> far(static_cast<std::size_t>(mesh.vertex_count()), 1);
  for (const std::string& seam : seams)
    for (const Index v : mesh.group(mesh::seam_group(seam), 1).vertices) far[v] = 0;
  for (int k = 0; k < rows; ++k) {
    std::vector<char> farther = far;
    for (const mesh::Triangle& t : mesh.triangles())
      if (!far[t[0]] || !far[t[1]] || !far[t[2]])
        for (const Index v : t) farther[v] = 0;
    far = std::move(farther);
  }
  return far;
}

/// Forces out of balance beyond the fold, which go into the motion to come: only the fold is to relax. Collective.
petsc::VecHandle forces_beyond(system::Model& model, Vec u, const std::vector<char>& far) {
  petsc::VecHandle force = model.dofs().create_vector();
  const petsc::VecHandle mask = model.dofs().create_vector();
  model.residual(u, force);
  std::vector<double> values(3 * far.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = far[i / 3] ? 1.0 : 0.0;
  model.dofs().scatter(values, mask);
  VOILE_PETSC(VecPointwiseMult(force, force, mask));
  return force;
}

}  // namespace

std::string settle_weld(Epoch& epoch, const std::vector<std::string>& seams,
                        const system::DynamicsOptions& dynamics_options) {
  if (seams.empty() || !epoch.moves() || !epoch.state().v) return "";
  epoch.prepare(remesh::Origin::stage);
  system::Model& model = epoch.model();
  system::State& state = epoch.state();
  system::Dynamics dynamics(model, dynamics_options);
  const auto balance = [&] {
    system::EnergyAccount account(dynamics);
    account.begin(state.u, state.v, nullptr, {});
    return account.balance();
  };
  const auto begin_friction = [&](double time) {
    if (model.contact())
      model.contact()->start_step(state.u, model.contact()->scene().input().options.slip_speed * time);
  };
  const system::EnergyBalance folded = balance();
  solve::RelaxationOptions options{solve::relaxation_time(model), iterations};
  begin_friction(options.tau);
  const petsc::VecHandle force = forces_beyond(model, state.u, beyond(model.dofs().mesh(), seams, folded_rows));
  options.stays = beyond(model.dofs().mesh(), seams, free_rows);
  options.force = force;
  double last = folded.stored;
  for (int k = 0; k < most_unfoldings; ++k, options.tau *= each_longer) {
    if (k > 0) begin_friction(options.tau);
    (void)solve::relax(model, state.u, options);
    const double before = std::exchange(last, balance().stored);
    if (before - last <= least_fraction * (folded.stored - last)) break;
  }
  state.a.reset();
  state.balance = folded;
  return fmt::format("t = {:.6g} s: welded seams unfold without motion: {:.3g} J stored as welded, {:.3g} J after",
                     state.time, folded.stored, last);
}

}  // namespace voile::simulation
