#include "model.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/mpi.hpp"
#include "contact.hpp"
#include "energy/loads.hpp"
#include "energy/sheet.hpp"
#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

const std::vector<Support>& with_followers(ModelInput& input) {
  for (const Attachment& attachment : input.attachments)
    for (const std::string& group : attachment.groups) {
      if (!attachment.hard) continue;
      Support held;
      held.group = group;
      held.kind = Support::Kind::hinged;
      held.follows = true;
      input.supports.push_back(held);
    }
  return input.supports;
}

Model::Model(MPI_Comm comm, const mesh::SurfaceMesh& mesh, ModelInput input)
    : on_(std::make_unique<Discretisation>(
          comm, mesh, std::move(input.materials), with_followers(input),
          Discretisation::Couplings{input.springs, input.natural.hinges, input.natural.temperatures}, input.element,
          Seams{std::move(input.seams), input.sewing.seams}, input.rigid, input.periodic)),
      conditions_(std::make_unique<BoundaryConditions>(*on_, std::move(input.supports), input.loads, input.masses,
                                                       input.motion_by_load, std::move(input.rigid), input.periodic)) {
  if (input.contact.active)
    mpi::on_all(comm, [&] { contact_ = std::make_unique<Contact>(dofs(), std::move(input.contact)); });
  potential_ = std::make_unique<Potential>(
      *on_, *conditions_, contact_.get(),
      PotentialInput{std::move(input.masses), std::move(input.springs), std::move(input.sewing),
                     std::move(input.attachments), std::move(input.natural)});
  tangent_ = Tangent(*on_, potential_->constant().base());
  work_ = dofs().create_vector();
  for (auto* v : {&previous_u_, &previous_x_, &force_})
    v->assign(static_cast<std::size_t>(dofs().local().count()), Vec3::Zero());
  const PetscBool symmetric = conditions_->symmetric() ? PETSC_TRUE : PETSC_FALSE;
  VOILE_PETSC(MatSetOption(tangent_.matrix(), MAT_SYMMETRIC, symmetric));
  VOILE_PETSC(MatSetOption(tangent_.matrix(), MAT_SYMMETRY_ETERNAL, symmetric));
}

Model::~Model() = default;

void Model::set_time(double time) {
  if (contact_) contact_->set_time(time);
  if (held_still_) return;
  conditions_->set_time(time);
  potential_->set_time(time);
}

void Model::hold_still(bool still) {
  held_still_ = still;
  if (contact_) contact_->scene().hold_obstacles(still);
}

void Model::unbalanced_force(Vec a, Vec f) {
  const energy::Configuration c = potential_->configuration(a);
  potential_->force(c, a, f);
  if (contact_) {
    VOILE_PETSC(VecCopy(f, work_));
    const double pressed = contact_->add_gradient(a, f);
    VOILE_PETSC(VecAXPY(work_, -1.0, f));
    VOILE_PETSC(VecNorm(work_, NORM_2, &contact_force_));
    contact_force_ = std::max(contact_force_, pressed);  // obstacles on both sides press against each other
  }
  // Applied forces collect in work_, so that their size is known.
  conditions_->applied_forces(c, force_, work_);
  VOILE_PETSC(VecAXPY(f, -1.0, work_));
}

void Model::follower_forces(Vec a, Vec f) {
  VOILE_PETSC(VecZeroEntries(f));
  conditions_->add_followers(potential_->configuration(a), force_, f);
  VOILE_PETSC(VecScale(f, -1.0));
}

void Model::applied_forces(Vec a, Vec f) {
  conditions_->applied_forces(potential_->configuration(a), force_, f);
}

void Model::residual(Vec a, Vec r) {
  const petsc::EventScope scope(petsc::events().residual);
  unbalanced_force(a, r);
  double applied = 0.0, reaction = 0.0;
  VOILE_PETSC(VecNorm(work_, NORM_2, &applied));
  {
    const petsc::WriteArray out(r);
    for (PetscInt i : dofs().fixed()) reaction += out[i] * out[i];
    conditions_->write_off(petsc::ReadArray(a), out);
  }
  force_scale_ =
      std::max({applied, std::sqrt(mpi::sum(comm(), reaction)), potential_->natural_force(), contact_force_});
}

TriangleFields Model::triangle_fields(Vec a) {
  return potential_->triangle_fields(a, conditions_->edge_bends());
}

double Model::edge_energy() const {
  std::map<Index, Vec3> bends;
  for (const energy::EdgeBend& bend : conditions_->edge_bends())
    bends.try_emplace(bend.triangle, Vec3::Zero()).first->second += bend.curvature;
  double sum = 0.0;
  for (const auto& [t, kappa] : bends)
    sum += 0.5 * on_->mesh().area(t) * kappa.dot(on_->element_sheet().material(t).bending * kappa);
  return mpi::sum(comm(), sum);
}

double Model::energy(Vec a) {
  const petsc::EventScope scope(petsc::events().energy);
  const energy::Configuration c = potential_->configuration(a);
  const Energies e = potential_->energies(c, a, true);
  const double sheet = e.membrane + e.bending + e.springs + conditions_->potential(c, a);
  return contact_ ? sheet + contact_->energy(a) : sheet;
}

void Model::assemble_tangent(Vec a, const TangentRequest& request) {
  const petsc::EventScope scope(petsc::events().tangent);
  BlockMatrix& tangent = tangent_.blocks();
  const ConstantMatrices& constant = potential_->constant();
  const BlockMatrix& base = constant.base();
  if (contact_)
    if (BlockPattern pattern; contact_->extend_pattern(a, tangent, base.pattern(), pattern))
      tangent_.extend(base, std::move(pattern));
  // The points of rigid bodies turn with them from the state that comes last: of stresses alone from x_k.
  const bool stress_alone = request.kind == energy::Tangent::stress_alone;
  if (request.previous && !stress_alone) dofs().update_points(request.previous, previous_u_, previous_x_);
  energy::Configuration c = potential_->configuration(a);
  if (stress_alone) dofs().update_points(request.previous, previous_u_, previous_x_);
  c.tangent = request.kind;
  if (request.previous) c.previous = previous_x_.data(), c.previous_u = previous_u_.data();
  const BlockMatrix::Values values = tangent.open();
  const int pattern = tangent_.pattern_version();
  potential_->write_tangent(c, tangent, pattern, values, request.bending);
  if (constant.has_damping() && request.damping > 0.0) constant.add_damping(tangent, values, request.damping);
  if (request.loads)
    conditions_->add_blocks(c, tangent, pattern, values, tangent_.change());
  else
    tangent_.change().clear();
  if (!dofs().motions().empty() && request.loads)
    conditions_->add_body_blocks(c, potential_->point_forces({c.x, c.u}), tangent, values);
  else if (!dofs().motions().empty())
    conditions_->add_free_body_blocks(tangent, values);
  if (request.extra) request.extra->add_blocks(c, dofs(), tangent, pattern, values);
  if (request.mass > 0.0 && request.mass_matrix)
    tangent.add_values_from(*request.mass_matrix, request.mass);
  else if (request.mass > 0.0)
    add_lumped_mass(request, values);
  if (contact_) contact_->add_blocks(tangent, values, !request.exact_contact);
  if (!conditions_->has_prescribed()) return tangent_.close(values, nullptr, nullptr);
  VOILE_PETSC(VecZeroEntries(work_));
  conditions_->write_off(petsc::ReadArray(a), petsc::WriteArray(work_));
  tangent_.close(values, work_, conditions_->prescribed());
}

/// At the carriers of rigid bodies the lumped mass has only its size.
void Model::add_lumped_mass(const TangentRequest& request, const BlockMatrix::Values& values) {
  const ConstantMatrices& constant = potential_->constant();
  tangent_.add_mass(values, request.masses ? request.masses : constant.mass(), request.mass);
  if (dofs().motions().empty() || request.masses) return;
  const std::vector<RigidMotion::Row> lumped = dofs().body_rows(constant.mass());
  for (std::size_t b = 0; b < lumped.size(); ++b) {
    RigidMotion::Block m = dofs().motions()[b].mass(constant.body_mass()[b]);
    m.diagonal() -= lumped[b];
    dofs().add_unknowns_block(b, request.mass * m, tangent_.blocks(), values);
  }
}

void Model::load_direction(Vec a, Vec f) {
  conditions_->load_direction(potential_->configuration(a), force_, work_, f);
  potential_->add_load_direction(a, f);
  if (conditions_->has_prescribed()) VOILE_PETSC(VecAXPY(f, -1.0, tangent_.load_coupling()));
  const petsc::ReadArray prescribed(conditions_->prescribed());
  const petsc::WriteArray out(f);
  for (PetscInt i : dofs().fixed()) out[i] = prescribed[i];
}

std::vector<double> Model::couplings() const {
  std::vector<double> pairs;
  const BlockPattern &now = tangent_.blocks().pattern(), &base = potential_->constant().base().pattern();
  const std::vector<Index>& vertex_of = dofs().partition().vertex_of;
  const Index first = dofs().first_row();
  for (std::size_t r = 0; r < now.size() && &now != &base; ++r)
    for (const Index column : now[r])
      if (!std::binary_search(base[r].begin(), base[r].end(), column))
        pairs.insert(pairs.end(), {static_cast<double>(vertex_of[first + static_cast<Index>(r)]),
                                   static_cast<double>(vertex_of[column])});
  return mpi::gather_to_root(comm(), pairs);
}

void Model::couple(std::vector<double> pairs) {
  mpi::broadcast(comm(), pairs);
  if (pairs.empty()) return;
  for (const double vertex : pairs)
    if (!(vertex >= 0.0 && vertex < static_cast<double>(dofs().mesh().vertex_count())))
      throw InternalError("couplings of another mesh");
  const BlockMatrix& base = potential_->constant().base();
  BlockPattern pattern = base.pattern();
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
    const Index row = on_->owned(static_cast<Index>(pairs[i]));
    if (row != no_index) pattern[row].push_back(dofs().partition().row_of[static_cast<Index>(pairs[i + 1])]);
  }
  for (auto& row : pattern) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  tangent_.extend(base, std::move(pattern));
}

Energies energies(Model& model, Vec a, bool with_contact) {
  const petsc::EventScope scope(petsc::events().energy);
  const energy::Configuration c = model.potential().configuration(a);
  Energies e = model.potential().energies(c, a, false);
  e.external = model.conditions().potential(c, a);
  if (model.contact() && with_contact) e.contact = model.contact()->energy(a, contact::ContactSet::normal);
  return e;
}

}  // namespace voile::system
