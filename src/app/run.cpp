// The method on one page: build the model, follow the load path, record every equilibrium.
#include "voile/app/run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <optional>

#include "contact_start.hpp"
#include "obstacles.hpp"
#include "recorder.hpp"
#include "run_time.hpp"
#include "voile/base/mpi.hpp"
#include "voile/base/petsc.hpp"
#include "voile/base/text.hpp"
#include "voile/io/stored_step.hpp"
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
  std::vector<std::string> critical;
  for (const solve::CriticalPoint& p : s.critical)
    critical.push_back(fmt::format("{{\"kind\": \"{}\", \"step\": {}, \"load_factor\": {}}}", solve::name(p.kind),
                                   p.step, p.load_factor));
  std::ofstream out(file);
  out << fmt::format(
      "{{\n  \"converged\": {},\n  \"load_factor\": {},\n  \"steps\": {},\n  \"newton_iterations\": {},\n"
      "  \"factorisations\": {},\n  \"critical_points\": [{}],\n  \"eigenvalues\": [{}],\n"
      "  \"time\": {},\n  \"negative_pivots\": {},\n  \"residual\": {:.6g},\n  \"unknowns\": {},\n"
      "  \"vertices\": {},\n  \"triangles\": {},\n  \"ranks\": {},\n  \"cpu_seconds\": {:.3f},\n"
      "  \"wall_seconds\": {:.3f}\n}}\n",
      s.converged, s.load_factor, s.steps, s.newton_iterations, s.factorisations, join(critical, ", "),
      join(s.eigen, ", "), s.time, s.negative_pivots, s.residual, model.unknowns(), model.mesh().vertex_count(),
      model.mesh().triangle_count(), mpi::size(model.comm()), cpu, wall);
  if (!out) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

void make_output(const Case& c, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::ofstream echo(folder / "case.toml");
  echo << echo_case(c);
  if (error || !echo) throw UserError(fmt::format("--output {}: the folder cannot be written", folder.string()));
}

void print_header(const Case& c, const system::Model& model) {
  fmt::print("{}: {}\n", c.file.filename().string(), c.title);
  fmt::print("{} vertices, {} triangles, {} unknowns on {} rank(s)\n", model.mesh().vertex_count(),
             model.mesh().triangle_count(), model.unknowns(), mpi::size(model.comm()));
  if (model.mesh().reoriented_count() > 0)
    fmt::print("{} triangles were turned round to orient the surface\n", model.mesh().reoriented_count());
  print_warnings(model.mesh(), c.element);
}

/// --verbose shows every Newton iteration, exactly as -snes_monitor does.
void show_iterations() {
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-snes_monitor", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-snes_monitor", nullptr));
}

/// The state that --restart names, scattered into unknowns.
struct Restart {
  bool given = false;
  petsc::VecHandle previous;
  solve::PathStart start;
};

Restart read_restart(const Case& c, const RunOptions& options, const system::Model& model, Vec a) {
  Restart r;
  if (options.restart.empty()) return r;
  if (c.analysis == "linear")
    throw UserError("--restart: analysis = \"linear\" starts from the unloaded state; leave the option out");
  check_restart_folder(model.comm(), options);
  io::StoredStep stored;
  std::vector<double> numbers(3);
  mpi::on_root(model.comm(), [&] {
    stored = io::read_step(options.restart, options.restart_step, model.mesh());
    numbers = {static_cast<double>(stored.step), stored.load_factor, stored.previous.empty() ? 0.0 : 1.0};
  });
  mpi::broadcast(model.comm(), numbers);
  r.given = true;
  r.start.step = static_cast<int>(numbers[0]);
  r.start.load_factor = numbers[1];
  model.scatter(stored.displacement, a);
  if (numbers[2] > 0.0) {
    r.previous = model.create_vector();
    model.scatter(stored.previous, r.previous);
    r.start.previous = r.previous;
  }
  return r;
}

}  // namespace

void check_restart_folder(MPI_Comm comm, const RunOptions& options) {
  mpi::on_root(comm, [&] {
    std::error_code ignored;
    const std::filesystem::path folder = options.restart.parent_path().empty() ? "." : options.restart.parent_path();
    if (std::filesystem::equivalent(folder, options.output, ignored))
      throw UserError(
          fmt::format("--restart {}: this run would overwrite it; choose another --output", options.restart.string()));
  });
}

namespace {

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

Summary run_static(system::Model& model, const solve::StaticOptions& steps, Recorder& recorder, Vec a,
                   const solve::PathStart& start, std::string& reason) {
  if (steps.control == solve::StaticOptions::Control::load)
    return follow(solve::StaticPath(model, steps), recorder, a, start, reason);
  const petsc::VecHandle probe =
      steps.control_probe.empty() ? petsc::VecHandle{} : recorder.functional(steps.control_probe);
  return follow(solve::PathFollower(model, steps, probe), recorder, a, start, reason);
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
Summary run_base_state(const Case& c, system::Model& model, const solve::StaticOptions& steps, Recorder& recorder,
                       Vec a, const Restart& restart, std::string& reason) {
  if (!restart.given && c.eigen.load_factor > 0.0) return run_static(model, steps, recorder, a, {}, reason);
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

void write_modes(const Case& c, const RunOptions& options, const system::Model& model,
                 const solve::EigenResult& result) {
  const bool vibration = c.analysis == "modal";
  std::optional<io::ResultsWriter> fields;
  std::optional<io::HistoryWriter> table;
  mpi::on_root(model.comm(), [&] {
    const mesh::Partition& p = model.partition();
    fields.emplace(options.output / "modes", model.mesh(), p.vertex_rank, p.triangle_rank);
    table.emplace(options.output / "modes.csv",
                  std::vector<std::string>{"mode", vibration ? "frequency_hz" : "critical_load_factor", "eigenvalue",
                                           "residual"});
  });
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const solve::Mode& mode = result.modes[i];
    std::vector<double> shape = model.gather(mode.shape);
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
void run_modes(const Case& c, const RunOptions& options, system::Model& model, Vec a, Summary& summary,
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
}

}  // namespace

namespace {

void scatter_start(const system::Model& model, const io::Checkpoint& from, Vec a) {
  std::vector<double> u = from.displacement;
  u.resize(static_cast<std::size_t>(model.unknowns()), 0.0);
  model.scatter(u, a);
}

}  // namespace

Exit run(const Case& given, const RunOptions& options) {
  Case c = given;
  const bool root = mpi::rank(PETSC_COMM_WORLD) == 0;
  const mesh::SurfaceMesh mesh = load_mesh(c.mesh.file, c.mesh.options);
  system::Model model(PETSC_COMM_WORLD, mesh,
                      {c.element, c.materials, c.supports, c.loads, contact_input(PETSC_COMM_WORLD, c)});
  if (root && options.verbosity != Verbosity::quiet) print_header(c, model);

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
  petsc::VecHandle a = model.create_vector();
  const Restart restart = in_time ? Restart{} : read_restart(c, options, model, a);
  io::Checkpoint checkpoint = in_time ? read_start(options, model) : io::Checkpoint{};
  mpi::on_root(PETSC_COMM_WORLD, [&] { make_output(c, options.output); });
  if (model.contact()) {
    if (in_time) scatter_start(model, checkpoint, a);
    const bool moved = settle_start(c, options, *model.contact(), a, checkpoint.time);
    if (moved && in_time) checkpoint.displacement = model.gather(a);
  }
  Recorder recorder(c, options, model, steps);

  Summary summary;
  std::string reason;
  if (c.analysis == "static")
    summary = run_static(model, steps, recorder, a, restart.start, reason);
  else if (c.analysis == "linear")
    summary = run_linear(model, c.steps.final_load_factor, recorder, a, reason);
  else if (in_time)
    summary = run_dynamic(c, options, model, recorder, checkpoint, reason);
  else if (c.analysis == "drape")
    summary = run_drape(c, model, recorder, a, reason);
  else
    summary = run_base_state(c, model, steps, recorder, a, restart, reason);
  if (summary.converged && modes) run_modes(c, options, model, a, summary, reason);

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
