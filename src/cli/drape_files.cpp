#include "drape_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/text.hpp"
#include "begin.hpp"
#include "results/stored_step.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The plate sinks so fast [m/s], so far beyond the overhang [m], and the specimen then has so long to come to rest [s].
constexpr double plate_speed = 0.03, plate_beyond = 0.005, rest_time = 1.5;
/// Root mean square over the mass below which a specimen is at rest [m/s].
constexpr double rest_speed = 1e-3;

double radius_of(const DrapeSetting& s) {
  return 0.5e-3 * s.test.specimen;
}

constexpr const char* geometry = R"(// A specimen of fabric without the part that the discs of 180 mm hold. Metres.
SetFactory("OpenCASCADE");
Disk(1) = {{ {:.9f}, {:.9f}, 0, {:.9f} }};
Disk(2) = {{ 0, 0, 0, 0.09 }};
BooleanDifference(3) = {{ Surface{{1}}; Delete; }}{{ Surface{{2}}; Delete; }};
Physical Surface("overhang") = {{ 3 }};
inner() = Curve In BoundingBox {{ -0.0901, -0.0901, -1, 0.0901, 0.0901, 1 }};
Physical Curve("held") = {{ inner() }};
MeshSize {{ : }} = {:.6f};
)";

constexpr const char* common = R"([mesh]
file = "specimen.geo"

[[material]]
type = "fabric"
fabric = {}
direction = [1, 0, 0]
warp_angle = {}
hysteresis = "{}"

[[support]]
group = "held"
type = "clamped"

[[load]]
type = "gravity"
vector = [0, 0, -9.80665]
)";

constexpr const char* lowered = R"(
[contact]
distance = 5e-4

[[obstacle]]
name = "plate"
type = "plane"
point = [0, 0, -5e-4]
normal = [0, 0, 1]
motion = ["0", "0", "-{:g}*t"]

[time]
end = {:.4f}
step = 0.01
max_step = 0.02
velocity_tolerance = 3e-4

[damping]
mass = 5.0

[air]
normal_drag = 1.3
)";

constexpr const char* growing = R"(
[steps]
initial_step = 0.002
max_step = 0.1
)";

/// Rest and present positions of the edge of the specimen, in order.
std::vector<Vec3> edge_of(const DrapeSetting& s, const DrapeRepeat& r, const mesh::MeshData& mesh,
                          const std::vector<Vec3>& places) {
  const Vec3 centre(r.x, r.y, 0.0);
  std::vector<std::pair<double, Index>> order;
  for (Index v = 0; v < static_cast<Index>(mesh.positions.size()); ++v) {
    const Vec3 arm = mesh.positions[v] - centre;
    if (arm.norm() > (1.0 - 1e-5) * radius_of(s)) order.emplace_back(std::atan2(arm.y(), arm.x()), v);
  }
  std::sort(order.begin(), order.end());
  std::vector<Vec3> edge;
  for (const auto& [angle, v] : order) edge.push_back(places[v]);
  return edge;
}

Json read_summary(const fs::path& file) {
  std::ifstream in(file);
  return in ? Json::parse(in, nullptr, false) : Json();
}

Json json_of(const DrapeRepeat& r) {
  Json folds = Json::array();
  for (const DrapeFold& f : r.shape.folds)
    folds.push_back({{"angle_deg", f.angle * 180.0 / std::numbers::pi},
                     {"amplitude_mm", 1e3 * f.amplitude},
                     {"wavelength_deg", f.wavelength * 180.0 / std::numbers::pi}});
  return {{"converged", r.converged},
          {"at_rest", r.at_rest},
          {"shift_mm", {1e3 * r.x, 1e3 * r.y}},
          {"warp_angle_deg", r.warp},
          {"drape_coefficient", 100.0 * r.shape.coefficient},
          {"fold_count", r.shape.folds.size()},
          {"folds", folds},
          {"amplitude_variation", r.shape.amplitude_variation},
          {"wavelength_variation", r.shape.wavelength_variation},
          {"recovery_error", r.recovery_error},
          {"cpu_seconds", r.cpu_seconds}};
}

/// The edge of a repeat as CSV, and what draws it.
void write_contour(const fs::path& file, const DrapeRepeat& r) {
  std::string table = "x_mm,y_mm,z_mm,radius_mm\n";
  for (std::size_t i = 0; i <= r.edge.size(); ++i) {
    const Vec3 p = 1e3 * r.edge[i % r.edge.size()];
    table += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}\n", p.x(), p.y(), p.z(), std::hypot(p.x(), p.y()));
  }
  write_drape_file(file, table);
}

void write_circles(const DrapeSetting& s, const fs::path& file) {
  std::string table = "support_x,support_y,specimen_x,specimen_y\n";
  for (int k = 0; k <= 180; ++k) {
    const double a = k * std::numbers::pi / 90.0, in = 1e3 * drape_support_radius, out = 1e3 * radius_of(s);
    table += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}\n", in * std::cos(a), in * std::sin(a), out * std::cos(a),
                         out * std::sin(a));
  }
  write_drape_file(file, table);
}

}  // namespace

void write_drape_file(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

std::string specimen_text(const DrapeSetting& s, const DrapeRepeat& r, bool friction) {
  std::error_code error;
  fs::create_directories(r.folder, error);
  if (error) throw UserError(fmt::format("{}: the folder cannot be made ({})", r.folder.string(), error.message()));
  write_drape_file(r.folder / "specimen.geo", fmt::format(geometry, r.x, r.y, radius_of(s), r.cell));
  return fmt::format(common, toml_text(s.fabric_file.string()), r.warp, friction ? "friction" : "damping");
}

void write_drape_case(const DrapeSetting& s, const DrapeRepeat& r) {
  const bool plate = s.test.method == DrapeTest::Method::plate;
  std::string text = fmt::format("title = \"Drape test\"\nanalysis = \"{}\"\n\n", plate ? "dynamic" : "static");
  text += specimen_text(s, r, s.friction);
  const double way = radius_of(s) - drape_support_radius + plate_beyond;
  text += plate ? fmt::format(lowered, plate_speed, way / plate_speed + rest_time) : growing;
  write_drape_file(r.folder / "case.toml", text + "\n[output]\nevery = 1000\nfields = [\"displacement\"]\n");
}

void read_drape_result(const DrapeSetting& s, DrapeRepeat& r) {
  const fs::path results = r.folder / "results";
  const Json summary = read_summary(results / "summary.json");
  r.converged = summary.is_object() && summary.value("converged", false);
  if (!r.converged) return;
  r.cpu_seconds = summary.value("cpu_seconds", 0.0);
  r.recovery_error = summary.value("recovery_error", 0.0);
  const double area = std::numbers::pi * (std::pow(radius_of(s), 2) - std::pow(drape_support_radius, 2));
  const double kinetic = summary.contains("motion") ? summary["motion"].value("last", 0.0) : 0.0;
  r.at_rest = std::sqrt(2.0 * kinetic / (s.fabric.areal_density * area)) < rest_speed;
  read_drape_shape(s, results / "results.vtkhdf", r);
}

void read_drape_shape(const DrapeSetting& s, const fs::path& file, DrapeRepeat& r) {
  const mesh::SurfaceMesh mesh(results::read_step_mesh(file, -1));
  const results::StoredStep step = results::read_step(file, -1, mesh);
  std::vector<Vec3> places = mesh.positions();
  for (std::size_t v = 0; v < places.size(); ++v) places[v] += Eigen::Map<const Vec3>(&step.displacement[3 * v]);
  r.shape = drape_shape(mesh.triangles(), mesh.positions(), places, drape_support_radius);
  r.edge = edge_of(s, r, mesh.data(), places);
}

Spread coefficient_of(const std::vector<DrapeRepeat>& repeats) {
  Spread all;
  double count = 0.0;
  for (const DrapeRepeat& r : repeats)
    if (r.converged) all.mean += 100.0 * r.shape.coefficient, ++count;
  if (count == 0.0) return all;
  all.mean /= count;
  for (const DrapeRepeat& r : repeats)
    if (r.converged) all.deviation += std::pow(100.0 * r.shape.coefficient - all.mean, 2) / std::max(count - 1.0, 1.0);
  all.deviation = std::sqrt(all.deviation);
  return all;
}

void write_drape_results(const DrapeSetting& s, const std::vector<DrapeRepeat>& repeats,
                         const std::optional<DrapeRepeat>& finer, const std::vector<DrapeEquilibrium>& equilibria) {
  const fs::path& folder = s.test.output;
  const std::string circles =
      "circles.csv";  // tables are named in the folder: a colon in its path would end their names
  std::vector<std::string> plot{"plot"};
  Json all = Json::array(), counts = Json::array();
  double cpu_seconds = finer ? finer->cpu_seconds : 0.0;
  for (std::size_t k = 0; k < repeats.size(); ++k) {
    const DrapeRepeat& r = repeats[k];
    all.push_back(json_of(r));
    cpu_seconds += r.cpu_seconds;
    if (!r.converged) continue;
    counts.push_back(r.shape.folds.size());
    const std::string file = fmt::format("contour_{}.csv", k + 1);
    write_contour(folder / file, r);
    plot.insert(plot.end(), {"--curve", fmt::format("{}:x_mm:y_mm:{}", file, k + 1)});
  }
  write_circles(s, folder / circles);
  const Spread coefficient = coefficient_of(repeats);
  Json summary{
      {"fabric", s.fabric.name},
      {"fabric_file", s.fabric_file.string()},
      {"specimen_mm", s.test.specimen},
      {"support_mm", 2e3 * drape_support_radius},
      {"method", s.test.method == DrapeTest::Method::plate ? "plate" : "weight"},
      {"friction_inside_the_fabric", s.friction},
      {"faces", "alike: figures of a fabric file hold for both"},
      {"cell_mm", 1e3 * s.cell},
      {"drape_coefficient",
       counts.empty() ? Json() : Json{{"mean", coefficient.mean}, {"standard_deviation", coefficient.deviation}}},
      {"fold_counts", counts},
      {"repeats", all},
      {"cpu_seconds", cpu_seconds}};
  if (finer && finer->converged) {
    summary["finer"] = json_of(*finer);
    summary["finer"]["cell_mm"] = 1e3 * finer->cell;
  }
  if (!equilibria.empty()) summary["equilibria"] = write_equilibria(folder / "equilibria.csv", equilibria);
  write_drape_file(folder / "summary.json", summary.dump(2) + "\n");
  if (counts.empty()) return;
  for (const char* ring : {"support", "specimen"})
    plot.insert(plot.end(), {"--dashed", fmt::format("{}:{}_x:{}_y:{}", circles, ring, ring, ring)});
  plot.insert(plot.end(), {"--equal", "--x-label", "x [mm]", "--y-label", "y [mm]", "--size", "720x640", "--quiet",
                           "--output", "contours.png"});
  run_silently("voile-picture", plot, folder);
}

}  // namespace voile::cli
