#include "report.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "base/mpi.hpp"
#include "energy_text.hpp"
#include "probes.hpp"
#include "response.hpp"
#include "setup/free_motions.hpp"
#include "setup/gas_rims.hpp"
#include "setup/hinge_notes.hpp"
#include "setup/mesh_report.hpp"
#include "solve/convergence.hpp"
#include "validity.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace {

double process_cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string iterative_text(const solve::IterativeEffort& e) {
  if (e.iterations == 0) return "";
  return fmt::format(", {} systems solved by {} iterations of conjugate gradients{}", e.solutions, e.iterations,
                     e.shifted > 0 ? fmt::format(" ({} with a shift)", e.shifted) : "");
}

void print_header(const input::Case& c, const system::Model& model) {
  fmt::print("{}{}{}\n", c.file.filename().string(), c.title.empty() ? "" : ": ", c.title);
  fmt::print("{}", units_text(c));
  fmt::print("{} vertices, {} triangles, {} unknowns on {} rank(s)\n", model.dofs().mesh().vertex_count(),
             model.dofs().mesh().triangle_count(), model.dofs().unknowns(), mpi::size(model.dofs().comm()));
  if (model.dofs().mesh().reoriented_count() > 0)
    fmt::print("{} triangles were turned round to orient the surface\n", model.dofs().mesh().reoriented_count());
}

/// "converged ..., stable": whether the last state is an equilibrium, and of which kind.
std::string state_text(const input::Case& c, const Summary& s) {
  if (c.finds_modes() && s.eigen.empty()) return "converged: the response at every frequency";
  if (c.finds_modes()) return fmt::format("converged: {} modes", s.eigen.size());
  if (c.analysis == input::Analysis::dynamic) return "converged: every step";
  // Linear analysis looks at the sheet before the load.
  const bool unknown = s.negative_pivots < 0 || (c.analysis == input::Analysis::linear && s.negative_pivots == 0);
  return fmt::format("converged: residual {}{}", solve::part_of_forces(s.residual),
                     s.negative_pivots < 0    ? ", stability not known"
                     : unknown                ? ""
                     : s.negative_pivots == 0 ? ", a stable equilibrium"
                                              : ", an unstable equilibrium");
}

/// What cells do not resolve; empty where it is not estimated.
std::string resolved_text(const input::Case& c, const Summary& s) {
  const auto verdict = [](double x) { return x > error_limit ? "not resolved" : "resolved"; };
  if (c.analysis == input::Analysis::harmonic && s.mode_errors.empty())
    return "whether cells resolve the response is not estimated; give eigen.modes for that of its modes";
  if (!s.mode_errors.empty()) {
    double worst = 0.0;
    for (std::size_t i = 0; i < s.mode_errors.size(); ++i)
      if (counts(c, s.eigen, i)) worst = std::max(worst, s.mode_errors[i]);
    return fmt::format("{}: by estimate the modes are off by {}", verdict(worst), up_to_text(worst));
  }
  const DiscretisationError::Fractions& e = s.recovery_error;
  if (!std::isfinite(e.whole)) return "";
  std::string parts;
  if (std::isfinite(e.bending)) parts += fmt::format(", that of bending by {}", percent_text(e.bending));
  if (std::isfinite(e.membrane)) parts += fmt::format(", that of stretching by {}", percent_text(e.membrane));
  const bool late =
      c.analysis == input::Analysis::statics && e.whole <= error_limit && s.largest_recovery_error > error_limit;
  if (late) parts += fmt::format("; on the way the energy is off by {}", up_to_text(s.largest_recovery_error));
  const bool spurious = s.membrane_error > error_limit;
  if (spurious) parts += fmt::format("; {} of it should not be there", up_to_text(s.membrane_error));
  return fmt::format("{}{}: by estimate the energy is off by {}{}", verdict(spurious ? s.membrane_error : e.whole),
                     late ? " at the end" : "", percent_text(e.whole), parts);
}

/// Which ply fails first; empty without strengths.
std::string failure_text(const Summary& s) {
  if (!s.failure) return "";
  const FirstFailure& f = *s.failure;
  return fmt::format(
      "failure index {:.3g}: ply {} ({} face) at ({:.4g}, {:.4g}, {:.4g}) fails first, at {:.3g} times "
      "these stresses",
      f.index, f.ply, f.top ? "top" : "bottom", f.place[0], f.place[1], f.place[2], 1.0 / f.index);
}

/// What to type next, where there is something to look at.
std::string next_text(const input::Case& c, const std::string& folder, const Summary& s) {
  if (folder.empty() || c.is_staged()) return "";
  const std::string name =
      folder.find_first_of(" '\"\\$`!*?;&|<>()") == std::string::npos ? folder : "'" + folder + "'";
  return fmt::format("next: voile view {0}, or voile render {0} {1}--output picture.png", name,
                     s.eigen.empty() ? "" : "--mode 1 ");
}

/// The last lines of a run or stage.
void print_end(const input::Case& c, const std::string& folder, const Summary& s) {
  fmt::print("{} steps, {} Newton iterations, {} factorisations{}, {:.1f} CPU s, {:.1f} s{}\n", s.steps,
             s.newton_iterations, s.factorisations, iterative_text(s.iterative), s.cpu_seconds, s.wall_seconds,
             folder.empty() ? "" : "; results in " + folder);
  if (s.balance.kept) fmt::print("{}\n", balance_text(s.balance, s.round_off_energy));
  if (s.kinetic && s.kinetic->largest > 0.0) fmt::print("{}\n", rest_text(*s.kinetic));
  if (!s.converged) return;  // the reason follows on stderr
  for (const std::string& text : {state_text(c, s), resolved_text(c, s), failure_text(s), next_text(c, folder, s)})
    if (!text.empty()) fmt::print("{}\n", text);
}

/// What the mesh lets expect; with --quiet only if it is bad. Collective.
void report_mesh(const input::Case& c, const RunOptions& options, const system::Model& model) {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  setup::MeshQuality quality = setup::measure_quality(options.comm, mesh, c.element);
  quality.large_rotations = setup::is_nonlinear(c);
  const std::string uncorrected = setup::uncorrected_text(model.potential().uncorrected_triangles());
  mpi::on_root(options.comm, [&] {
    if (options.verbosity != Verbosity::quiet) {
      fmt::print("{}", setup::quality_text(mesh, quality, c.element));
      for (const std::string& text : c.notes) fmt::print("note: {}\n", text);
      for (const std::string& text :
           setup::mesh_notes(mesh, c.contact.input.active ? setup::Crossings::seen : setup::Crossings::noted))
        fmt::print("note: {}\n", text);
      for (const std::string& text : setup::sheet_notes(model.discretisation().sheet())) fmt::print("note: {}\n", text);
    }
    for (const std::string& text : setup::quality_warnings(mesh, quality, c.element)) fmt::print("warning: {}\n", text);
    for (const std::string& text : probe_warnings(c, mesh)) fmt::print("warning: {}\n", text);
    for (const std::string& text : setup::hinge_warnings(c, mesh)) fmt::print("warning: {}\n", text);
    if (const std::string text = setup::unit_warning(c, mesh); !text.empty()) fmt::print("warning: {}\n", text);
    if (const std::string text = setup::fold_warning(mesh, quality, c.element); !text.empty())
      fmt::print("warning: {}\n", text);
    if (!uncorrected.empty()) fmt::print("warning: {}\n", uncorrected);
  });
}

}  // namespace

std::string units_text(const input::Case& c) {
  const input::UnitSystem units(c.units);
  if (units.is_si()) return "";
  return fmt::format("units: {}, {}, {}; m, N, J, Pa, s and Hz in this text stand for {}, {}, {}, {}, {} and {}\n",
                     c.units.length, c.units.mass, c.units.time, units.label("m"), units.label("N"), units.label("J"),
                     units.label("Pa"), units.label("s"), units.label("Hz"));
}

double cpu_seconds(MPI_Comm comm) {
  return mpi::sum(comm, process_cpu_seconds());
}

void report_model(const input::Case& c, const RunOptions& options, const system::Model& model, bool first) {
  const bool talks = mpi::rank(options.comm) == 0 && options.verbosity != Verbosity::quiet;
  if (talks && first) print_header(c, model);
  if (talks && c.is_staged()) fmt::print("stage '{}': {}\n", c.stage.name, input::word_of(c.analysis));
  if (first || c.stage.begins_anew) report_mesh(c, options, model);
  for (const std::string& text : setup::moving_rims(c, model))
    if (talks) fmt::print("note: {}\n", text);
  for (const std::string& text : setup::check_free_motions(c, model))
    if (talks && c.analysis != input::Analysis::dynamic) fmt::print("note: {}\n", text);
}

void report_end(const input::Case& c, const RunOptions& options, const Summary& s) {
  const std::string folder = options.output.string();
  mpi::on_root(options.comm, [&] {
    if (!folder.empty()) write_summary(options.output, s);
    if (options.verbosity != Verbosity::quiet) print_end(c, folder, s);
    // Stages that sew pull things into their place; what that takes is not looked at, but nothing may come from nowhere.
    if (const std::string text = c.stage.sew.empty() ? balance_warning(s.balance, c.time.options, s.round_off_energy)
                                                     : creation_warning(s.balance, s.round_off_energy);
        s.balance.kept && !text.empty())
      fmt::print(stderr, "voile: warning: {}\n", text);
    if (s.unstable)
      fmt::print(
          stderr,
          "voile: warning: the last state is an unstable equilibrium ({} negative eigenvalue(s)): a real sheet leaves "
          "it; find the stable one with analysis = \"drape\", or follow the path with [steps] control = \"arc_length\" "
          "and at_critical_point = \"switch_branch\" (exit code {}{})\n",
          s.negative_pivots, static_cast<int>(Exit::unstable), c.is_staged() ? ", if no later stage leaves it" : "");
    if (!s.converged && !folder.empty())  // who names no folder asks for the reason
      fmt::print(stderr, "voile: {}not converged: {}; everything up to {} is in {}\n",
                 c.is_staged() ? fmt::format("stage '{}': ", c.stage.name) : "", s.reason,
                 c.analysis == input::Analysis::dynamic ? fmt::format("t = {:.6g} s", s.time)
                                                        : fmt::format("load factor {:.6g}", s.load_factor),
                 folder);
  });
}

}  // namespace voile::record
