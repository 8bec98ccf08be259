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
#include "voile/system/bands.hpp"
#include "voile/system/bending_energy.hpp"
#include "voile/system/contact.hpp"
#include "voile/system/sewing_springs.hpp"
#include "voile/system/term.hpp"

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
    : on_(std::make_unique<Discretisation>(comm, mesh, std::move(input.materials), with_followers(input), input.springs,
                                           input.element, Seams{std::move(input.seams), input.sewing.seams})) {
  Curvatures curvatures = on_->take_curvatures();
  BlockPattern pattern;
  energy::AnchorTerm* anchors = nullptr;
  mpi::on_all(comm, [&] {
    build_terms(curvatures, input.springs, std::move(input.sewing));
    if (!input.attachments.empty()) anchors = &add_term<energy::AnchorTerm>(&Energies::springs).kernel;
    pattern = make_pattern(curvatures);
  });
  constant_ = ConstantMatrices(*on_, std::move(pattern), input.masses);
  work_ = dofs().create_vector();
  bending_ = std::make_unique<BendingEnergy>(*on_, constant_, curvatures, input.springs);
  curvatures = Curvatures();  // room for the tangent, which is the largest part
  tangent_ = Tangent(*on_, constant_.base());
  conditions_ = std::make_unique<BoundaryConditions>(*on_, std::move(input.supports), input.loads, input.masses,
                                                     input.motion_by_load);
  if (input.contact.active)
    mpi::on_all(comm, [&] { contact_ = std::make_unique<Contact>(dofs(), std::move(input.contact)); });
  mpi::on_all(comm, [&] {
    attachments_ =
        std::make_unique<Attachments>(*on_, std::move(input.attachments), contact_.get(), *conditions_, anchors);
  });
  const PetscBool symmetric = conditions_->symmetric() ? PETSC_TRUE : PETSC_FALSE;
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
void Model::build_terms(const Curvatures& curvatures, const std::vector<Spring>& springs, Sewing sewing) {
  membrane_ = &add_term<energy::MembraneTerm>(&Energies::membrane);
  membrane_->kernel = energy::MembraneTerm(on_->sheet());
  std::optional<energy::ChordForms> forms;
  if (membrane_->kernel.corrects()) forms.emplace(on_->sheet());
  membrane_->kernel.reserve(curvatures.size());
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
    if (on_->draws_in()) membrane_->kernel.add_gather(on_->sheet(), on_->patches_before(), triangle);
    const energy::BendingElement el = energy::make_bending_element(on_->sheet(), triangle, curvatures[k]);
    std::vector<Index> local(el.points.size());
    to_local(el.points, local);
    if (forms) membrane_->kernel.correct(on_->sheet(), forms->trace(triangle), triangle, el, local);
    if (el.coupling.size() > 0) curved.kernel.add(el, local, owned);
    if (owned) recovery_.add(triangle, el, local, membrane_->kernel.size() - 1);
  }
  recovery_.end_adding();
  auto& ties = add_term<energy::SpringTerm>(&Energies::springs);
  bands_ = std::make_unique<Bands>(*on_, ties.kernel);
  for (const Spring& spring : springs)
    if (spring.kind == Spring::Kind::band)
      bands_->add(spring);
    else
      tie(spring, ties);
  if (!sewing.seams.empty()) {
    sewing_ =
        std::make_unique<SewingSprings>(*on_, std::move(sewing), add_term<energy::SeamTerm>(&Energies::springs).kernel);
    membrane_->kernel.gather(drawn_in_ = 0.0);
  }
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

}  // namespace voile::system
