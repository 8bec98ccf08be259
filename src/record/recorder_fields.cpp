// The fields of a recorded state.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/mpi.hpp"
#include "contact_fields.hpp"
#include "form_tension.hpp"
#include "linear_values.hpp"
#include "recorder.hpp"
#include "stresses.hpp"
#include "system/contact.hpp"
#include "system/failure.hpp"

namespace voile::record {

namespace {

using Field = results::Field;

/// Estimates of error.
constexpr std::array judgements{"membrane_error", "membrane_recovery_error", "bending_recovery_error"};

/// In words and figures for the summary; `displacement`: three numbers per vertex.
std::optional<FirstFailure> first_failure(const mesh::SurfaceMesh& mesh, const system::FailureFields& f,
                                          const std::vector<double>& displacement) {
  if (f.triangle == no_index) return std::nullopt;
  Vec3 place = Vec3::Zero();
  for (const Index v : mesh.triangles()[f.triangle])
    place += (mesh.positions()[v] + Eigen::Map<const Vec3>(displacement.data() + 3 * v)) / 3.0;
  return FirstFailure{f.first.index, f.first.layer, f.first.top, place};
}

}  // namespace

std::vector<Field> Recorder::stresses(const system::TriangleFields& t, const Wants& wants, bool all) const {
  using Stresses = input::OutputSection::Stresses;
  std::vector<Field> found;
  if (all && case_.output.stresses == Stresses::none) return found;
  const bool plies = !all || case_.output.stresses == Stresses::plies;
  for (Field& f : stress_fields(model_->discretisation().sheet(), t, plies))
    if (all || wants(f.name)) found.push_back(std::move(f));
  return found;
}

// A linear solution is of any size: its round-off is relative to its displacements. Where the sheet grows by itself, what it stores
// is judged beside that.
double Recorder::round_off_strain(Vec a) const {
  constexpr double part_of_growth = 1e-3;
  if (!linear_)
    return std::max(no_strain, part_of_growth * std::abs(model_->conditions().load_factor()) *
                                   model_->potential().natural_growth());
  double largest = 0.0;
  VOILE_PETSC(VecNorm(a, NORM_INFINITY, &largest));
  return no_strain * largest / std::sqrt(model_->discretisation().mean_area());
}

std::vector<Field> Recorder::fields_of(Vec a, const Snapshot& s, const Wants& wants, const std::string* judged) {
  std::vector<Field> fields;
  const system::TriangleFields t = linear_ ? LinearValues(*model_, a).triangle_fields() : model_->triangle_fields(a);
  if (sizes_ && wants("wanted_size")) fields.push_back({"wanted_size", "m", results::Centre::vertex, 1, sizes_()});
  for (Field& f : contact_fields(*model_, a, wants)) fields.push_back(std::move(f));
  const bool estimated = estimates() && (judged || std::any_of(judgements.begin(), judgements.end(),
                                                               [&](const char* n) { return wants(n); }));
  const double least = estimated ? round_off_strain(a) : no_strain;
  DiscretisationError::Densities recovered;
  if (estimated)
    recovered =
        judged ? discretisation_error_.judged(*model_, t, {*judged, least}) : discretisation_error_.of(*model_, t);
  mpi::on_root(model_->dofs().comm(), [&] {
    const auto add = [&](const char* name, const char* unit, results::Centre centre,
                         const std::vector<double>& values) {
      if (wants(name)) fields.push_back({name, unit, centre, 3, values});
    };
    add("displacement", "m", results::Centre::vertex, s.state.displacement);
    add("reaction", "N", results::Centre::vertex, s.state.reaction);
    add("membrane_strain", "1", results::Centre::triangle, t.membrane_strain);
    add("membrane_force", "N/m", results::Centre::triangle, t.membrane_force);
    add("curvature", "1/m", results::Centre::triangle, t.curvature);
    add("bending_moment", "N", results::Centre::triangle, t.bending_moment);
    const auto add_density = [&](const char* name, std::vector<double>& values) {
      if (wants(name)) fields.push_back({name, "J/m^2", results::Centre::triangle, 1, std::move(values)});
    };
    if (linear_ && judged) warnings_.say_linear_range(model_->discretisation().sheet(), t.membrane_strain);
    if (estimated) {
      Warnings::MembraneError error = warnings_.membrane_error(model_->discretisation().sheet(), t, least);
      membrane_error_ = error.fraction;
      add_density("membrane_error", error.density);
      add_density("membrane_recovery_error", recovered.membrane);
      add_density("bending_recovery_error", recovered.bending);
    }
    for (Field& f : stretch_fields(model_->discretisation().sheet(), t))
      if (wants(f.name)) fields.push_back(std::move(f));
    for (Field& f : stresses(t, wants, judged != nullptr)) fields.push_back(std::move(f));
    if (!estimates() || !system::has_strengths(model_->discretisation().sheet())) return;
    system::FailureFields failure = system::failure_fields(model_->discretisation().sheet(), t);
    if (judged) failure_ = first_failure(model_->dofs().mesh(), failure, s.state.displacement);
    if (wants("failure_index"))
      fields.push_back({"failure_index", "1", results::Centre::triangle, 1, std::move(failure.index)});
    if (wants("failure_ply"))
      fields.push_back({"failure_ply", "1", results::Centre::triangle, 1, std::move(failure.ply)});
  });
  for (Field& f : fields) f.unit = input::UnitSystem(case_.units).label(f.unit);
  return fields;
}

void Recorder::say_form(const system::State& state, const solve::StepResult& r) {
  const bool is_first = case_.form.active && case_.stage.number == 0 && !dynamics_ && !linear_ &&
                        case_.analysis != input::Analysis::drape && r.taken == 0.0 && state.load_factor == 0.0;
  if (!is_first || std::exchange(said_form_, true)) return;
  const system::TriangleFields t = model_->triangle_fields(state.u);
  mpi::on_root(model_->dofs().comm(), [&] {
    const energy::Sheet& sheet = model_->discretisation().sheet();
    const TensionChange change = tension_change(sheet, t);
    const std::string text = text_of(change, sheet, input::UnitSystem(case_.units).label("N/m"));
    if (change.error > tension_limit)
      fmt::print(stderr, "voile: warning: {}\n", text);
    else
      remark(text);
  });
}

std::vector<Field> Recorder::fields(const system::State& state, const Wants& wants) {
  std::vector<Field> found = fields_of(state.u, gathered(state.u, motion_of(state)), wants, nullptr);
  if (dynamics_ && wants("velocity"))
    found.push_back({"velocity", input::UnitSystem(case_.units).label("m/s"), results::Centre::vertex, 3,
                     model_->dofs().gather_change(state.v)});
  return found;
}

void Recorder::write_fields(results::StepFields step, Vec a, const Snapshot& s) {
  // Along a motion the worst state is passed in an instant.
  const std::string place =
      case_.analysis == input::Analysis::statics ? fmt::format("load factor {:.4g}", step.load_factor) : "";
  for (Field& f : fields_of(
           a, s, [this](const std::string& name) { return wants(name); }, &place))
    step.fields.push_back(std::move(f));
  mpi::on_root(model_->dofs().comm(), [&] {
    if (obstacles_ && obstacles_->at_rest().moves) step.obstacles = obstacles_->positions(model_->contact()->scene());
    results_->write(step);
  });
}

}  // namespace voile::record
