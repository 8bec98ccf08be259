// Nodal forces of dead loads, elements for follower loads, and supports that move.
#include "boundary_conditions.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "base/mpi.hpp"
#include "edge_moments.hpp"
#include "energy/loads.hpp"
#include "energy/sheet.hpp"
#include "gas.hpp"
#include "point_weights.hpp"
#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

using AddForce = std::function<void(Index vertex, const Vec3& force)>;

std::vector<Index> loaded_triangles(const mesh::SurfaceMesh& mesh, const Load& load) {
  if (!load.group.empty()) return mesh.group(load.group, 2).triangles;
  std::vector<Index> all(static_cast<std::size_t>(mesh.triangle_count()));
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<Index>(t);
  return all;
}

/// Force per rest area on triangle t.
Vec3 traction(const Discretisation& on, const Load& load, Index t) {
  if (load.kind == Load::Kind::pressure) return load.magnitude * on.mesh().start_normal(t);
  if (load.kind == Load::Kind::gravity) return on.sheet().material(t).areal_density * load.vector;
  return load.vector;
}

/// Of the load's distribution, at the middle of triangle t.
double factor_at(const mesh::SurfaceMesh& mesh, const Load& load, Index t) {
  if (!load.distribution) return 1.0;
  return load.distribution((mesh.start_corner(t, 0) + mesh.start_corner(t, 1) + mesh.start_corner(t, 2)) / 3.0);
}

void add_surface_load(const Discretisation& on, const Load& load, const AddForce& add) {
  for (Index t : loaded_triangles(on.mesh(), load)) {
    const Vec3 fraction = factor_at(on.mesh(), load, t) * traction(on, load, t) * on.mesh().area(t) / 3.0;
    for (Index v : on.mesh().triangles()[t]) add(v, fraction);
  }
}

void add_line_load(const mesh::SurfaceMesh& mesh, const Load& load, const AddForce& add) {
  for (const mesh::Segment& s : mesh.group(load.group, 1).segments) {
    double length = mesh.rest_length(s);
    if (load.distribution) length *= load.distribution(0.5 * (mesh.positions()[s[0]] + mesh.positions()[s[1]]));
    for (Index v : s) add(v, 0.5 * length * load.vector);
  }
}

/// Weight without mass is a mistake that a run would answer with silence.
void check_gravity(const Discretisation& on, const Load& load) {
  for (Index t : loaded_triangles(on.mesh(), load))
    if (on.sheet().material(t).areal_density > 0.0) return;
  throw UserError("[[load]] type 'gravity': no material under it has a density; give `density` in [[material]]");
}

}  // namespace

void spread(const Discretisation& on, const Load& load, const AddForce& add) {
  if (load.kind == Load::Kind::point)
    for (const Index v : on.mesh().group(load.group).places()) add(v, load.vector);
  else if (load.kind == Load::Kind::line)
    add_line_load(on.mesh(), load, add);
  else
    add_surface_load(on, load, add);
}

BoundaryConditions::BoundaryConditions(const Discretisation& on, std::vector<Support> supports,
                                       const std::vector<Load>& loads, const std::vector<PointMass>& masses,
                                       bool motion_by_load, std::vector<RigidGroup> rigid,
                                       const std::vector<PeriodicPair>& periodic)
    : on_(&on),
      rigid_(on, std::move(rigid)),
      supports_(with_differences(std::move(supports), periodic)),
      motion_by_load_(motion_by_load),
      rotations_(supports_.size(), Mat3::Identity()),
      followers_(std::make_unique<ElementTerm<energy::FollowerTerm>>()) {
  const Dofs& dofs = on.dofs();
  for (petsc::VecHandle* v : {&dead_, &constant_, &prescribed_, &motion_, &hold_}) *v = dofs.create_vector();
  const std::map<Index, VertexSupport>& supported = on.constraints().vertices;
  std::set<PetscInt> following;
  {
    const petsc::WriteArray prescribed(prescribed_);
    for (Index i = 0; i < dofs.local().owned; ++i) {
      const auto support = supported.find(dofs.local().point_of[i]);
      if (support == supported.end()) continue;
      for (int k = 0; k < 3; ++k) {
        const int mover = support->second.motion[static_cast<std::size_t>(k)];
        if (mover >= 0) movers_.push_back({i, k, mover, dofs.local().start[i]});
        if (mover >= 0 && supports_[static_cast<std::size_t>(mover)].follows) following.insert(3 * i + k);
      }
      for (int k = 0; k < 3; ++k)
        if (support->second.fixed[k]) prescribed[3 * i + k] = support->second.value[k];
    }
  }
  for (const PetscInt i : dofs.fixed())
    if (following.count(i) == 0) led_.push_back(i);
  for (const auto& [v, support] : supported) has_prescribed_ |= support.value.squaredNorm() > 0.0 || support.moves();
  has_prescribed_ |= rigid_.moves();
  mpi::on_all(dofs.comm(), [&] { build_loads(loads, masses); });
  add_differences(periodic);
  dead_on_bodies_ = rigid_.take(dead_);
  always_on_bodies_ = rigid_.take(constant_);
  for (TimedLoad& load : timed_) load.on_bodies = rigid_.take(load.force);
  for (const bool constant : {false, true}) {
    const std::vector<BodyForce> at_points = rigid_.forces(constant);
    std::vector<BodyForce>& on_bodies = constant ? always_on_bodies_ : dead_on_bodies_;
    for (std::size_t b = 0; b < at_points.size(); ++b) on_bodies[b].add(1.0, at_points[b]);
  }
  VOILE_PETSC(VecDuplicate(constant_, always_.out()));
  VOILE_PETSC(VecCopy(constant_, always_));
}

BoundaryConditions::~BoundaryConditions() = default;

void BoundaryConditions::add_blocks(const energy::Configuration& c, const BlockMatrix& tangent, int pattern,
                                    const BlockMatrix::Values& values, LowRankChange& change) {
  followers_->add_blocks(c, on_->dofs(), tangent, pattern, values);
  change.clear();
  for (const Gas& gas : gases_) gas.add_blocks(c, tangent, pattern, values, gas_scratch_, change);
}

void BoundaryConditions::set_load_factor(double factor) {
  load_factor_ = factor;
  followers_->kernel.set_factor(energy::FollowerTerm::load_factor, factor);
  for (std::size_t k = 0; k < gases_.size(); ++k)
    if (gas_factors_[k] == energy::FollowerTerm::load_factor) gases_[k].set_factor(factor);
  if (motion_by_load_) move_supports(factor);
}

void BoundaryConditions::set_time(double time) {
  if (!timed_.empty()) VOILE_PETSC(VecCopy(always_, constant_));
  for (TimedLoad& load : timed_) {
    const double factor = load.now = load.history(time);
    VOILE_PETSC(VecAXPY(constant_, factor, load.force));
    followers_->kernel.set_factor(load.factor, factor);
    for (std::size_t k = 0; k < gases_.size(); ++k)
      if (gas_factors_[k] == load.factor) gases_[k].set_factor(factor);
  }
  for (Gas& gas : gases_) gas.set_time(time);
  move_supports(time);
}

void BoundaryConditions::set_external(petsc::VecHandle force) {
  external_ = std::move(force);
  if (external_) external_on_bodies_ = rigid_.take(external_);
}

void BoundaryConditions::add_external(double factor, Vec f) const {
  if (!external_) return;
  VOILE_PETSC(VecAXPY(f, factor, external_));
  std::vector<BodyForce> on(external_on_bodies_.size());
  for (std::size_t b = 0; b < on.size(); ++b) on[b].add(factor, external_on_bodies_[b]);
  rigid_.add(on, f);
}

std::vector<BodyForce> BoundaryConditions::on_bodies() const {
  std::vector<BodyForce> all = always_on_bodies_;
  for (std::size_t b = 0; b < all.size(); ++b) {
    all[b].add(load_factor_, dead_on_bodies_[b]);
    for (const TimedLoad& load : timed_) all[b].add(load.now, load.on_bodies[b]);
    if (external_) all[b].add(1.0, external_on_bodies_[b]);
  }
  return all;
}

void BoundaryConditions::add_body_blocks(const energy::Configuration& c, std::vector<Vec3>& sheet,
                                         const BlockMatrix& tangent, const BlockMatrix::Values& values) {
  if (!rigid_.any()) return;
  followers_->add_forces(c, sheet);
  for (const Gas& gas : gases_) gas.add_forces(c, sheet);
  std::vector<BodyForce> total = on_->dofs().body_forces(sheet);
  const std::vector<BodyForce> applied = on_bodies();
  for (std::size_t b = 0; b < total.size(); ++b) total[b].add(-1.0, applied[b]);
  rigid_.add_blocks(total, load_factor_, tangent, values);
}

void BoundaryConditions::set_displacement(Index local, const Vec3& u) {
  const petsc::WriteArray motion(motion_);
  const Vec3 own = on_->dofs().to_own(on_->dofs().local().point_of[local], u);
  for (int k = 0; k < 3; ++k) motion[3 * local + k] = own[k];
}

void BoundaryConditions::enforce(Vec a) const {
  const petsc::ReadArray prescribed(prescribed_), motion(motion_), hold(hold_);
  const petsc::WriteArray values(a);
  for (PetscInt i : on_->dofs().fixed()) values[i] = load_factor_ * prescribed[i] + motion[i] + hold[i];
}

void BoundaryConditions::write_off(const petsc::ReadArray& a, const petsc::WriteArray& out) const {
  const petsc::ReadArray prescribed(prescribed_), motion(motion_), hold(hold_);
  for (PetscInt i : on_->dofs().fixed()) out[i] = a[i] - load_factor_ * prescribed[i] - motion[i] - hold[i];
}

void BoundaryConditions::add_followers(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const {
  std::fill(scratch.begin(), scratch.end(), Vec3::Zero());
  followers_->add_forces(c, scratch);
  on_->dofs().add_forces(scratch, f);
}

void BoundaryConditions::applied_forces(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const {
  VOILE_PETSC(VecZeroEntries(f));
  add_followers(c, scratch, f);
  VOILE_PETSC(VecScale(f, -1.0));
  VOILE_PETSC(VecAXPY(f, 1.0, constant_));
  VOILE_PETSC(VecAXPY(f, load_factor_, dead_));
  if (external_) VOILE_PETSC(VecAXPY(f, 1.0, external_));
  for (const Gas& gas : gases_) gas.add_force(c, scratch, f);
  if (!rigid_.any()) return;
  rigid_.add(on_bodies(), f);
  rigid_.add_moments(load_factor_, true, f);
}

double BoundaryConditions::potential(const energy::Configuration& c, Vec a) const {
  double constant = 0.0, dead = 0.0, external = 0.0, gas = 0.0;
  VOILE_PETSC(VecDot(constant_, a, &constant));
  VOILE_PETSC(VecDot(dead_, a, &dead));
  if (external_) VOILE_PETSC(VecDot(external_, a, &external));
  for (const Gas& g : gases_) gas += g.at(c).energy;
  const double bodies = rigid_.any() ? rigid_.potential(on_bodies(), load_factor_) : 0.0;
  return gas + bodies - constant - load_factor_ * dead - external;
}

void BoundaryConditions::load_direction(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec work, Vec f) {
  VOILE_PETSC(VecCopy(dead_, f));
  for (std::size_t k = 0; k < gases_.size(); ++k)
    if (gas_factors_[k] == energy::FollowerTerm::load_factor) gases_[k].add_direction(c, scratch, f);
  rigid_.add(dead_on_bodies_, f);
  rigid_.add_moments(1.0, false, f);
  if (!any_follower_) return;
  // Follower loads are linear in the load factor: a difference over one unit is exact.
  for (const double sign : {1.0, -1.0}) {
    followers_->kernel.set_factor(energy::FollowerTerm::load_factor, load_factor_ + (sign > 0.0 ? 1.0 : 0.0));
    VOILE_PETSC(VecZeroEntries(work));
    add_followers(c, scratch, work);
    VOILE_PETSC(VecAXPY(f, -sign, work));
  }
}

Vec BoundaryConditions::force_of(const Load& load) {
  if (!load.history) return load.constant ? constant_ : dead_;
  TimedLoad timed{load.history, followers_->kernel.add_factor(), on_->dofs().create_vector()};
  timed_.push_back(std::move(timed));
  return timed_.back().force;
}

void BoundaryConditions::build_loads(const std::vector<Load>& loads, const std::vector<PointMass>& masses) {
  for (const Load& load : loads) {
    const petsc::WriteArray force(force_of(load));
    const AddForce add = [&](Index v, const Vec3& f) { add_vertex_force(v, f, force); };
    if (load.kind == Load::Kind::follower_pressure || load.kind == Load::Kind::follower_moment) {
      any_follower_ = true;
      add_follower(load);
      continue;
    }
    if (load.kind == Load::Kind::gas) {
      add_gas(load);
      continue;
    }
    if (load.kind == Load::Kind::gravity) {
      if (masses.empty()) check_gravity(*on_, load);
      add_point_weights(on_->mesh(), load, masses, add);
    }
    spread(*on_, load, add);
  }
}

/// Of a load whose force_of() was called last.
int BoundaryConditions::factor_of(const Load& load) const {
  return load.history    ? timed_.back().factor
         : load.constant ? energy::FollowerTerm::constant
                         : energy::FollowerTerm::load_factor;
}

void BoundaryConditions::add_gas(const Load& load) {
  gases_.emplace_back(*on_, load);
  gas_factors_.push_back(factor_of(load));
  if (gas_factors_.back() == energy::FollowerTerm::constant) gases_.back().set_factor(1.0);
  gas_scratch_.resize(static_cast<std::size_t>(on_->dofs().local().count()));
}

void BoundaryConditions::add_follower(const Load& load) {
  const int factor = factor_of(load);
  const mesh::SurfaceMesh& mesh = on_->mesh();
  if (load.kind == Load::Kind::follower_pressure) {
    std::vector<char> loaded(static_cast<std::size_t>(mesh.triangle_count()));
    for (const Index t : loaded_triangles(mesh, load)) loaded[t] = 1;
    for (std::size_t k = 0; k < on_->elements().size(); ++k) {
      const auto& [t, corners, owned] = on_->elements()[k];
      if (!loaded[t]) continue;
      followers_->kernel.add_pressure(corners, load.magnitude * factor_at(mesh, load, t), factor, owned,
                                      on_->bulge(k, mesh.triangles()[t]));
    }
    return;
  }
  add_edge_moments(*on_, load, factor, followers_->kernel);
}

std::vector<energy::EdgeBend> BoundaryConditions::edge_bends() const {
  return followers_->kernel.edge_bends();
}

}  // namespace voile::system
