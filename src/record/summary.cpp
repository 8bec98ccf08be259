// What runs and stages came to, as JSON.
#include "summary.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <fstream>

#include "base/plain_file.hpp"
#include "history_columns.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* file_name = "summary.json";

Json json_of(const GarmentMeasures& m) {
  Json panels = Json::array(), seams = Json::array();
  for (const setup::PanelMeasures& p : m.panels)
    panels.push_back({{"name", p.name}, {"area", p.area}, {"allowance", p.allowance}, {"mass", p.mass}});
  for (const system::SeamTension& t : m.seams)
    seams.push_back({{"name", t.name},
                     {"length", t.length},
                     {"mean_tension", t.mean},
                     {"mean_tension_error", t.error},
                     {"largest_tension", t.largest}});
  Json all{{"panels", panels}, {"seams", seams}};
  if (m.ease) all["least_ease"] = m.ease->least;
  if (m.ease) all["mean_ease"] = m.ease->mean;
  if (m.largest_pressure) all["largest_contact_pressure"] = *m.largest_pressure;
  return all;
}

/// What summary.json in a folder holds; no object where that is damaged.
Json summary_in(const std::filesystem::path& folder) {
  std::ifstream in = open_input(folder / file_name);
  return Json::parse(in, nullptr, false);
}

Json json_of(const system::EnergyBalance& b) {
  Json all{{"initial_energy", b.initial}, {"kinetic_energy", b.kinetic}};
  for (const auto& [name, value] : named_parts(b)) all[name] = value;
  if (b.fabric != 0.0) all["fabric_loss"] = b.fabric;
  return all;
}

Json json_of(const KineticEnergy& k) {
  return {{"last", k.last}, {"largest", k.largest}, {"time_of_largest", k.time_of_largest}, {"at_rest", k.at_rest()}};
}

Json json_of(const system::ContactReport& r) {
  return {{"pairs", r.pairs},
          {"most_pairs_of_a_rank", r.most_pairs},
          {"candidates", r.candidates},
          {"most_candidates_of_a_rank", r.most_candidates}};
}

Json json_of(const FirstFailure& f) {
  return {{"failure_index", f.index},
          {"load_factor_left", f.index > 0.0 ? 1.0 / f.index : 0.0},
          {"ply", f.ply},
          {"face", f.top ? "top" : "bottom"},
          {"place", {f.place[0], f.place[1], f.place[2]}}};
}

Json json_of(const RemeshingEffort& r) {
  return {{"count", r.count},
          {"refused", r.refused},
          {"attempts", r.attempts},
          {"cpu_seconds", r.seconds},
          {"fraction", r.fraction}};
}

Json json_of(const std::vector<ResponsePeak>& peaks) {
  Json all = Json::array();
  for (const ResponsePeak& p : peaks) {
    const bool moves = p.unit == "m";
    Json one{{"probe", p.column}, {"largest_amplitude", p.amplitude}, {"frequency", p.frequency}};
    if (moves) one["largest_acceleration"] = p.acceleration;
    if (moves) one["frequency_of_acceleration"] = p.acceleration_frequency;
    if (p.mean) one[moves ? "rms_displacement" : p.unit == "N" ? "rms_reaction" : "rms_stress"] = *p.mean;
    if (p.mean_acceleration) one["rms_acceleration"] = *p.mean_acceleration;
    all.push_back(one);
  }
  return all;
}

Json json_of(const Summary& s) {
  Json critical = Json::array();
  for (const solve::CriticalPoint& p : s.critical) {
    critical.push_back({{"kind", solve::name(p.kind)}, {"step", p.step}, {"load_factor", p.load_factor}});
    if (p.between) critical.back()["between"] = *p.between;
  }
  Json all{{"converged", s.converged},
           {"element", s.element},
           {"angle_triangles", s.angle_triangles},
           {"load_factor", s.load_factor},
           {"steps", s.steps},
           {"newton_iterations", s.newton_iterations},
           {"factorisations", s.factorisations},
           {"iterative_solutions", s.iterative.solutions},
           {"iterative_iterations", s.iterative.iterations},
           {"iterative_shifted", s.iterative.shifted},
           {"negative_curvature", s.iterative.negative_curvature},
           {"critical_points", critical},
           {"eigenvalues", s.eigen},
           {"time", s.time},
           {"negative_pivots", s.negative_pivots},
           {"unstable", s.unstable},
           {"residual", s.residual},
           {"membrane_error", s.membrane_error},
           {"recovery_error", s.recovery_error.whole},
           {"recovery_error_of_bending", s.recovery_error.bending},
           {"recovery_error_of_stretching", s.recovery_error.membrane},
           {"largest_recovery_error", s.largest_recovery_error},
           {"eigenvalue_errors", s.mode_errors},
           {"unknowns", s.unknowns},
           {"vertices", s.vertices},
           {"triangles", s.triangles},
           {"ranks", s.ranks},
           {"cpu_seconds", s.cpu_seconds},
           {"wall_seconds", s.wall_seconds}};
  if (s.eigenvalue) all["eigenvalue_nearest_to_zero"] = *s.eigenvalue;
  if (!s.response.empty()) all["response"] = json_of(s.response);
  if (s.balance.kept) all["energy"] = json_of(s.balance);
  if (s.kinetic) all["motion"] = json_of(*s.kinetic);
  if (s.contact) all["contact"] = json_of(*s.contact);
  if (s.failure) all["first_ply_failure"] = json_of(*s.failure);
  if (s.garment) all["garment"] = json_of(*s.garment);
  if (s.remeshing) all["remeshing"] = json_of(*s.remeshing);
  return all;
}

void write(const std::filesystem::path& file, const Json& summary) {
  std::ofstream out(file);
  out << summary.dump(2) << '\n' << std::flush;
  if (!out) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

}  // namespace

void write_summary(const std::filesystem::path& folder, const Summary& s) {
  write(folder / file_name, json_of(s));
}

void write_stages(const std::filesystem::path& folder, const std::vector<std::string>& kept,
                  const std::vector<std::pair<std::string, Summary>>& stages, std::size_t of) {
  Json all = Json::array();
  bool converged = stages.size() == of;
  const auto add = [&all](const std::string& name, const Json& summary) {
    Json one{{"name", name}};
    one.update(summary);
    all.push_back(one);
  };
  for (const std::string& name : kept) {
    if (!std::filesystem::is_regular_file(folder / name / file_name)) continue;
    Json summary = summary_in(folder / name);
    if (!summary.is_object()) continue;
    summary["of_an_earlier_run"] = true;
    add(name, summary);
  }
  for (const auto& [name, s] : stages) {
    add(name, json_of(s));
    converged = converged && s.converged;
  }
  write(folder / file_name, {{"converged", converged}, {"stages", all}});
}

bool has_converged(const std::filesystem::path& folder) {
  const Json summary = summary_in(folder);
  return summary.is_object() && summary.value("converged", false);
}

}  // namespace voile::record
