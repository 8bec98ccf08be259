// What remeshing keeps of a motion: momenta and energies, as the mass matrix of the case has them.
#include <cmath>

#include "adapt/transfer.hpp"
#include "base/mpi.hpp"
#include "new_mesh.hpp"
#include "remesher.hpp"
#include "setup/mesh_transfer.hpp"
#include "transfer.hpp"

namespace voile::remesh {

namespace {

/// Per vertex, on rank 0. Collective.
std::vector<double> masses(const system::Model& model) {
  const std::vector<double> all = model.dofs().gather(model.potential().constant().mass());
  std::vector<double> mass;
  for (std::size_t i = 0; i < all.size(); i += 3) mass.push_back(all[i]);
  return mass;
}

/// What masses at the vertices have beyond the consistent mass of linear triangles: kinetic energy [J], angular momentum
/// [kg m^2/s]. On rank 0.
struct Excess {
  double kinetic = 0.0;
  Vec3 angular = Vec3::Zero();
};
Excess excess_of_lumping(const system::Model& model, const std::vector<Vec3>& places,
                         const std::vector<Vec3>& velocity) {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  Excess excess;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Triangle& v = mesh.triangles()[t];
    const double mass = model.discretisation().sheet().material(t).areal_density * mesh.area(t);
    for (int s = 0; s < 3; ++s) {
      const Vec3 faster = velocity[v[s]] - velocity[v[(s + 1) % 3]];
      excess.kinetic += mass / 24.0 * faster.squaredNorm();
      excess.angular += mass / 12.0 * (places[v[s]] - places[v[(s + 1) % 3]]).cross(faster);
    }
  }
  return excess;
}

/// Where vertices are that have moved by u.
std::vector<Vec3> moved(const mesh::SurfaceMesh& mesh, std::vector<Vec3> u) {
  for (std::size_t v = 0; v < u.size(); ++v) u[v] += mesh.positions()[v];
  return u;
}

}  // namespace

Ledger Remesher::ledger(Epoch& epoch) const {
  system::Model& model = epoch.model();
  const system::State& s = epoch.state();
  Ledger l;
  model.potential().count_from(s.u);  // last digits would depend on the way there, and a restart comes by another one
  l.energies = system::energies(model, s.u);
  const std::vector<double> mass = masses(model), u = model.dofs().gather(s.u),
                            v = s.v ? model.dofs().gather(s.v) : std::vector<double>{};
  mpi::on_root(model.dofs().comm(), [&] {
    for (std::size_t i = 0; i < mass.size(); ++i) {
      l.mass += mass[i];
      if (v.empty()) continue;
      const Vec3 velocity = Eigen::Map<const Vec3>(&v[3 * i]);
      const Vec3 x = model.dofs().mesh().positions()[i] + Eigen::Map<const Vec3>(&u[3 * i]);
      l.kinetic += 0.5 * mass[i] * velocity.squaredNorm();
      l.momentum += mass[i] * velocity;
      l.angular += mass[i] * x.cross(velocity);
    }
    if (!is_consistent() || v.empty()) return;
    const Excess excess = excess_of_lumping(model, moved(model.dofs().mesh(), as_points(u)), as_points(v));
    l.kinetic -= excess.kinetic;
    l.angular -= excess.angular;
  });
  return l;
}

bool Remesher::is_consistent() const {
  return stage_.c.dynamics.mass == system::Mass::consistent;
}

/// Of a motion with the mass of the case, on rank 0.
adapt::Momentum Remesher::momentum(const system::Model& model, const adapt::Motion& motion) const {
  adapt::Momentum m = adapt::momentum(motion);
  if (is_consistent()) m.angular -= excess_of_lumping(model, motion.places, motion.velocity).angular;
  return m;
}

/// Momentum and kinetic energy become `wanted` and `energy`, this one as far as `velocity_change` lets it. On rank 0. Sets `velocity_factor_`.
void Remesher::keep(const system::Model& model, const adapt::Motion& motion, const std::vector<char>& held,
                    const adapt::Momentum& wanted, double energy, std::vector<Vec3>& velocity) {
  const std::vector<double>& mass = motion.mass;
  const std::vector<Vec3>& places = motion.places;
  const auto of = [&](const std::vector<Vec3>& v) { return momentum(model, {mass, places, v}); };
  // Corrections are those of masses at the vertices: with consistent ones a part is left to the next pass.
  const int passes = is_consistent() ? 8 : 1;
  velocity_factor_ = 1.0;
  for (int pass = 0; pass < passes; ++pass) {
    adapt::conserve_momentum(wanted, of, mass, places, held, velocity);
    double kinetic = is_consistent() ? -excess_of_lumping(model, places, velocity).kinetic : 0.0;
    for (std::size_t v = 0; v < velocity.size(); ++v) kinetic += 0.5 * mass[v] * velocity[v].squaredNorm();
    const double missing = energy - kinetic, bound = 1.0 + std::copysign(keys_.velocity_change, missing);
    const double most = std::abs(bound / velocity_factor_ - 1.0);
    velocity_factor_ *= adapt::add_kinetic_energy(mass, places, held, {missing, most}, velocity);
  }
}

/// Puts the momentum of the old state into the velocities of the new one, and the energy that relaxation has set free, as
/// far as small changes of velocity do. Likewise its rate into accelerations, from which the next steps would draw it. Collective.
void Remesher::keep_momentum(Epoch& old_epoch, Epoch& fresh, const Ledger& before) {
  const auto gathered = [](Epoch& e, Vec v) { return as_points(e.model().dofs().gather(v)); };
  const std::vector<double> old_mass = masses(old_epoch.model()), mass = masses(fresh.model());
  const std::vector<Vec3> old_u = gathered(old_epoch, old_epoch.state().u), u = gathered(fresh, fresh.state().u);
  const std::vector<Vec3> old_velocity = gathered(old_epoch, old_epoch.state().v);
  const double now = ledger(fresh).stored();
  std::vector<Vec3> velocity = gathered(fresh, fresh.state().v), acceleration, old_acceleration;
  const bool accelerates = old_epoch.state().a && fresh.state().a;
  if (accelerates) {
    old_acceleration = gathered(old_epoch, old_epoch.state().a);
    acceleration = gathered(fresh, fresh.state().a);
  }
  std::vector<double> values, rates;
  mpi::on_root(fresh.model().dofs().comm(), [&] {
    const system::Dofs& dofs = fresh.model().dofs();
    std::vector<char> held(velocity.size());
    for (std::size_t v = 0; v < held.size(); ++v) held[v] = dofs.is_held(static_cast<Index>(v));
    const std::vector<Vec3> old_places = moved(old_epoch.model().dofs().mesh(), old_u), places = moved(dofs.mesh(), u);
    const adapt::Momentum wanted = momentum(old_epoch.model(), {old_mass, old_places, old_velocity});
    keep(fresh.model(), {mass, places, velocity}, held, wanted, before.total() - now, velocity);
    values = as_values(velocity);
    if (!accelerates) return;
    adapt::conserve_momentum({old_mass, old_places, old_acceleration}, mass, places, held, acceleration);
    rates = as_values(acceleration);
  });
  fresh.model().dofs().scatter(values, fresh.state().v);
  if (accelerates) fresh.model().dofs().scatter(rates, fresh.state().a);
}

}  // namespace voile::remesh
