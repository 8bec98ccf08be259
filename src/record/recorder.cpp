#include "recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/mpi.hpp"
#include "base/terminal.hpp"
#include "base/text.hpp"
#include "garment_measures.hpp"
#include "history_columns.hpp"
#include "linear_values.hpp"
#include "system/contact.hpp"
#include "system/ease.hpp"
#include "system/gas.hpp"
#include "system/rigid_loads.hpp"
#include "system/rigid_places.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace {

/// Names of groups that differ in the results, of which so many are listed: a pattern has dozens.
constexpr std::size_t listed_groups = 3;

std::string duration(double seconds) {
  const auto s = static_cast<long>(std::max(0.0, seconds));
  if (s < 100) return fmt::format("{:.1f}s", seconds);
  if (s < 6000) return fmt::format("{}m{:02}s", s / 60, s % 60);
  return fmt::format("{}h{:02}m", s / 3600, s / 60 % 60);
}

}  // namespace

Recorder::Recorder(const input::Case& c, const RunOptions& options, system::Model& model)
    : case_(c),
      options_(options),
      model_(&model),
      mesh_(&model.dofs().mesh()),
      root_(mpi::rank(model.dofs().comm()) == 0),
      probes_(std::in_place, c, model),
      linear_(c.analysis == input::Analysis::linear),
      warnings_(linear_, c.analysis == input::Analysis::drape) {
  mpi::on_root(model.dofs().comm(), [&] {
    kept_.columns = columns();
    if (!has_folder()) return;
    if (model.contact()) obstacles_.emplace(model.contact()->scene().input(), model.dofs().mesh());
    results_.emplace(options.output, obstacles_ ? obstacles_->at_rest() : results::ObstacleTriangles{},
                     input::UnitSystem(case_.units).label("m"));
    begin_epoch();
    history_.emplace(options.output / "history.csv", kept_.columns);
    if (std::vector<std::string> renamed = results_->renamed_groups(); !renamed.empty()) {
      const std::size_t more = renamed.size() > listed_groups ? renamed.size() - listed_groups : 0;
      renamed.resize(renamed.size() - more);
      remark("names of groups in results.vtkhdf: " + join(renamed, ", ") +
             (more > 0 ? fmt::format(", and {} more so (their attribute `name` has the name)", more) : ""));
    }
  });
  if (root_ && options.verbosity != Verbosity::quiet && !rewrites_progress())
    fmt::print("{}", case_.analysis == input::Analysis::dynamic
                         ? fmt::format("{:>6} {:>10} {:>9} {:>7} {:>10} {:>10} {:>9} {:>9}\n", "step", "time [s]",
                                       "taken", "newton", "residual", "kinetic", "elapsed", "left")
                         : fmt::format("{:>5} {:>10} {:>7} {:>10} {:>10} {:>9} {:>9}\n", "step", "load", "newton",
                                       "residual", "neg.pivots", "elapsed", "left"));
}

/// On rank 0.
void Recorder::begin_epoch() {
  if (!results_) return;
  const mesh::Partition& p = model_->dofs().partition();
  results_->begin_epoch(*mesh_, p.vertex_rank, p.triangle_rank);
}

void Recorder::use(system::Model& model, const system::Dynamics* dynamics) {
  model_ = &model;
  dynamics_ = dynamics;
  warnings_.begin_epoch();
  discretisation_error_.begin_epoch();
  if (mesh_ == &model.dofs().mesh()) return;
  mesh_ = &model.dofs().mesh();
  probes_.emplace(case_, model);
  mpi::on_root(model.dofs().comm(), [&] { begin_epoch(); });
}

std::vector<std::string> Recorder::columns() const {
  const system::Contact* contact = model_->contact();
  std::vector<char> gases;
  for (const system::Gas& gas : model_->conditions().gases()) gases.push_back(gas.leaks() ? 1 : 0);
  std::vector<std::string> names =
      names_of({.in_time = case_.analysis == input::Analysis::dynamic,
                .energy_balance = keeps_balance(),
                .fabric = model_->potential().has_yarn_friction(),
                .sewing = !case_.stage.sew.empty(),
                .remeshing = case_.remesh.active,
                .contact = case_.contact.input.active,
                .passing = contact && system::has_passable_obstacles(contact->scene().input()),
                .gases = gases});
  for (const input::RigidSection& rigid : case_.rigids)
    for (const std::string& column : names_of_rigid(rigid.name)) names.push_back(column);
  for (const input::PeriodicSection& s : case_.periodics)
    for (const std::string& column : names_of_periodic(s.name)) names.push_back(column);
  for (std::string& name : probes_->columns()) names.push_back(std::move(name));
  return names;
}

bool Recorder::wants(const std::string& field) const {
  const auto& f = case_.output.fields;
  if (f.empty() && field == "ease") return !case_.panels.empty();  // of garments, unless it is asked for
  return f.empty() || std::find(f.begin(), f.end(), field) != f.end();
}

Recorder::Snapshot Recorder::gathered(Vec a, const Motion& motion) {
  Snapshot s;
  petsc::VecHandle force = model_->dofs().create_vector();
  linear_ ? LinearValues(*model_, a).unbalanced_force(force) : model_->unbalanced_force(a, force);
  if (motion.v) {
    dynamics_->add_damping(motion.v, force);
    petsc::VecHandle acceleration = model_->dofs().create_vector();
    if (motion.a) VOILE_PETSC(VecCopy(motion.a, acceleration));
    const solve::TimeOptions& time = case_.time.options;
    dynamics_->add_inertia(acceleration, motion.v, {motion.time, time.step, time.end_time}, force);
  }
  model_->dofs().clear_free(force);  // away from supports the force is only the residual that is left
  s.state.displacement = linear_ ? model_->dofs().gather_change(a) : model_->dofs().gather(a);
  s.state.reaction = model_->dofs().gather_forces(force);
  if (!case_.periodics.empty()) s.bodies = system::periodic_values(model_->discretisation(), a, force);
  if (!case_.rigids.empty())
    s.bodies = bodies_of(a, force, motion.v ? motion.time : model_->conditions().load_factor());
  return s;
}

std::vector<double> Recorder::bodies_of(Vec a, Vec force, double time) const {
  constexpr std::size_t each = 12, turn = 3;
  std::vector<double> all = system::rigid_values(model_->discretisation(), a, force, linear_);
  const system::RigidLoads& rigid = model_->conditions().rigid();
  for (std::size_t b = 0; each * b < all.size() && !linear_; ++b)
    if (const std::optional<Vec3> whole = rigid.prescribed_turn(b, time))
      std::copy(whole->data(), whole->data() + 3, &all[each * b + turn]);
  return all;
}

Recorder::Snapshot Recorder::snapshot(Vec a, const Motion& motion) {
  Snapshot s = gathered(a, motion);
  if (root_) {
    s.validity = assess(*model_, s.state.displacement, linear_);
    warnings_.say_range(model_->dofs().mesh(), s.validity);
    warnings_.say_dimples(case_, model_->discretisation().sheet(), s.state.displacement,
                          model_->conditions().load_factor());
  }
  if (probes_->need_energies()) {
    s.state.energies = linear_ ? LinearValues(*model_, a).energies() : system::energies(*model_, a);
    if (!motion.v) s.state.energies.bending += model_->edge_energy();
  }
  if (probes_->need_stresses()) {
    const system::TriangleFields t = linear_ ? LinearValues(*model_, a).triangle_fields() : model_->triangle_fields(a);
    if (root_) s.state.stresses = probes_->stresses(*model_, t);
  }
  if (probes_->need_ease()) s.state.ease = system::ease(model_->contact()->scene(), a);
  if (system::Contact* contact = model_->contact()) {
    s.contact = system::report(contact->scene(), a);
    if (probes_->need_contact()) s.state.on_obstacles = contact->forces_on_obstacles(a);
    if (case_.contact.check) s.intersections = count_intersections(a);
  }
  return s;
}

long Recorder::count_intersections(Vec a) const {
  const std::vector<Vec3> positions = model_->contact()->scene().positions(a);
  const setup::IntersectionCheck check(*model_->contact());
  const std::vector<geometry::TrianglePair> pairs = check.find_by_ranks(positions);
  if (!pairs.empty())
    mpi::on_root(model_->dofs().comm(), [&] {
      const std::filesystem::path file = has_folder() ? options_.output / "intersections.vtk" : "";
      const std::string found = check.report(positions, pairs, file),
                        see = has_folder() ? "; see " + file.string() : "";
      fmt::print(stderr, "voile: contact let triangles intersect: {}{}\n", found, see);
    });
  return static_cast<long>(pairs.size());
}

std::string Recorder::contact_note(const Snapshot& s, const solve::StepResult& r) const {
  const long passing = model_->contact() ? system::passing_count(model_->contact()->memory()) : 0;
  std::string given = passing > 0 ? fmt::format("  obstacles let {} vertices pass", passing) : "";
  if (s.contact.pairs == 0) return given;
  return given + fmt::format("  {} contacts, gap {:.3g} m{}", s.contact.pairs, s.contact.gap,
                             r.cut_short > 0 ? fmt::format(", {} cut short (to {:.2g})", r.cut_short, r.shortest) : "");
}

void Recorder::record(const system::State& state, const solve::StepResult& r, bool whole) {
  const petsc::EventScope scope(petsc::events().output);
  Snapshot s = snapshot(state.u, motion_of(state));
  if (dynamics_)
    s.kinetic = dynamics_->kinetic_energy(state.v) +
                dynamics_->kinetic_energy_of_held(state.v, system::short_moment * case_.time.options.step);
  if (dynamics_) kinetic_.add(state.time, s.kinetic);
  write_history(state, r, s);
  if (has_folder()) write_step(state, r, s, whole);
  if (r.taken > 0.0) seams_.add(case_, *model_, state);  // what strains the sheet at the start pulls no seam
  // Contact promises that there is none: one that is found is a fault of the program, and nothing after it counts.
  if (s.intersections > 0)
    throw InternalError(
        fmt::format("contact let {} pairs of triangles intersect in step {}, which is recorded; the "
                    "steps before it are whole",
                    s.intersections, state.step));
  say_form(state, r);
  time_left_.add(dynamics_ ? state.time : state.load_factor, wall_seconds());
  const bool is_start = dynamics_ ? r.taken == 0.0 : r.newton.iterations == 0 && r.newton.factorisations == 0;
  if (!root_ || options_.verbosity == Verbosity::quiet || is_start) return;
  dynamics_ ? print_motion(state, r, s) : print_path(state, r, s);
}

void Recorder::report_seams(const system::State& state) const {
  const std::vector<SeamMeasure> seams = seams_.measure(case_, *model_, state);
  mpi::on_root(model_->dofs().comm(), [&] {
    if (has_folder() && !seams.empty()) write_seams(options_.output, seams);
  });
  for (const std::string& line : seam_lines(seams)) remark(line);
}

void Recorder::write_step(const system::State& state, const solve::StepResult& r, const Snapshot& s, bool whole) {
  results::StepFields step;
  step.step = state.step;
  // Along an arc the load factor goes up and down, but a time must not.
  step.time = dynamics_ ? state.time : case_.steps.control == Control::load ? state.load_factor : state.step;
  step.load_factor = state.load_factor;
  if (case_.analysis == input::Analysis::statics) step.path = system::path_record(state.next_step, state.path);
  step.bodies = system::rigid_record(model_->discretisation(), state);
  if (r.mode)
    step.fields.push_back({"critical_mode", "1", results::Centre::vertex, 3, model_->dofs().gather_change(r.mode)});
  const std::vector<double>& stops = case_.steps.stops;
  const auto is_here = [&](double stop) { return std::abs(stop - state.load_factor) <= 1e-12 * std::max(1.0, stop); };
  const bool due =
      state.step % case_.output.every == 0 || (!dynamics_ && std::any_of(stops.begin(), stops.end(), is_here));
  write_or_keep(due || whole || r.mode || s.intersections > 0, std::move(step), state.u, motion_of(state), s);
}

void Recorder::write_or_keep(bool write, results::StepFields step, Vec position, const Motion& motion,
                             const Snapshot& s) {
  pending_.reset();
  if (write) {
    if (motion.v && wants("velocity"))
      step.fields.push_back({"velocity", input::UnitSystem(case_.units).label("m/s"), results::Centre::vertex, 3,
                             model_->dofs().gather_change(motion.v)});
    write_fields(std::move(step), position, s);
    return;
  }
  const auto copy = [&](Vec from) {
    petsc::VecHandle to;
    if (!from) return to;
    to = model_->dofs().create_vector();
    VOILE_PETSC(VecCopy(from, to));
    return to;
  };
  pending_ = Pending{std::move(step), copy(position), copy(motion.v), copy(motion.a)};
}

void Recorder::write_pending() {
  if (!pending_) return;
  const Pending p = std::move(*pending_);
  const Motion motion{p.velocity, p.acceleration, p.step.time};
  write_or_keep(true, p.step, p.position, motion, snapshot(p.position, motion));
}

void Recorder::finish() {
  write_pending();
  if (has_folder()) mpi::on_root(model_->dofs().comm(), [&] { results_->finish(); });
  if (root_ && !warnings_.membrane_text().empty())
    fmt::print(stderr, "voile: warning: {}\n", warnings_.membrane_text());
  if (!discretisation_error_.warning().empty())
    fmt::print(stderr, "voile: warning: {}\n", discretisation_error_.warning());
}

std::vector<double> Recorder::common_values(const system::State& state, const solve::StepResult& r,
                                            const Snapshot& s) const {
  const solve::NewtonResult& n = r.newton;
  const auto iterations = static_cast<double>(n.iterations), factorisations = static_cast<double>(n.factorisations),
             pivots = static_cast<double>(n.negative_pivots);
  if (dynamics_)
    return {static_cast<double>(state.step),
            state.time,
            r.taken,
            state.load_factor,
            iterations,
            factorisations,
            n.residual,
            pivots,
            static_cast<double>(r.rejections),
            s.kinetic,
            wall_seconds()};
  return {static_cast<double>(state.step),
          state.load_factor,
          iterations,
          factorisations,
          n.residual,
          pivots,
          r.critical ? static_cast<double>(r.critical->kind) : 0.0,
          r.critical && solve::is_located(*r.critical) ? r.critical->load_factor : std::nan(""),
          wall_seconds()};
}

void Recorder::write_history(const system::State& state, const solve::StepResult& r, const Snapshot& s) {
  std::vector<double> values = common_values(state, r, s);
  values.insert(values.end(), {s.validity.strain, s.validity.turn});
  if (keeps_balance())
    for (const auto& [name, value] : named_parts(state.balance)) values.push_back(value);
  if (model_->potential().has_yarn_friction())
    values.push_back(keeps_balance() ? state.balance.fabric : model_->potential().yarn_losses());
  if (!case_.stage.sew.empty()) values.push_back(seam_gap(case_, *mesh_, s.state.displacement));
  if (case_.remesh.active)
    values.insert(values.end(),
                  {static_cast<double>(mesh_->vertex_count()), static_cast<double>(state.remeshings.count)});
  if (case_.contact.input.active)
    values.insert(values.end(), {static_cast<double>(s.contact.pairs), s.contact.gap, static_cast<double>(r.cut_short),
                                 r.shortest, static_cast<double>(s.intersections)});
  if (model_->contact() && system::has_passable_obstacles(model_->contact()->scene().input()))
    values.push_back(static_cast<double>(system::passing_count(model_->contact()->memory())));
  if (model_->conditions().has_gas()) {
    const energy::Configuration c = model_->potential().configuration(state.u);
    for (const system::Gas& gas : model_->conditions().gases()) {
      const system::GasState now = gas.at(c);
      if (!std::isfinite(now.pressure))  // where all vertices that enclose it are held, no residual tells
        throw UserError(
            fmt::format("[[load]] type 'gas': what holds its surface leaves it a volume of {:.3g} m^3; "
                        "move supports or rigid groups less far",
                        now.volume));
      values.insert(values.end(), {now.volume, now.pressure, now.energy});
      if (gas.leaks()) values.insert(values.end(), {gas.content().fraction, gas.content().loss});
    }
  }
  values.insert(values.end(), s.bodies.begin(), s.bodies.end());
  mpi::on_root(model_->dofs().comm(), [&] {
    for (const double value : probes_->values(s.state, *model_)) values.push_back(value);
    if (history_) history_->write(values);
    if (options_.keep_history) kept_.rows.push_back(std::move(values));
  });
}

/// "12.3s elapsed, 4.5s left", or what is known of it.
std::string Recorder::clock_text(const std::string& left) const {
  return duration(wall_seconds()) + " elapsed" + (left == "-" ? "" : ", " + left + " left");
}

std::string Recorder::time_left(double end) const {
  const std::optional<double> left = time_left_.until(end);
  return left ? duration(*left) : "-";
}

void Recorder::print_motion(const system::State& state, const solve::StepResult& r, const Snapshot& s) const {
  const double end = case_.time.options.end_time;
  const std::string elapsed = duration(wall_seconds()), left = time_left(end);
  const std::string notes = (r.rejections > 0 ? fmt::format("  {} rejected", r.rejections) : "") + contact_note(s, r);
  if (rewrites_progress())
    return show_progress(fmt::format("step {}, t = {:.4g} of {:.4g} s, {} iterations, {}{}", state.step, state.time,
                                     end, r.newton.iterations, clock_text(left), notes));
  fmt::print("{:>6} {:>10.6g} {:>9.3g} {:>7} {:>10.2e} {:>10.3e} {:>9} {:>9}{}\n", state.step, state.time, r.taken,
             r.newton.iterations, r.newton.residual, s.kinetic, elapsed, left, notes);
  std::fflush(stdout);
}

void Recorder::print_path(const system::State& state, const solve::StepResult& r, const Snapshot& s) const {
  const double end = case_.steps.final_load_factor;
  const std::string elapsed = duration(wall_seconds());
  const std::string left = case_.steps.control == Control::load && state.load_factor < end ? time_left(end) : "-";
  const std::string pivots = r.newton.negative_pivots < 0 ? "-" : fmt::format("{}", r.newton.negative_pivots);
  std::string note = r.by_continuation ? "  by continuation" : "";
  note += contact_note(s, r);
  const std::string passed = r.critical ? fmt::format("{} passed", solve::name(r.critical->kind)) : "";
  if (r.critical)
    note += "  " + passed;
  else if (r.newton.negative_pivots > 0)
    note += "  UNSTABLE: the tangent is indefinite";
  if (rewrites_progress()) {
    if (r.critical) remark(fmt::format("step {}, load {:.6g}: {}", state.step, state.load_factor, passed));
    return show_progress(fmt::format("step {}, load {:.4g}, {} iterations, {}{}", state.step, state.load_factor,
                                     r.newton.iterations, clock_text(left), note));
  }
  fmt::print("{:>5} {:>10.6g} {:>7} {:>10.2e} {:>10} {:>9} {:>9}{}\n", state.step, state.load_factor,
             r.newton.iterations, r.newton.residual, pivots, elapsed, left, note);
  std::fflush(stdout);
}

void Recorder::progress(const std::string& text) const {
  if (!rewrites_progress()) return remark(text);
  if (root_ && options_.verbosity != Verbosity::quiet) show_progress(text + ", " + clock_text("-"));
}

void Recorder::remark(const std::string& text) const {
  if (!root_ || options_.verbosity == Verbosity::quiet) return;
  fmt::print("      {}\n", text);
  std::fflush(stdout);
}

double Recorder::wall_seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace voile::record
