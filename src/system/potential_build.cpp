#include "potential.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "attachments.hpp"
#include "bands.hpp"
#include "base/mpi.hpp"
#include "bending_energy.hpp"
#include "boundary_conditions.hpp"
#include "discretisation.hpp"
#include "energy/anchor.hpp"
#include "energy/angle_bending.hpp"
#include "energy/bending.hpp"
#include "energy/chord_correction.hpp"
#include "energy/chord_forms.hpp"
#include "energy/coupling.hpp"
#include "energy/joint.hpp"
#include "energy/linear_bending.hpp"
#include "energy/membrane.hpp"
#include "energy/mirror_fold.hpp"
#include "energy/seam.hpp"
#include "energy/sheet.hpp"
#include "energy/spring.hpp"
#include "energy/yarn_friction.hpp"
#include "mesh/patch.hpp"
#include "natural_states.hpp"
#include "sewing_springs.hpp"
#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

Potential::Potential(Discretisation& on, BoundaryConditions& conditions, const Contact* contact, PotentialInput input)
    : on_(&on), conditions_(&conditions) {
  Curvatures curvatures = on.take_curvatures();
  BlockPattern pattern;
  mpi::on_all(on.comm(), [&] {
    build_terms(curvatures, input);
    pattern = make_pattern(curvatures);
  });
  constant_ = ConstantMatrices(on, std::move(pattern), input.masses);
  mpi::on_all(on.comm(), [&] {
    halves_ = HalfBlocks(on.dofs(), constant_.base());
    for (const Counted& t : terms_) t.term->locate(halves_);
    halves_.end_counting();
    for (const Counted& t : terms_) t.term->locate(halves_);
  });
  work_ = on.dofs().create_vector();
  bending_ = std::make_unique<BendingEnergy>(on, constant_, curvatures, input.springs);
  mpi::on_all(on.comm(), [&] {
    attachments_ = std::make_unique<Attachments>(on, std::move(input.attachments), contact, conditions, anchors_);
  });
}

Potential::~Potential() = default;

template <class AnyTerm>
AnyTerm& Potential::add_term(double Energies::*part) {
  auto term = std::make_unique<AnyTerm>();
  AnyTerm& reference = *term;
  terms_.push_back({std::move(term), part});
  return reference;
}

/// Here a new term joins the potential.
void Potential::build_terms(const Curvatures& curvatures, const PotentialInput& input) {
  build_joints(!input.natural.hinges.empty());
  build_sheet(curvatures, input.natural);
  build_mirror_folds();
  if (energy::YarnFrictionTerm::is_needed(on_->element_sheet())) build_yarns(curvatures);
  auto& ties = add_term<ElementTerm<energy::SpringTerm>>(&Energies::springs);
  bands_ = std::make_unique<Bands>(*on_, ties.kernel);
  for (const Spring& spring : input.springs)
    if (spring.kind == Spring::Kind::band)
      bands_->add(spring);
    else
      tie(spring, ties);
  if (!input.sewing.seams.empty()) {
    sewing_ = std::make_unique<SewingSprings>(*on_, input.sewing,
                                              add_term<ElementTerm<energy::SeamTerm>>(&Energies::springs).kernel);
    membrane_->kernel.gather(drawn_in_ = 0.0);
  }
  if (!input.attachments.empty()) anchors_ = &add_term<ElementTerm<energy::AnchorTerm>>(&Energies::springs).kernel;
  for (auto* v : {&u_, &x_, &force_}) v->assign(static_cast<std::size_t>(on_->dofs().local().count()), Vec3::Zero());
}

/// The membrane, bending of curved rest shapes beyond K_b, and what is recovered from both.
void Potential::build_sheet(const Curvatures& curvatures, NaturalInput input) {
  membrane_ = &add_term<BatchTerm<energy::MembraneTerm>>(&Energies::membrane);
  membrane_->kernel = energy::MembraneTerm(on_->element_sheet());
  std::optional<energy::ChordForms> forms;
  if (membrane_->kernel.corrects()) forms.emplace(on_->element_sheet());
  membrane_->kernel.reserve(curvatures.size());
  auto& curved = add_term<BatchTerm<energy::CurvedBendingTerm>>(&Energies::bending);
  angles_ = &add_term<BatchTerm<energy::AngleBendingTerm>>(&Energies::bending);
  if (NaturalStates::needed(on_->element_sheet(), input)) {
    auto& natural = add_term<BatchTerm<energy::CurvedBendingTerm>>(&Energies::bending);
    natural_ = std::make_unique<NaturalStates>(
        *on_, std::move(input), NaturalStates::Kernels{membrane_->kernel, natural.kernel, angles_->kernel, joints_});
  }
  energy::LinearBendingTerm* beside =
      on_->constraints().bodies.empty() ? nullptr
                                        : &add_term<ElementTerm<energy::LinearBendingTerm>>(&Energies::bending).kernel;
  const auto& materials = on_->element_sheet().materials();
  if (std::any_of(materials.begin(), materials.end(), energy::couples))
    coupling_ = &add_term<ElementTerm<energy::CouplingTerm>>(&Energies::bending).kernel;
  const std::vector<Index>& local_of = on_->dofs().local().local_of;
  const auto to_local = [&](const auto& points, auto& local) {
    std::transform(points.begin(), points.end(), local.begin(), [&](Index p) { return local_of[p]; });
  };
  for (std::size_t k = 0; k < curvatures.size(); ++k) {
    const auto& [triangle, corners, owned] = on_->elements()[k];
    std::array<Index, energy::MembraneTerm::nodes> stencil{};
    to_local(energy::MembraneTerm::stencil_of(on_->element_sheet(), triangle), stencil);
    membrane_->kernel.add(on_->element_sheet(), triangle, stencil, owned);
    const energy::BendingElement el = energy::make_bending_element(on_->element_sheet(), triangle, curvatures[k]);
    std::vector<Index> local(el.points.size());
    to_local(el.points, local);
    if (beside && on_->is_on_body(el.points)) beside->add(el, local, owned);
    const bool by_angles = add_angles(triangle, curvatures[k], el, local, owned);
    if (forms)  // the term of fourth order is for sums of vectors
      membrane_->kernel.correct(on_->element_sheet(), by_angles ? Mat3(Mat3::Zero()) : forms->trace(triangle), triangle,
                                el, local);
    if (on_->draws_in()) membrane_->kernel.add_gather(on_->element_sheet(), on_->patches_before(), triangle);
    if (energy::couples(on_->element_sheet().material(triangle))) add_coupling(triangle, el, owned);
    if (natural_) natural_->add(triangle, el, local, {owned, by_angles});
    if (!by_angles && el.coupling.size() > 0) curved.kernel.add(el, local, owned);
    if (owned)
      recovery_.add(triangle, el, local, membrane_->kernel.size() - 1,
                    by_angles ? angles_->kernel.size() - 1 : no_index);
  }
  if (natural_) natural_->set(0.0, 1.0);  // what is impossible shows before the first step
  angles_->kernel.end_adding();
  recovery_.end_adding();
}

bool Potential::add_angles(Index t, const energy::CurvatureOperator& op, const energy::BendingElement& el,
                           const std::vector<Index>& local, bool owned) {
  const energy::Sheet& sheet = on_->element_sheet();
  if (!energy::bends_by_angles(sheet, t) || energy::couples(sheet.material(t))) return false;
  if (local.size() > energy::AngleBendingTerm::most) return false;
  const std::optional<energy::EdgeAngles> angles = energy::make_edge_angles(sheet, t, op, el);
  if (angles) angles_->kernel.add(el, *angles, local, sheet.mesh().area(t) * sheet.material(t).bending, owned);
  return angles.has_value();
}

void Potential::add_coupling(Index t, const energy::BendingElement& el, bool owned) {
  coupling_->add(on_->element_sheet(), t, el, on_->dofs().local().local_of, owned);
  coupled_.push_back({t, membrane_->kernel.size() - 1, el.rest_curvature});
}

void Potential::build_yarns(const Curvatures& curvatures) {
  yarns_ = &add_term<BatchTerm<energy::YarnFrictionTerm>>(&Energies::bending);
  yarns_->kernel = energy::YarnFrictionTerm(on_->element_sheet());
  const std::vector<Index>& local_of = on_->dofs().local().local_of;
  for (std::size_t k = 0; k < curvatures.size(); ++k) {
    const auto& [triangle, corners, owned] = on_->elements()[k];
    if (!energy::YarnFrictionTerm::acts_on(on_->element_sheet(), triangle)) continue;
    const energy::BendingElement el = energy::make_bending_element(on_->element_sheet(), triangle, curvatures[k]);
    if (el.points.size() > energy::AngleBendingTerm::most) continue;
    std::vector<Index> local;
    for (const Index p : el.points) local.push_back(local_of[p]);
    yarns_->kernel.add(on_->element_sheet(), triangle, el, local, owned);
  }
}

void Potential::build_joints(bool hinges) {
  Discretisation::Joints joints = on_->take_joints();
  const bool none = std::all_of(on_->constraints().bodies.begin(), on_->constraints().bodies.end(),
                                [](const RigidBody& b) { return b.slopes.empty(); });
  if (on_->mesh().joints().empty() && none && !hinges) return;
  joints_ = &add_term<ElementTerm<energy::JointTerm>>(&Energies::bending).kernel;
  for (std::size_t k = 0; k < joints.elements.size(); ++k) {
    std::vector<Index> local;
    for (const Index p : joints.elements[k].points) local.push_back(on_->dofs().local().local_of[p]);
    joints_->add(std::move(joints.elements[k]), std::move(local), joints.owned[k] != 0);
  }
}

void Potential::build_mirror_folds() {
  folds_ = &add_term<ElementTerm<energy::MirrorFoldTerm>>(&Energies::bending).kernel;
  const mesh::SurfaceMesh& mesh = on_->mesh();
  const LocalPoints& local = on_->dofs().local();
  const std::vector<mesh::MirrorPoint>& mirrors = on_->patches().mirrors();
  for (std::size_t k = 0; k < on_->constraints().mirrors.size(); ++k) {  // not of images, which follow
    const mesh::MirrorPoint& m = mirrors[k];
    const std::array<Index, 3> vertices{m.apex, m.a, m.b};
    if (!on_->has_rows_of({m.apex, m.a, m.b})) continue;
    Index triangle = no_index;
    for (const Index t : mesh.triangles_of_vertex(m.apex))
      if (mesh.side_of(t, m.a, m.b) >= 0) triangle = t;
    const auto start = [&](Index v) { return local.start[local.local_of[v]]; };
    const Vec3 arm = start(m.apex) - ((1.0 - m.foot) * start(m.a) + m.foot * start(m.b));
    const double length = mesh.rest_length({m.a, m.b}), height = 2.0 * mesh.area(triangle) / length;
    const double bending = 0.5 * on_->element_sheet().material(triangle).bending.topLeftCorner<2, 2>().trace();
    energy::MirrorFoldTerm::Edge edge;
    std::transform(vertices.begin(), vertices.end(), edge.points.begin(), [&](Index v) { return local.local_of[v]; });
    edge.foot = m.foot;
    edge.height = height;
    edge.stiffness = 2.0 * bending * length / height;
    edge.outward = -arm.normalized();
    edge.support = on_->constraints().turned_by[k];
    edge.owned = on_->owned(on_->constraints().ties.any() ? on_->constraints().ties.root(m.apex) : m.apex) != no_index;
    folds_->add(edge);
  }
}

void Potential::tie(const Spring& spring, ElementTerm<energy::SpringTerm>& ties) const {
  const LocalPoints& local = on_->dofs().local();
  for (const auto& [v, w] : pairs_of(on_->mesh(), spring)) {
    if (!on_->has_rows_of({v, w}) && on_->owned(v) == no_index) continue;
    const double length =
        std::isnan(spring.length) ? (on_->mesh().positions()[w] - on_->mesh().positions()[v]).norm() : spring.length;
    ties.kernel.add({local.local_of[v], local.local_of[w]}, spring.stiffness, length, on_->owned(v) != no_index);
  }
}

BlockPattern Potential::make_pattern(const Curvatures& curvatures) const {
  const LocalPoints& local = on_->dofs().local();
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
    couple(on_->unknowns_of(stencil_points(on_->element_sheet(), on_->elements()[k].triangle, curvatures[k])));
  for (const Counted& t : terms_)
    t.term->for_stencils([&](const Index* points, int count) {
      std::vector<Index> of(static_cast<std::size_t>(count));
      std::transform(points, points + count, of.begin(), [&](Index p) { return local.point_of[p]; });
      couple(on_->unknowns_of(of));
    });
  for (const RigidBody& body : on_->constraints().bodies) couple(on_->unknowns_of(body.members));
  for (auto& row : pattern) tidy(row);
  return pattern;
}

}  // namespace voile::system
