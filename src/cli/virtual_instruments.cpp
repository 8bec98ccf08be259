#include "virtual_instruments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "base/shipped_files.hpp"
#include "base/text.hpp"
#include "fit/fabric_file.hpp"
#include "fit/heart_loop.hpp"
#include "fit/instruments.hpp"
#include "history_read.hpp"
#include "side_by_side.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

constexpr double instrument_angle = 41.5 * fit::degree;
/// Of KES-FB2 and its largest curvature, of the frame of KES-FB1 and its largest angle.
constexpr double bent_length = 0.01, bent_width = 0.004, most_curvature = 250.0, frame_side = 0.05, most_angle = 8.0;
constexpr double bias_length = 0.1, bias_width = 0.05, bias_load = 4.903325;  // 5 gf/cm
constexpr std::array bent_points{0.25 * bent_length, 0.5 * bent_length, 0.75 * bent_length};

constexpr const char* head = R"(title = "{}"
analysis = "static"

[mesh]
file = {}
parameters = {{ {} }}

[[material]]
type = "fabric"
fabric = {}
direction = [1, 0, 0]
warp_angle = {}
hysteresis = "{}"

[output]
every = 1000
fields = ["displacement"]

)";

constexpr const char* hanging = R"([steps]
initial_step = 0.25
max_step = 0.25

[[support]]
group = "clamp"
type = "clamped"

[[load]]
type = "gravity"
vector = [0, 0, -9.80665]

[[probe]]
name = "tip"
type = "displacement"
group = "tip"
)";

/// Half of a heart loop, from the clamp that holds it upwards, along x, to its lowest point: that end turns by three quarters, first
/// along the arc to which a strip without weight rolls up, then below the clamp.
constexpr const char* looped = R"case([steps]
initial_step = 0.025
max_step = 0.05

[[support]]
group = "clamp"
type = "clamped"

[[rigid]]
group = "tip"
name = "bottom"
translation = ["free", 0, "{0:.9g}*(1 - cos({1}))/{1}*table(t, 0, 1, 0.3, 1, 0.6, 0, 1, 0)"]
turn = "about"
turn_axis = [0, 1, 0]
turn_angle = "-180/pi*{1}"

[[load]]
type = "gravity"
vector = [-9.80665, 0, 0]
)case";
constexpr const char* three_quarters = "table(t, 0, 1e-6, 0.3, 1.5*pi, 1, 1.5*pi)";
/// w L^3/D of the strip with the mean of both rigidities, with which its height tells most; its width over its length. One that bends
/// across as it bends along has the width of laboratories: a narrow one would bend as a beam, by D (1 - nu^2).
constexpr double loop_load = 250.0, loop_slenderness = 0.025, loop_width = 0.025;

constexpr const char* bent = R"case([steps]
initial_step = 0.02
max_step = 0.02

[[support]]
group = "clamp"
type = "clamped"

[[rigid]]
group = "tip"
name = "end"
translation = ["free", 0, "free"]
turn = "about"
turn_axis = [0, 1, 0]
turn_angle = "table(t, 0, 0, 0.2, {0:.9g}, 0.6, -{0:.9g}, 1, 0)"
)case";

constexpr const char* pulled = R"([steps]
initial_step = 0.1
max_step = 0.1

[[support]]
group = "clamp"
type = "hinged"

[[support]]
group = "tip"
type = "displacement"
components = ["x", "y", "z"]
value = [{:.9g}, 0, 0]

[[support]]
group = "plate"
type = "displacement"
components = ["z"]

[[probe]]
name = "pull"
type = "reaction"
group = "tip"
components = ["x"]
)";

constexpr const char* sheared = R"([steps]
initial_step = 0.0125
max_step = 0.0125

[[probe]]
name = "top"
type = "reaction"
group = "top"
components = ["x"]
)";

constexpr const char* side_of_frame = R"case(
[[support]]
group = "{}"
type = "displacement"
components = ["x", "y", "z"]
rotation_axis = [0, 0, -1]
rotation_centre = [{:g}, 0, 0]
rotation_angle = "table(t, 0, 0, 0.2, {:g}, 0.6, -{:g}, 1, 0)"
)case";

/// Runs a case in a folder of its own.
Columns run_instrument(const TestedFabric& t, const std::string& name, const std::string& text,
                       const std::vector<std::string>& columns) {
  const fs::path folder = t.folder / name;
  std::error_code error;
  fs::create_directories(folder, error);
  std::ofstream out(folder / "case.toml");
  out << text;
  if (error || !out.flush()) throw UserError(fmt::format("{}: the folder cannot be written", folder.string()));
  out.close();
  bool good = false;
  run_side_by_side({{folder, {}, [] {}, [&](bool success) { good = success; }}}, 1);
  if (!good)
    throw InstrumentFailed(
        fmt::format("{}: the run of this instrument has failed; see run.log there", folder.string()));
  return read_history(folder / "results" / "history.csv", columns);
}

std::string head_of(const TestedFabric& t, const std::string& title, const char* mesh, const std::string& parameters,
                    int angle, bool friction) {
  return fmt::format(head, title, toml_text((shipped_folder("meshes") / mesh).string()), parameters,
                     toml_text(t.file.string()), angle, friction ? "friction" : "damping");
}

/// Of the circle through three points, positive where the strip turns about +y.
double curvature_through(const std::array<Vec2, 3>& p) {
  const Vec2 a = p[1] - p[0], b = p[2] - p[1], c = p[2] - p[0];
  return -2.0 * (a.x() * b.y() - a.y() * b.x()) / (a.norm() * b.norm() * c.norm());
}

}  // namespace

double rigidity_along(const input::Fabric& f, int angle) {
  const Mat3 d = input::bending_stiffness(f);
  return angle == 0 ? d(0, 0) : angle == 90 ? d(1, 1) : 0.25 * (d(0, 0) + d(1, 1) + 2.0 * d(0, 1)) + d(2, 2);
}

double rigidity_read(const input::Fabric& f, double overhang) {
  return fit::gravity * f.areal_density * std::pow(overhang, 3) / fit::cantilever_load(instrument_angle);
}

double rigidity_read(const input::Fabric& f, const HeartLoop& loop) {
  return fit::gravity * f.areal_density * std::pow(loop.length, 3) / fit::heart_load(loop.height / loop.length);
}

double overhang(const TestedFabric& t, int angle, double width) {
  const double weight = fit::gravity * t.fabric.areal_density, load = fit::cantilever_load(instrument_angle),
               length = std::cbrt(load * rigidity_along(t.fabric, angle) / weight);
  const std::string text =
      head_of(t, "Cantilever", "cantilever.geo",
              fmt::format("length = {:.9g}, width = {:g}, nx = 40, ny = 16", length, width), angle, false) +
      hanging;
  const Columns h = run_instrument(t, fmt::format("cantilever_{}", angle), text, {"tip_x", "tip_z"});
  const double fall = std::atan2(-h[1].back(), length + h[0].back());
  return length * std::cbrt(load / fit::cantilever_load(fall));
}

double heart_loop_length(const TestedFabric& t) {
  const double mean = std::sqrt(t.fabric.bending_warp * t.fabric.bending_weft);
  return std::cbrt(loop_load * mean / (fit::gravity * t.fabric.areal_density));
}

HeartLoop heart_loop(const TestedFabric& t, int angle) {
  const double length = heart_loop_length(t), half = 0.5 * length, narrow = loop_slenderness * length,
               width = t.fabric.bending_poisson == 0.0 ? narrow : std::max(narrow, loop_width);
  const int across = std::clamp(static_cast<int>(std::lround(25.0 * width / half)), 3, 24);
  const std::string text =
      head_of(t, "Heart loop", "cantilever.geo",
              fmt::format("length = {:.9g}, width = {:.9g}, nx = 100, ny = {}", half, width, across), angle, false) +
      fmt::format(looped, half, three_quarters);
  const Columns h = run_instrument(t, fmt::format("heart_loop_{}", angle), text, {"bottom_x"});
  return {length, -(half + h[0].back())};
}

double bias_extension(const TestedFabric& t) {
  const input::Fabric& f = t.fabric;
  // More than without clamps.
  const double most = 0.3 * bias_load * (1.0 / f.membrane_shear + 1.0 / f.membrane_warp + 1.0 / f.membrane_weft);
  const std::string text =
      head_of(t, "Bias extension", "cantilever.geo",
              fmt::format("length = {:g}, width = {:g}, nx = 40, ny = 20, pattern = 1", bias_length, bias_width), 45,
              false) +
      fmt::format(pulled, most * bias_length);
  const Columns h = run_instrument(t, "bias_extension", text, {"load_factor", "pull_x"});
  for (std::size_t n = 1; n < h[0].size(); ++n) {
    const double before = std::abs(h[1][n - 1]) / bias_width, after = std::abs(h[1][n]) / bias_width;
    if (after >= bias_load)
      return most * (h[0][n - 1] + (h[0][n] - h[0][n - 1]) * (bias_load - before) / (after - before));
  }
  throw InstrumentFailed(fmt::format("{}: the strip along the bias does not carry 5 gf/cm", t.file.string()));
}

std::vector<std::pair<double, double>> bending_record(const TestedFabric& t, int angle) {
  std::string text =
      head_of(t, "Bending loop", "cantilever.geo",
              fmt::format("length = {:g}, width = {:g}, nx = 40, ny = 4", bent_length, bent_width), angle, true) +
      fmt::format(bent, most_curvature * bent_length / fit::degree);
  std::vector<std::string> names{"end_moment_y"};
  for (std::size_t i = 0; i < bent_points.size(); ++i) {
    text += fmt::format("\n[[probe]]\nname = \"p{}\"\ntype = \"displacement\"\npoint = [{:g}, {:g}, 0]\n", i,
                        bent_points[i], 0.5 * bent_width);
    names.push_back(fmt::format("p{}_x", i));
    names.push_back(fmt::format("p{}_z", i));
  }
  const Columns h = run_instrument(t, fmt::format("bending_{}", angle), text, names);
  std::vector<std::pair<double, double>> rows;
  for (std::size_t n = 0; n < h[0].size(); ++n) {
    std::array<Vec2, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = Vec2(bent_points[i] + h[1 + 2 * i][n], h[2 + 2 * i][n]);
    rows.emplace_back(curvature_through(p), h[0][n] / bent_width);
  }
  return rows;
}

std::vector<std::pair<double, double>> shear_record(const TestedFabric& t) {
  std::string text =
      head_of(t, "Picture frame", "plate.geo", fmt::format("side = {:g}, n = 1", frame_side), 0, true) + sheared;
  for (const auto& [side, at] : {std::pair{"left", 0.0}, std::pair{"right", frame_side}})
    text += fmt::format(side_of_frame, side, at, most_angle, most_angle);
  const Columns h = run_instrument(t, "shear", text, {"load_factor", "top_x"});
  std::vector<std::pair<double, double>> rows;
  double sign = 1.0;
  for (std::size_t n = 0; n < h[0].size(); ++n) {
    const double s = h[0][n], angle = most_angle * (s < 0.2   ? s / 0.2
                                                    : s < 0.6 ? 1.0 - (s - 0.2) / 0.2
                                                              : -1.0 + (s - 0.6) / 0.4);
    if (n == 1) sign = h[1][n] < 0.0 ? -1.0 : 1.0;
    // The reaction is along x; the force of the frame is along its sides, which stay parallel to x.
    rows.emplace_back(angle, sign * h[1][n] / frame_side * std::cos(angle * fit::degree));
  }
  return rows;
}

}  // namespace voile::cli
