#include "natural_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "base/text.hpp"
#include "discretisation.hpp"
#include "energy/angle_bending.hpp"
#include "energy/bending.hpp"
#include "energy/curvature.hpp"
#include "energy/joint.hpp"
#include "energy/membrane.hpp"
#include "energy/sheet.hpp"
#include "hinges.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

double value_of(bool constant, const Field& f, const Vec3& place, double time, double load_factor) {
  if (!f.value) return 0.0;
  return f.value(place, time) * (constant || f.in_time ? 1.0 : load_factor);
}

std::string name_of(const Temperature& t) {
  return t.group.empty() ? "[[temperature]]" : fmt::format("[[temperature]] group '{}'", t.group);
}

void require_expansion(const Temperature& t, const energy::Material& m) {
  const std::string material = m.groups.empty() ? std::string("the material of all other triangles")
                                                : "that of group '" + m.groups.front() + "'";
  if (!m.expands && m.rubber.any())
    throw UserError(
        fmt::format("{}: the [[material]] there, {}, is rubber, which has no expansion; name the other groups "
                    "in [[temperature]] `group`",
                    name_of(t), material));
  if (!m.expands)
    throw UserError(
        fmt::format("{}: the [[material]] there, {}, has no expansion; give it `expansion` (or `expansion_1` and "
                    "`expansion_2`), 0 if it does not expand",
                    name_of(t), material));
  if (t.difference.value && m.expansion_curvature.isZero(0.0) && !m.expansion.isZero(0.0))
    throw UserError(fmt::format(
        "{}: `difference` needs a thickness, and the [[material]] there, {}, has none; use another type than "
        "\"matrices\", or remove the key",
        name_of(t), material));
}

}  // namespace

bool NaturalStates::needed(const energy::Sheet& sheet, const NaturalInput& input) {
  const auto folds = [](const Hinge& c) { return static_cast<bool>(c.angle.value); };
  return !input.temperatures.empty() || std::any_of(input.hinges.begin(), input.hinges.end(), folds) ||
         std::any_of(sheet.materials().begin(), sheet.materials().end(), energy::has_initial_state);
}

NaturalStates::NaturalStates(const Discretisation& on, NaturalInput input, Kernels kernels)
    : on_(&on), input_(std::move(input)), kernels_(kernels) {
  const energy::Sheet& sheet = on.element_sheet();
  item_of_.assign(static_cast<std::size_t>(on.mesh().triangle_count()), no_index);
  for (const Temperature& t : input_.temperatures) {
    for (const Field* f : {&t.change, &t.difference}) changes_ = changes_ || (f->value && (f->in_time || !t.constant));
    covered_.emplace_back();
    if (!t.group.empty()) {
      covered_.back().assign(item_of_.size(), 0);
      for (const Index k : on.mesh().group(t.group, 2).triangles) covered_.back()[static_cast<std::size_t>(k)] = 1;
    }
    for (Index k = 0; k < on.mesh().triangle_count(); ++k)
      if (covers(covered_.size() - 1, k)) require_expansion(t, sheet.material(k));
  }
  add_joints();
  add_hinges();
}

void NaturalStates::add_hinges() {
  if (!kernels_.joints) return;
  const mesh::SurfaceMesh& mesh = on_->mesh();
  for (std::size_t k = 0; k < input_.hinges.size(); ++k) {
    const Hinge& hinge = input_.hinges[k];
    if (!hinge.angle.value) continue;
    changes_ = changes_ || hinge.angle.in_time || !hinge.constant;
    for (const HingeEdge& e : edges_of(mesh, hinge)) {
      if (!kernels_.joints->has(e.number)) continue;
      const Vec3 place = 0.5 * (mesh.positions()[e.edge[0]] + mesh.positions()[e.edge[1]]);
      folds_.push_back({e.number, k, place, std::sqrt(mesh.area(e.side.triangle))});
    }
  }
}

double NaturalStates::fold_of(const Fold& fold, double time, double load_factor) const {
  const Hinge& hinge = input_.hinges[fold.hinge];
  return (hinge.constant ? eased_ : 1.0) * std::numbers::pi / 180.0 *
         value_of(hinge.constant, hinge.angle, fold.place, time, load_factor);
}

bool NaturalStates::has_constant_folds() const {
  const auto folds = [](const Hinge& h) { return h.constant && h.angle.value; };
  return std::any_of(input_.hinges.begin(), input_.hinges.end(), folds);
}

void NaturalStates::take_folds(double time, double load_factor) {
  if (folds_.empty()) return;
  double height = 0.0;
  for (const Fold& fold : folds_) {
    const double angle = fold_of(fold, time, load_factor);
    if (!(std::abs(angle) <= (1.0 + 1e-9) * std::numbers::pi))
      throw UserError(fmt::format(
          "[[hinge]] group '{}': angle = {:.4g} degrees at ({:.4g}, {:.4g}, {:.4g}) m, at load factor {:.4g} and "
          "t = {:.4g}: a fold is counted from the mesh, and beyond 180 the sheet would pass through itself",
          input_.hinges[fold.hinge].group, angle * 180.0 / std::numbers::pi, fold.place[0], fold.place[1],
          fold.place[2], load_factor, time));
    kernels_.joints->set_fold(fold.joint, angle);
    height = std::max(height, fold.height);
  }
  squared_force_ += kernels_.joints->squared_fold_moment() / (height * height);
}

void NaturalStates::add_joints() {
  if (!kernels_.joints) return;
  for (const Index t : kernels_.joints->triangles()) {
    Item item{t, no_index, no_index, no_index, false, Vec3::Zero(), Vec3::Zero()};
    for (int i = 0; i < 3; ++i) item.place += on_->mesh().start_corner(t, i) / 3.0;
    at_joints_.push_back(item);
  }
}

void NaturalStates::take_joint(const Item& item, double time, double load_factor) {
  const auto [change, difference] = temperature_of(item, time, load_factor);
  kernels_.joints->set_natural(
      item.triangle, energy::natural_state(on_->element_sheet().material(item.triangle), change, difference).curvature);
}

bool NaturalStates::covers(std::size_t temperature, Index t) const {
  const std::vector<char>& of = covered_[temperature];
  return of.empty() || of[static_cast<std::size_t>(t)] != 0;
}

void NaturalStates::add(Index t, const energy::BendingElement& bending, const std::vector<Index>& local, Flags flags) {
  const energy::Material& m = on_->element_sheet().material(t);
  bool has_temperature = false, has_difference = false;
  for (std::size_t k = 0; k < input_.temperatures.size(); ++k) {
    if (!covers(k, t)) continue;
    has_temperature = true;
    has_difference = has_difference || input_.temperatures[k].difference.value;
  }
  if (!has_temperature && !energy::has_initial_state(m)) return;
  const mesh::SurfaceMesh& mesh = on_->mesh();
  Item item{t, kernels_.membrane.size() - 1, no_index, no_index, flags.owned, Vec3::Zero(), bending.rest_curvature};
  for (int i = 0; i < 3; ++i) item.place += mesh.start_corner(t, i) / 3.0;
  kernels_.membrane.add_natural();
  item.projector = energy::free_side_projector(on_->element_sheet(), t);
  if (flags.by_angles) {
    item.angles = kernels_.angles.size() - 1;
    item.rest = kernels_.angles.rest_curvature(item.angles);
  } else if (has_difference || !item.rest.isZero(0.0) || energy::couples(m)) {
    item.bending = kernels_.bending.size();
    kernels_.bending.add_natural(bending, on_->element_sheet().mesh().area(t) * m.bending, local, flags.owned);
  }
  item_of_[static_cast<std::size_t>(t)] = static_cast<Index>(items_.size());
  items_.push_back(item);
}

void NaturalStates::set(double time, double load_factor) {
  const double at = input_.by_load ? load_factor : time;
  if (!fresh_ && (!changes_ || (at == time_ && load_factor == load_factor_))) return;
  fresh_ = false;
  time_ = at;
  load_factor_ = load_factor;
  squared_force_ = 0.0;
  for (Item& item : items_) take(item, at, load_factor);
  for (const Item& item : at_joints_) take_joint(item, at, load_factor);
  take_folds(at, load_factor);
}

std::pair<double, double> NaturalStates::temperature_of(const Item& item, double time, double load_factor) const {
  std::pair<double, double> sum{0.0, 0.0};
  for (std::size_t k = 0; k < input_.temperatures.size(); ++k) {
    if (!covers(k, item.triangle)) continue;
    const Temperature& t = input_.temperatures[k];
    sum.first += value_of(t.constant, t.change, item.place, time, load_factor);
    sum.second += value_of(t.constant, t.difference, item.place, time, load_factor);
  }
  return sum;
}

double NaturalStates::growth() const {
  double most = 0.0;
  for (const Item& item : items_) {
    const auto [change, difference] = temperature_of(item, time_, load_factor_);
    const auto [more, wider] = temperature_of(item, input_.by_load ? time_ + 1.0 : time_, load_factor_ + 1.0);
    const energy::Material& m = on_->element_sheet().material(item.triangle);
    const double cell = std::sqrt(on_->element_sheet().mesh().area(item.triangle));
    most = std::max(most, std::abs(more - change) * m.expansion.norm() +
                              std::abs(wider - difference) * m.expansion_curvature.norm() * cell);
  }
  for (const Fold& fold : folds_)
    most = std::max(most, std::abs(fold_of(fold, input_.by_load ? time_ + 1.0 : time_, load_factor_ + 1.0) -
                                   fold_of(fold, time_, load_factor_)));
  return most;
}

void NaturalStates::take(Item& item, double time, double load_factor) {
  const energy::Material& m = on_->element_sheet().material(item.triangle);
  std::tie(item.change, item.difference) = temperature_of(item, time, load_factor);
  energy::NaturalState state = energy::natural_state(m, item.change, item.difference);
  state.first_order = input_.first_order;
  const Eigen::Vector2d stretch = state.stretch.diagonal();
  if (!(stretch.minCoeff() > 0.0 && state.stretch.determinant() > 0.0))
    throw UserError(
        fmt::format("[[temperature]]: at ({:g}, {:g}, {:g}) m a change of {:g} K leaves a length of {:g} of the rest "
                    "shape; check expansion, initial_strain and temperature",
                    item.place[0], item.place[1], item.place[2], item.change, stretch.minCoeff()));
  kernels_.membrane.set_natural(item.membrane, state);
  state.curvature = item.projector * state.curvature;  // that of the rest shape is so already
  // Angles at edges stay what they are where a shape grows to a similar one.
  item.bent = item.angles == no_index ? state.bent(item.rest) : Vec3(item.rest + state.curvature);
  const Vec3 unit(0.5, 0.5, 0.0);
  if (item.owned)
    squared_force_ +=
        on_->element_sheet().mesh().area(item.triangle) * (m.membrane * (state.metric(unit) - unit)).squaredNorm() +
        (m.bending * (item.bent - item.rest)).squaredNorm();
  if (item.bending != no_index) kernels_.bending.set_natural(item.bending, item.bent);
  if (item.angles != no_index) kernels_.angles.set_rest_curvature(item.angles, item.bent);
}

Vec3 NaturalStates::curvature_change(Index t) const {
  const Index i = item_of_[static_cast<std::size_t>(t)];
  return i == no_index ? Vec3(Vec3::Zero()) : Vec3(items_[i].bent - items_[i].rest);
}

std::pair<double, double> NaturalStates::temperature(Index t) const {
  const Index i = item_of_[static_cast<std::size_t>(t)];
  return i == no_index ? std::pair(0.0, 0.0) : std::pair(items_[i].change, items_[i].difference);
}

}  // namespace voile::system
