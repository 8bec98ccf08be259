// The method on one page: build the model, follow the load path, record every equilibrium.
#include "voile/app/run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <fstream>

#include "recorder.hpp"
#include "voile/base/mpi.hpp"
#include "voile/base/petsc.hpp"
#include "voile/solve/static_path.hpp"

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

void write_summary(const std::filesystem::path& file, const system::Model& model, const solve::PathResult& path,
                   double cpu, double wall) {
  std::ofstream out(file);
  out << fmt::format(
      "{{\n  \"converged\": {},\n  \"load_factor\": {},\n  \"steps\": {},\n  \"newton_iterations\": {},\n"
      "  \"factorisations\": {},\n  \"unknowns\": {},\n  \"vertices\": {},\n  \"triangles\": {},\n  \"ranks\": {},\n"
      "  \"cpu_seconds\": {:.3f},\n  \"wall_seconds\": {:.3f}\n}}\n",
      path.completed, path.load_factor, path.steps, path.newton_iterations, path.factorisations, model.unknowns(),
      model.mesh().vertex_count(), model.mesh().triangle_count(), mpi::size(model.comm()), cpu, wall);
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

}  // namespace

Exit run(const Case& c, const RunOptions& options) {
  const bool root = mpi::rank(PETSC_COMM_WORLD) == 0;
  const mesh::SurfaceMesh mesh = load_mesh(c.mesh.file, c.mesh.options);
  system::Model model(PETSC_COMM_WORLD, mesh, {c.element, c.materials, c.supports, c.loads});
  if (root && options.verbosity != Verbosity::quiet) print_header(c, model);

  if (options.verbosity == Verbosity::verbose) show_iterations();
  mpi::on_root(PETSC_COMM_WORLD, [&] { make_output(c, options.output); });
  Recorder recorder(c, options, model);
  solve::StaticPath path(model, c.steps);
  path.on_step([&](const solve::StepReport& report, Vec a) { recorder.record(report, a); });
  path.on_remark([&](const std::string& text) { recorder.remark(text); });
  petsc::VecHandle a = model.create_vector();
  const solve::PathResult result = path.run(a);

  const double cpu = mpi::sum(PETSC_COMM_WORLD, process_cpu_seconds());
  mpi::on_root(PETSC_COMM_WORLD,
               [&] { write_summary(options.output / "summary.json", model, result, cpu, recorder.wall_seconds()); });
  if (root && options.verbosity != Verbosity::quiet)
    fmt::print("{} steps, {} Newton iterations, {} factorisations, {:.1f} CPU s, {:.1f} s; results in {}\n",
               result.steps, result.newton_iterations, result.factorisations, cpu, recorder.wall_seconds(),
               options.output.string());
  if (root && !result.completed)
    fmt::print(stderr, "voile: not converged: {}; everything up to load factor {:.6g} is in {}\n", result.reason,
               result.load_factor, options.output.string());
  return result.completed ? Exit::done : Exit::not_converged;
}

}  // namespace voile::app
