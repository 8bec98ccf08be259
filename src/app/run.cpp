// The method on one page: build the model, follow the load path, record every equilibrium.
#include "voile/app/run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <optional>

#include "contact_start.hpp"
#include "free_motions.hpp"
#include "mesh_report.hpp"
#include "model_input.hpp"
#include "output_folder.hpp"
#include "recorder.hpp"
#include "restart.hpp"
#include "run_time.hpp"
#include "voile/base/interrupt.hpp"
#include "voile/base/mpi.hpp"
#include "voile/base/petsc.hpp"
#include "voile/base/text.hpp"
#include "voile/solve/eigen.hpp"
#include "voile/solve/path_following.hpp"

namespace voile::app {

namespace {

double process_cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void write_summary(const std::filesystem::path& file, const system::Model& model, const Summary& s, double cpu,
                   double wall) {
  using Json = nlohmann::ordered_json;
  Json critical = Json::array();
  for (const solve::CriticalPoint& p : s.critical)
    critical.push_back({{"kind", solve::name(p.kind)}, {"step", p.step}, {"load_factor", p.load_factor}});
  const Json summary{{"converged", s.converged},
                     {"load_factor", s.load_factor},
                     {"steps", s.steps},
                     {"newton_iterations", s.newton_iterations},
                     {"factorisations", s.factorisations},
                     {"critical_points", critical},
                     {"eigenvalues", s.eigen},
                     {"time", s.time},
                     {"negative_pivots", s.negative_pivots},
                     {"residual", s.residual},
                     {"unknowns", model.dofs().unknowns()},
                     {"vertices", model.mesh().vertex_count()},
                     {"triangles", model.mesh().triangle_count()},
                     {"ranks", mpi::size(model.comm())},
                     {"cpu_seconds", cpu},
                     {"wall_seconds", wall}};
  std::ofstream out(file);
  out << summary.dump(2) << '\n';
  if (!out) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

void print_header(const input::Case& c, const system::Model& model) {
  fmt::print("{}: {}\n", c.file.filename().string(), c.title);
  fmt::print("{} vertices, {} triangles, {} unknowns on {} rank(s)\n", model.mesh().vertex_count(),
             model.mesh().triangle_count(), model.dofs().unknowns(), mpi::size(model.comm()));
  if (model.mesh().reoriented_count() > 0)
    fmt::print("{} triangles were turned round to orient the surface\n", model.mesh().reoriented_count());
}

/// What the mesh lets expect; with --quiet only if it is bad. Collective.
void report_mesh(const input::Case& c, const RunOptions& options, const system::Model& model) {
  const mesh::SurfaceMesh& mesh = model.mesh();
  const MeshQuality quality = measure_quality(PETSC_COMM_WORLD, mesh, c.element);
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    if (options.verbosity != Verbosity::quiet) {
      fmt::print("{}", quality_text(mesh, quality, c.element));
      for (const std::string& text : mesh_notes(mesh)) fmt::print("note: {}\n", text);
      for (const std::string& text : sheet_notes(model.sheet())) fmt::print("note: {}\n", text);
    }
    for (const std::string& text : quality_warnings(mesh, quality, c.element)) fmt::print("warning: {}\n", text);
  });
}

/// --verbose shows every Newton iteration, exactly as -snes_monitor does.
void show_iterations() {
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-snes_monitor", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-snes_monitor", nullptr));
}

/// Runs one way of following a path, with every accepted state recorded.
template <class Path>
Summary follow(Path path, Recorder& recorder, Vec a, const solve::PathStart& start, std::string& reason) {
  path.on_step([&](const solve::StepReport& report, Vec state) { recorder.record(report, state); });
  path.on_remark([&](const std::string& text) { recorder.remark(text); });
  const solve::PathResult r = path.run(a, start);
  reason = r.reason;
  Summary s;
  s.converged = r.completed;
  s.load_factor = r.load_factor;
  s.steps = r.steps;
  s.newton_iterations = r.newton_iterations;
  s.factorisations = r.factorisations;
  s.critical = r.critical;
  return s;
}

Summary summary_of(const solve::NewtonResult& n, double load_factor, int steps) {
  Summary s;
  s.converged = n.converged;
  s.load_factor = load_factor;
  s.steps = steps;
  s.newton_iterations = n.iterations;
  s.factorisations = n.factorisations;
  s.negative_pivots = n.negative_pivots;
  s.residual = n.residual;
  return s;
}

Summary run_static(system::Model& model, const solve::StaticOptions& steps, Recorder& recorder, Vec a,
                   const Restart& restart, std::string& reason) {
  const solve::PathStart& start = restart.start;
  if (restart.from_motion) {  // a path begins in equilibrium
    model.set_load_factor(start.load_factor);
    solve::Newton newton(model);
    const solve::NewtonResult n = newton.continuation(a);
    if (!n.converged) {
      reason = "no equilibrium found near the start: " + n.reason;
      return summary_of(n, start.load_factor, 0);
    }
  }
  if (steps.control == solve::StaticOptions::Control::load)
    return follow(solve::StaticPath(model, steps), recorder, a, start, reason);
  const petsc::VecHandle probe =
      steps.control_probe.empty() ? petsc::VecHandle{} : recorder.functional(steps.control_probe);
  return follow(solve::PathFollower(model, steps, probe), recorder, a, start, reason);
}

Summary run_linear(system::Model& model, double load_factor, Recorder& recorder, Vec a, std::string& reason) {
  solve::Newton newton(model);
  recorder.record({.step = 0, .load_factor = 0.0, .newton = {}, .critical = {}}, a);
  model.set_load_factor(load_factor);
  const solve::NewtonResult n = newton.linear_step(a);
  if (!n.converged) reason = n.reason;
  if (n.converged)
    recorder.record({.step = 1, .load_factor = load_factor, .newton = n, .last = true, .critical = {}}, a);
  return summary_of(n, load_factor, 1);
}

/// The equilibrium about which modes are found: that of --restart, the end of the path, or the unloaded state under
/// constant loads.
Summary run_base_state(const input::Case& c, system::Model& model, const solve::StaticOptions& steps,
                       Recorder& recorder, Vec a, const Restart& restart, std::string& reason) {
  if (!restart.given && c.eigen.load_factor > 0.0) return run_static(model, steps, recorder, a, restart, reason);
  solve::NewtonResult n;
  n.converged = true;
  model.set_load_factor(restart.start.load_factor);
  const bool constant = std::any_of(c.loads.begin(), c.loads.end(), [](const system::Load& l) { return l.constant; });
  if (constant && !restart.given) {
    solve::Newton newton(model);
    n = newton.step(a);
    if (!n.converged) {
      VOILE_PETSC(VecZeroEntries(a));
      n = newton.continuation(a);
    }
  }
  if (!n.converged) reason = n.reason;
  recorder.record(
      {.step = restart.start.step, .load_factor = restart.start.load_factor, .newton = n, .last = true, .critical = {}},
      a);
  return summary_of(n, restart.start.load_factor, 0);
}

void write_modes(const input::Case& c, const RunOptions& options, const system::Model& model,
                 const solve::EigenResult& result) {
  const bool vibration = c.analysis == "modal";
  std::optional<io::ResultsWriter> fields;
  std::optional<io::HistoryWriter> table;
  mpi::on_root(model.comm(), [&] {
    const mesh::Partition& p = model.dofs().partition();
    fields.emplace(options.output / "modes", model.mesh(), p.vertex_rank, p.triangle_rank);
    table.emplace(options.output / "modes.csv",
                  std::vector<std::string>{"mode", vibration ? "frequency_hz" : "critical_load_factor", "eigenvalue",
                                           "residual"});
  });
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const solve::Mode& mode = result.modes[i];
    std::vector<double> shape = model.dofs().gather(mode.shape);
    mpi::on_root(model.comm(), [&] {
      const int number = static_cast<int>(i) + 1;
      table->write({static_cast<double>(number), mode.value, mode.eigenvalue, mode.residual});
      io::StepFields step{number, static_cast<double>(number), model.load_factor(), {}};
      step.fields.push_back({"mode", "1", io::Centre::vertex, 3, std::move(shape)});
      fields->write(step);
      if (options.verbosity != Verbosity::quiet)
        fmt::print("{:>5} {:>16.8g} {:>12.2e}\n", number, mode.value, mode.residual);
    });
  }
}

/// Modes about the state `a`; appends them to the summary.
void run_modes(const input::Case& c, const RunOptions& options, system::Model& model, Vec a, Summary& summary,
               std::string& reason) {
  const bool vibration = c.analysis == "modal", root = mpi::rank(model.comm()) == 0;
  const auto find = [&] {
    if (vibration) return solve::vibration_modes(model, a, c.eigen.modes, c.eigen.mass);
    solve::Newton newton(model);
    return solve::buckling_modes(newton, model, a, c.eigen.modes);
  };
  const solve::EigenResult result = find();
  if (root && options.verbosity != Verbosity::quiet)
    fmt::print("{:>5} {:>16} {:>12}\n", "mode", vibration ? "frequency [Hz]" : "load factor", "residual");
  write_modes(c, options, model, result);
  for (const solve::Mode& mode : result.modes) summary.eigen.push_back(mode.value);
  summary.converged = static_cast<int>(result.modes.size()) >= result.asked_for;
  if (!summary.converged)
    reason = fmt::format("{} of {} modes found{}", result.modes.size(), result.asked_for,
                         vibration ? "" : " (a load can have fewer critical factors)");
  if (SignalScope::stop_asked(model.comm())) {
    summary.converged = false;
    reason =
        fmt::format("{}; {} of {} modes had been found", Interrupted().what(), result.modes.size(), result.asked_for);
  }
}

}  // namespace

namespace {

void scatter_start(const system::Model& model, const io::Checkpoint& from, Vec a) {
  std::vector<double> u = from.displacement;
  u.resize(static_cast<std::size_t>(model.dofs().unknowns()), 0.0);
  model.dofs().scatter(u, a);
}

}  // namespace

Exit run(const input::Case& given, const RunOptions& options) {
  input::Case c = given;
  const SignalScope signals;
  const bool root = mpi::rank(PETSC_COMM_WORLD) == 0;
  const mesh::SurfaceMesh mesh = load_mesh(c.mesh.file, c.mesh.options);
  const system::ModelInput input = model_input(c);
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  if (root && options.verbosity != Verbosity::quiet) print_header(c, model);
  report_mesh(c, options, model);
  for (const std::string& text : check_free_motions(c, model))
    if (root && options.verbosity != Verbosity::quiet && c.analysis != "dynamic") fmt::print("note: {}\n", text);

  if (options.verbosity == Verbosity::verbose) show_iterations();
  solve::StaticOptions steps = c.steps;
  solve::read_path_options(model.comm(), steps);
  const bool modes = c.analysis == "modal" || c.analysis == "buckling", in_time = c.analysis == "dynamic";
  if (modes) {
    steps.final_load_factor = c.eigen.load_factor;
    std::erase_if(steps.stops, [&](double stop) { return stop > c.eigen.load_factor; });
  }
  if (in_time) solve::read_time_options(c.time.options);
  if (in_time || c.analysis == "modal") system::require_mass(model);
  // Whatever is wrong with a restart must show before old results in the output folder go.
  petsc::VecHandle a = model.dofs().create_vector();
  const Restart restart = in_time ? Restart{} : read_restart(c, options, model, a);
  io::Checkpoint checkpoint = in_time ? read_start(c, options, model) : io::Checkpoint{};
  std::optional<OutputFolder> folder;
  mpi::on_root(PETSC_COMM_WORLD, [&] { folder.emplace(c, options); });
  if (model.contact()) {
    if (in_time) scatter_start(model, checkpoint, a);
    model.contact()->restore({checkpoint.contact_gaps, checkpoint.contact_start, checkpoint.yielding});
    const bool moved = settle_start(c, options, *model.contact(), a, checkpoint.time);
    if (moved && in_time) checkpoint.displacement = model.dofs().gather(a);
  }
  Recorder recorder(c, options, model, steps);

  Summary summary;
  std::string reason;
  try {
    if (c.analysis == "static")
      summary = run_static(model, steps, recorder, a, restart, reason);
    else if (c.analysis == "linear")
      summary = run_linear(model, c.steps.final_load_factor, recorder, a, reason);
    else if (in_time)
      summary = run_dynamic(c, options, input, model, recorder, checkpoint, reason);
    else if (c.analysis == "drape")
      summary = run_drape(c, model, recorder, a, reason);
    else
      summary = run_base_state(c, model, steps, recorder, a, restart, reason);
    if (summary.converged && modes) run_modes(c, options, model, a, summary, reason);
  } catch (const Interrupted& e) {
    summary.converged = false;
    reason = e.what();
  }
  recorder.finish();

  const double cpu = mpi::sum(PETSC_COMM_WORLD, process_cpu_seconds());
  mpi::on_root(PETSC_COMM_WORLD,
               [&] { write_summary(options.output / "summary.json", model, summary, cpu, recorder.wall_seconds()); });
  if (root && options.verbosity != Verbosity::quiet)
    fmt::print("{} steps, {} Newton iterations, {} factorisations, {:.1f} CPU s, {:.1f} s; results in {}\n",
               summary.steps, summary.newton_iterations, summary.factorisations, cpu, recorder.wall_seconds(),
               options.output.string());
  if (root && !summary.converged)
    fmt::print(
        stderr, "voile: not converged: {}; everything up to {} is in {}\n", reason,
        in_time ? fmt::format("t = {:.6g} s", summary.time) : fmt::format("load factor {:.6g}", summary.load_factor),
        options.output.string());
  return summary.converged ? Exit::done : Exit::not_converged;
}

}  // namespace voile::app
