#include "recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"

namespace voile::app {

namespace {

constexpr std::array<const char*, 3> axis{"x", "y", "z"};

Index nearest_vertex(const mesh::SurfaceMesh& mesh, const Vec3& point) {
  Index best = 0;
  for (Index v = 1; v < mesh.vertex_count(); ++v)
    if ((mesh.positions()[v] - point).squaredNorm() < (mesh.positions()[best] - point).squaredNorm()) best = v;
  return best;
}

std::string duration(double seconds) {
  const auto s = static_cast<long>(std::max(0.0, seconds));
  if (s < 100) return fmt::format("{:.1f}s", seconds);
  if (s < 6000) return fmt::format("{}m{:02}s", s / 60, s % 60);
  return fmt::format("{}h{:02}m", s / 3600, s / 60 % 60);
}

}  // namespace

Recorder::Recorder(const Case& c, const RunOptions& options, system::Model& model)
    : case_(c), options_(options), model_(model), root_(mpi::rank(model.comm()) == 0) {
  resolve_probes();
  mpi::on_root(model.comm(), [&] {
    const mesh::Partition& p = model.partition();
    results_.emplace(options.output, model.mesh(), p.vertex_rank, p.triangle_rank);
    history_.emplace(options.output / "history.csv", columns());
  });
  if (root_ && options.verbosity != Verbosity::quiet)
    fmt::print("{:>5} {:>10} {:>7} {:>10} {:>10} {:>9} {:>9}\n", "step", "load", "newton", "residual", "neg.pivots",
               "elapsed", "left");
}

void Recorder::resolve_probes() {
  for (const Probe& probe : case_.probes) {
    ProbeVertices v;
    v.components = probe.components;
    if (v.components.empty()) v.components = {0, 1, 2};
    if (probe.kind != Probe::Kind::energy)
      v.vertices = probe.point ? std::vector<Index>{nearest_vertex(model_.mesh(), *probe.point)}
                               : model_.mesh().group(probe.group).vertices;
    probes_.push_back(std::move(v));
  }
}

std::vector<std::string> Recorder::columns() const {
  std::vector<std::string> names{"step",     "load_factor",     "newton_iterations", "factorisations",
                                 "residual", "negative_pivots", "wall_seconds"};
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    if (case_.probes[p].kind == Probe::Kind::energy)
      for (const char* part : {"membrane", "bending", "external"})
        names.push_back(fmt::format("{}_{}", case_.probes[p].name, part));
    else
      for (int k : probes_[p].components) names.push_back(fmt::format("{}_{}", case_.probes[p].name, axis[k]));
  }
  return names;
}

bool Recorder::wants(const std::string& field) const {
  const auto& f = case_.output.fields;
  return f.empty() || std::find(f.begin(), f.end(), field) != f.end();
}

void Recorder::record(const solve::StepReport& report, Vec a) {
  const petsc::EventScope scope(petsc::events().output);
  petsc::VecHandle force = model_.create_vector();
  model_.unbalanced_force(a, force);
  {  // away from supports the force is only the residual that is left
    std::vector<char> fixed(static_cast<std::size_t>(model_.partition().owned_count(mpi::rank(model_.comm()))) * 3, 0);
    const mesh::Partition& p = model_.partition();
    const Index first = p.owned_begin(mpi::rank(model_.comm()));
    for (const auto& [v, support] : model_.constraints().vertices)
      if (p.vertex_rank[v] == mpi::rank(model_.comm()))
        for (int k = 0; k < 3; ++k) fixed[3 * (p.row_of[v] - first) + k] = support.fixed[k];
    const petsc::WriteArray f(force);
    for (std::size_t i = 0; i < fixed.size(); ++i)
      if (!fixed[i]) f[static_cast<PetscInt>(i)] = 0.0;
  }
  std::vector<double> displacement = model_.gather(a), reaction = model_.gather(force);
  const bool energy_wanted = std::any_of(case_.probes.begin(), case_.probes.end(),
                                         [](const Probe& p) { return p.kind == Probe::Kind::energy; });
  const system::Energies energies = energy_wanted ? model_.energies(a) : system::Energies{};
  mpi::on_root(model_.comm(), [&] { write_history(report, displacement, reaction, energies); });
  if (report.step % case_.output.every == 0 || report.last)
    write_fields(report, a, std::move(displacement), std::move(reaction));
  if (root_ && options_.verbosity != Verbosity::quiet) print(report);
}

void Recorder::write_history(const solve::StepReport& report, const std::vector<double>& displacement,
                             const std::vector<double>& reaction, const system::Energies& energies) {
  const solve::NewtonResult& n = report.newton;
  std::vector<double> values{static_cast<double>(report.step),
                             report.load_factor,
                             static_cast<double>(n.iterations),
                             static_cast<double>(n.factorisations),
                             n.residual,
                             static_cast<double>(n.negative_pivots),
                             wall_seconds()};
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    const Probe::Kind kind = case_.probes[p].kind;
    if (kind == Probe::Kind::energy) {
      values.insert(values.end(), {energies.membrane, energies.bending, energies.external});
      continue;
    }
    const std::vector<double>& field = kind == Probe::Kind::displacement ? displacement : reaction;
    for (int k : probes_[p].components) {
      double sum = 0.0;
      for (Index v : probes_[p].vertices) sum += field[3 * static_cast<std::size_t>(v) + k];
      values.push_back(kind == Probe::Kind::displacement ? sum / static_cast<double>(probes_[p].vertices.size()) : sum);
    }
  }
  history_->write(values);
}

void Recorder::write_fields(const solve::StepReport& report, Vec a, std::vector<double> displacement,
                            std::vector<double> reaction) {
  system::TriangleFields t = model_.triangle_fields(a);
  mpi::on_root(model_.comm(), [&] {
    io::StepFields step;
    step.step = report.step;
    step.time = report.load_factor;
    const auto add = [&](const char* name, const char* unit, io::Centre centre, std::vector<double>& values) {
      if (wants(name)) step.fields.push_back({name, unit, centre, 3, std::move(values)});
    };
    add("displacement", "m", io::Centre::vertex, displacement);
    add("reaction", "N", io::Centre::vertex, reaction);
    add("membrane_strain", "1", io::Centre::triangle, t.membrane_strain);
    add("membrane_force", "N/m", io::Centre::triangle, t.membrane_force);
    add("curvature", "1/m", io::Centre::triangle, t.curvature);
    add("bending_moment", "N", io::Centre::triangle, t.bending_moment);
    results_->write(step);
  });
}

void Recorder::print(const solve::StepReport& report) const {
  if (report.step == 0) return;
  const double elapsed = wall_seconds(), done = report.load_factor / case_.steps.final_load_factor;
  const std::string left = report.last || !(done > 0.0) ? "-" : duration(elapsed / done - elapsed);
  const std::string pivots = report.newton.negative_pivots < 0 ? "-" : fmt::format("{}", report.newton.negative_pivots);
  std::string note = report.by_continuation ? "  by continuation" : "";
  if (report.newton.negative_pivots > 0) note += "  UNSTABLE: the tangent is indefinite";
  fmt::print("{:>5} {:>10.6g} {:>7} {:>10.2e} {:>10} {:>9} {:>9}{}\n", report.step, report.load_factor,
             report.newton.iterations, report.newton.residual, pivots, duration(elapsed), left, note);
  std::fflush(stdout);
}

void Recorder::remark(const std::string& text) const {
  if (root_ && options_.verbosity != Verbosity::quiet) fmt::print("      {}\n", text);
}

double Recorder::wall_seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace voile::app
