#include "voile/system/model.hpp"

#include <fmt/format.h>

#include <cmath>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/energy/anchor.hpp"
#include "voile/energy/bending.hpp"
#include "voile/energy/chord_correction.hpp"
#include "voile/energy/chord_forms.hpp"
#include "voile/energy/membrane.hpp"
#include "voile/energy/seam.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/spring.hpp"
#include "voile/mesh/patch.hpp"
#include "voile/system/contact.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

Model::Model(MPI_Comm comm, const mesh::SurfaceMesh& mesh, ModelInput input)
    : on_(std::make_unique<Discretisation>(comm, mesh, std::move(input.materials), with_followers(input), input.springs,
                                           input.element)),
      turns_now_(input.supports.size(), Mat3::Identity()) {
  const Curvatures curvatures = on_->take_curvatures();
  BlockPattern pattern;
  sewing_ = std::move(input.sewing);
  mpi::on_all(comm, [&] {
    build_terms(curvatures, input.springs);
    if (!input.attachments.empty()) anchor_term_ = &add_term<energy::AnchorTerm>(&Energies::springs);
    pattern = make_pattern(curvatures);
  });
  constant_ = ConstantMatrices(*on_, std::move(pattern), input.masses);
  tangent_ = Tangent(*on_, constant_.bending_blocks());
  for (petsc::VecHandle* v : {&work_, &sum_, &reference_, &steady_force_, &bending_force_}) *v = dofs().create_vector();
  assemble_bending(curvatures, input.springs);
  close_start();
  if (turns_) {
    steady_bending_ = constant_.bending_blocks().twin();
    (void)steady_bending_.open();
    steady_bending_.copy_values_from(constant_.bending_blocks());
    steady_bending_.close();
    assemble_turning();
  }
  conditions_ = std::make_unique<BoundaryConditions>(*on_, std::move(input.supports), input.loads, input.masses,
                                                     input.motion_by_load);
  if (input.contact.active)
    mpi::on_all(comm, [&] { contact_ = std::make_unique<Contact>(dofs(), std::move(input.contact)); });
  mpi::on_all(comm, [&] { add_attachments(std::move(input.attachments)); });
  const PetscBool symmetric = conditions_->symmetric() ? PETSC_TRUE : PETSC_FALSE;
  VOILE_PETSC(MatSetOption(constant_.bending(), MAT_SYMMETRIC, PETSC_TRUE));
  VOILE_PETSC(MatSetOption(tangent_.matrix(), MAT_SYMMETRIC, symmetric));
  VOILE_PETSC(MatSetOption(tangent_.matrix(), MAT_SYMMETRY_ETERNAL, symmetric));
}

Model::~Model() = default;

template <class Kernel>
ElementTerm<Kernel>& Model::add_term(double Energies::*part) {
  auto term = std::make_unique<ElementTerm<Kernel>>();
  ElementTerm<Kernel>& reference = *term;
  terms_.push_back({std::move(term), part});
  return reference;
}

/// Here a new term joins the potential.
void Model::build_terms(const Curvatures& curvatures, const std::vector<Spring>& springs) {
  membrane_ = &add_term<energy::MembraneTerm>(&Energies::membrane);
  membrane_->kernel = energy::MembraneTerm(on_->sheet());
  std::optional<energy::ChordForms> forms;
  if (membrane_->kernel.corrects()) forms.emplace(on_->sheet());
  auto& curved = add_term<energy::CurvedBendingTerm>(&Energies::bending);
  const std::vector<Index>& local_of = dofs().local().local_of;
  const auto to_local = [&](const auto& points, auto& local) {
    std::transform(points.begin(), points.end(), local.begin(), [&](Index p) { return local_of[p]; });
  };
  for (std::size_t k = 0; k < curvatures.size(); ++k) {
    const auto& [triangle, corners, owned] = on_->elements()[k];
    std::array<Index, energy::MembraneTerm::nodes> stencil{};
    to_local(energy::MembraneTerm::stencil_of(on_->sheet(), triangle), stencil);
    membrane_->kernel.add(on_->sheet(), triangle, stencil, owned);
    const energy::BendingElement el = energy::make_bending_element(on_->sheet(), triangle, curvatures[k]);
    std::vector<Index> local(el.points.size());
    to_local(el.points, local);
    if (forms) membrane_->kernel.correct(on_->sheet(), forms->trace(triangle), triangle, el, local);
    if (el.coupling.size() > 0) curved.kernel.add(el, local, owned);
    if (owned) recovery_.add(triangle, el, local, membrane_->kernel.size() - 1);
  }
  auto& ties = add_term<energy::SpringTerm>(&Energies::springs);
  for (const Spring& spring : springs)
    if (spring.kind == Spring::Kind::band)
      add_band(spring, ties);
    else
      tie(spring, ties);
  if (!sewing_.seams.empty()) add_sewing(add_term<energy::SeamTerm>(&Energies::springs));
  for (auto* v : {&u_, &x_, &previous_u_, &previous_x_, &force_})
    v->assign(static_cast<std::size_t>(dofs().local().count()), Vec3::Zero());
}

void Model::tie(const Spring& spring, ElementTerm<energy::SpringTerm>& ties) const {
  const LocalPoints& local = dofs().local();
  for (const auto& [v, w] : pairs_of(on_->mesh(), spring)) {
    if (on_->owned(v) == no_index && on_->owned(w) == no_index) continue;
    const double length =
        std::isnan(spring.length) ? (on_->mesh().positions()[w] - on_->mesh().positions()[v]).norm() : spring.length;
    ties.kernel.add({local.local_of[v], local.local_of[w]}, spring.stiffness, length, on_->owned(v) != no_index);
  }
}

BlockPattern Model::make_pattern(const Curvatures& curvatures) const {
  const LocalPoints& local = dofs().local();
  BlockPattern pattern(static_cast<std::size_t>(local.owned));
  const auto tidy = [](std::vector<Index>& row) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  };
  // Rows are tidied before they grow: what one has once taken stays.
  const auto add = [&](std::vector<Index>& row, const std::vector<Index>& columns) {
    if (row.size() + columns.size() > row.capacity()) tidy(row);
    row.insert(row.end(), columns.begin(), columns.end());
  };
  for (Index i = 0; i < local.owned; ++i) pattern[i].push_back(local.row_of[i]);
  const auto couple = [&](const std::vector<Index>& vertices) {
    std::vector<Index> columns;
    for (Index w : vertices) columns.push_back(on_->partition().row_of[w]);
    for (Index v : vertices)
      if (on_->owned(v) != no_index) add(pattern[on_->owned(v)], columns);
  };
  for (std::size_t k = 0; k < curvatures.size(); ++k)
    couple(vertices_of(on_->patches(), stencil_points(on_->sheet(), on_->elements()[k].triangle, curvatures[k])));
  for (const Counted& t : terms_)
    t.term->for_stencils([&](const Index* points, int count) {
      std::vector<Index> of(static_cast<std::size_t>(count));
      std::transform(points, points + count, of.begin(), [&](Index p) { return local.point_of[p]; });
      couple(vertices_of(on_->patches(), of));
    });
  for (auto& row : pattern) tidy(row);
  return pattern;
}

void Model::assemble_bending(const Curvatures& curvatures, const std::vector<Spring>& springs) {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  const std::vector<Index>& local_of = dofs().local().local_of;
  BlockMatrix& bending = constant_.bending_blocks();
  std::optional<BlockMatrix>& damped = constant_.damping_blocks();
  const BlockMatrix::Values values = bending.open();
  std::optional<BlockMatrix::Values> damping;
  if (damped) damping.emplace(damped->open());
  const auto is_turned = [&](Index p) {
    return on_->patches().is_mirror(p) && on_->constraints().turned_by[p - on_->mesh().vertex_count()] >= 0;
  };
  mpi::on_all(comm(), [&] {
    for (std::size_t k = 0; k < curvatures.size(); ++k) {
      const Discretisation::Element& item = on_->elements()[k];
      const energy::BendingElement el = energy::make_bending_element(on_->sheet(), item.triangle, curvatures[k]);
      if (std::any_of(el.points.begin(), el.points.end(), is_turned)) {  // without damping of their own
        TurningElement& turning = turning_.emplace_back();
        for (Index p : el.points) turning.points.push_back(local_of[p]);
        turning.stiffness = el.stiffness;
        turning.start_force = el.start_force;
        turning.owned = item.owned;
        if (item.owned) steady_offset_ += 2.0 * el.start_energy;
        continue;
      }
      take_start(el, item.owned);
      const double own_damping = on_->sheet().material(item.triangle).bending_damping;
      for (std::size_t i = 0; i < el.points.size(); ++i)
        for (std::size_t j = 0; j < el.points.size(); ++j) {
          const Index p = local_of[el.points[i]], q = local_of[el.points[j]];
          const Mat3 block =
              el.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * Mat3::Identity();
          add_block(dofs(), bending, p, q, block, values);
          if (own_damping > 0.0) add_block(dofs(), *damped, p, q, own_damping * block, *damping);
        }
    }
    any_spring_ = !springs.empty();
    add_springs(springs, values);
  });
  bending.close();
  if (damped) damped->close();
  turns_ = std::any_of(on_->constraints().turned_by.begin(), on_->constraints().turned_by.end(),
                       [](int s) { return s >= 0; });
}

/// Collects what a bent start adds to the constant force and energy of bending.
void Model::take_start(const energy::BendingElement& element, bool owned) {
  for (Eigen::Index i = 0; i < element.start_force.rows(); ++i)
    force_[dofs().local().local_of[element.points[static_cast<std::size_t>(i)]]] +=
        element.start_force.row(i).transpose();
  if (owned) steady_offset_ += 2.0 * element.start_energy;
}

void Model::close_start() {
  dofs().add_forces(force_, steady_force_);
  VOILE_PETSC(VecCopy(steady_force_, bending_force_));
  steady_offset_ = bending_offset_ = mpi::sum(comm(), steady_offset_);
  count_energy_from(reference_);
}

}  // namespace voile::system
