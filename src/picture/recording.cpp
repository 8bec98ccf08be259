#include "recording.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "base/frequency_unit.hpp"
#include "base/length_unit.hpp"
#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

namespace {

constexpr const char* results_name = "results.vtkhdf";

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

/// Rows of a CSV file; the first is its header. Empty if there is no such file.
std::vector<std::vector<std::string>> read_csv(const fs::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream in = open_input(file);
  for (std::string line; std::getline(in, line);) rows.push_back(csv_cells(line));
  return rows;
}

/// The history says what load factors and times are called.
bool counts_time(const fs::path& folder, const results::StoredRun& run) {
  const auto rows = read_csv(folder / "history.csv");
  if (!rows.empty()) return std::find(rows[0].begin(), rows[0].end(), "time") != rows[0].end();
  return std::any_of(run.steps().begin(), run.steps().end(),
                     [](const results::StoredStepInfo& s) { return s.time != s.load_factor; });
}

std::vector<Vec3> moved(const std::vector<Vec3>& from, const std::vector<double>& u, double factor) {
  std::vector<Vec3> x = from;
  for (std::size_t v = 0; v < x.size(); ++v) x[v] += factor * Vec3(u[3 * v], u[3 * v + 1], u[3 * v + 2]);
  return x;
}

SheetMaterial read_material(const toml::table& table) {
  SheetMaterial m;
  if (const toml::array* groups = table["groups"].as_array())
    for (const toml::node& name : *groups) m.groups.push_back(name.value_or(std::string()));
  const toml::node_view d = table["direction"], uv = table["texture_direction"];
  const Vec3 direction(d[0].value_or(0.0), d[1].value_or(0.0), d[2].value_or(0.0));
  const Vec2 in_texture(uv[0].value_or(0.0), uv[1].value_or(0.0));
  if (direction.norm() > 0.0) m.direction = direction;
  if (in_texture.norm() > 0.0) m.texture_direction = in_texture;
  m.warp_angle = std::numbers::pi / 180.0 * table["warp_angle"].value_or(0.0);
  m.thickness = table["thickness"].value_or(0.0);
  return m;
}

const TimeUnit& unit_of_time(const toml::table& resolved_case) {
  return time_unit_of(resolved_case["units"]["time"].value_or(std::string("s")));
}

/// first:last:stride; false: it is something else.
bool parse_range(const std::string& text, int& first, int& last, int& stride) {
  char end = '\0';
  stride = 1;
  if (std::sscanf(text.c_str(), "%d:%d:%d%c", &first, &last, &stride, &end) == 3) return stride > 0;
  stride = 1;
  return std::sscanf(text.c_str(), "%d:%d%c", &first, &last, &end) == 2;
}

}  // namespace

const TimeUnit& time_unit_in(const fs::path& folder) {
  const fs::path own = folder / "resolved_case.toml", file = is_there(own) ? own : folder / ".." / own.filename();
  if (!is_there(file)) return time_units.front();
  try {
    require_plain_file(file);
    return unit_of_time(toml::parse_file(file.string()));
  } catch (const toml::parse_error&) {
    return time_units.front();
  }
}

Recording::Recording(const fs::path& place, const Choice& choice) {
  std::error_code ignored;
  if (!is_there(place)) throw UserError(fmt::format("{}: there is no such folder or file", place.string()));
  folder_ = fs::is_directory(place, ignored) ? place : place.parent_path();
  std::vector<std::string> stages;
  read_case(folder_ / "resolved_case.toml", stages);
  const bool in_stages =
      std::any_of(stages.begin(), stages.end(), [&](const auto& s) { return is_there(folder_ / s); });
  if (!choice.stage.empty() && !in_stages)
    throw UserError(fmt::format("--stage {}: {} is not a run in stages", choice.stage, folder_.string()));
  if (!choice.stage.empty() && std::find(stages.begin(), stages.end(), choice.stage) == stages.end())
    throw UserError(fmt::format("--stage {}: there is no such stage in {}:{}", choice.stage, folder_.string(),
                                suggestion(choice.stage, stages)));
  if (choice.mode != 0) {
    add_modes(choice.stage.empty() ? folder_ : folder_ / choice.stage, choice.stage, choice);
  } else if (in_stages) {
    for (const std::string& stage : stages)
      if ((choice.stage.empty() || choice.stage == stage) && is_there(folder_ / stage / results_name))
        add_part(folder_ / stage, stage);
  } else {
    parts_.push_back({"", results::StoredRun(place), false, false});
    parts_.back().in_time = counts_time(folder_, parts_.back().run);
  }
  if (parts_.empty())
    throw UserError(fmt::format("{}: no stage has results yet; modes are shown by --mode N with --stage NAME",
                                (folder_ / choice.stage).string()));
}

void Recording::add_part(const fs::path& folder, const std::string& stage) {
  parts_.push_back({stage, results::StoredRun(folder), false, false});
  parts_.back().in_time = counts_time(folder, parts_.back().run);
}

std::vector<Vec3> Recording::last_positions(const fs::path& folder) const {
  if (!is_there(folder / results_name)) return {};
  const results::StoredRun run(folder);
  if (run.steps().empty() || !run.has_field(run.steps().size() - 1, "displacement")) return {};
  const std::size_t last = run.steps().size() - 1;
  const results::StoredMesh mesh = run.mesh(run.steps()[last].epoch);
  return moved(mesh.data.positions, run.field(last, "displacement", mesh.data).values, 1.0);
}

void Recording::add_modes(const fs::path& folder, const std::string& stage, const Choice& choice) {
  if (!is_there(folder / "modes" / results_name))
    throw UserError(fmt::format("--mode {}: there are no modes in {}{}", choice.mode, folder.string(),
                                stage.empty() ? "; of a run in stages give --stage too" : ""));
  parts_.push_back({stage, results::StoredRun(folder / "modes"), false, true});
  Part& part = parts_.back();
  const auto rows = read_csv(folder / "modes.csv");
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].size() > 1) part.mode_values.push_back(std::strtod(rows[i][1].c_str(), nullptr));
  if (!rows.empty() && rows[0].size() > 1) part.frequency_unit = frequency_unit(rows[0][1]);
  part.about = last_positions(folder);
  if (part.about.empty() && !stage.empty()) {
    // A stage of modes begins, and swings, where the one before it has ended.
    std::vector<std::string> stages;
    read_case(folder_ / "resolved_case.toml", stages);
    const auto at = std::find(stages.begin(), stages.end(), stage);
    if (at != stages.begin() && at != stages.end()) part.about = last_positions(folder_ / *(at - 1));
  }
}

void Recording::read_case(const fs::path& file, std::vector<std::string>& stages) {
  if (!is_there(file)) return;
  try {
    require_plain_file(file);
    const toml::table table = toml::parse_file(file.string());
    if (const toml::array* list = table["stage"].as_array())
      for (const toml::node& node : *list)
        if (const toml::table* stage = node.as_table()) stages.push_back((*stage)["name"].value_or(std::string()));
    const double unit = metres_of(table["units"]["length"].value_or(std::string("m")));
    metres_ = unit > 0.0 ? unit : 1.0;
    time_unit_ = unit_of_time(table);
    materials_.clear();
    if (const toml::array* list = table["material"].as_array())
      for (const toml::node& node : *list)
        if (const toml::table* material = node.as_table()) materials_.push_back(read_material(*material));
    const toml::array* loads = table["load"].as_array();
    for (std::size_t i = 0; loads && i < loads->size(); ++i) {
      const toml::table* load = (*loads)[i].as_table();
      if (!load || (*load)["type"].value_or(std::string()) != "gravity") continue;
      const toml::node_view vector = (*load)["vector"];
      const Vec3 g(vector[0].value_or(0.0), vector[1].value_or(0.0), vector[2].value_or(0.0));
      if (g.norm() > 0.0) up_ = -g.normalized();
    }
  } catch (const toml::parse_error&) {  // half written: the results say what matters
  }
}

std::vector<Moment> Recording::select(const std::string& steps) const {
  std::vector<Moment> every;
  for (std::size_t part = 0; part < parts_.size(); ++part)
    for (std::size_t i = 0; i < parts_[part].run.steps().size(); ++i) every.push_back({part, i});
  if (every.empty() && (steps == "last" || steps == "all")) return {Moment{parts_.size() - 1}};
  if (steps == "all") return every;
  if (steps == "last") return {every.back()};
  int first = 0, last = 0, stride = 1;
  char end = '\0';
  std::vector<Moment> chosen;
  if (std::sscanf(steps.c_str(), "%d%c", &first, &end) == 1) {
    for (auto m = every.rbegin(); m != every.rend() && chosen.empty(); ++m)
      if (number(*m) == first) chosen.push_back(*m);
  } else if (parse_range(steps, first, last, stride)) {
    if (first > last)
      throw UserError(fmt::format("--steps {}: the first number must not be larger than the last one", steps));
    for (const Moment& m : every)
      if (number(m) >= first && number(m) <= last && (number(m) - first) % stride == 0) chosen.push_back(m);
  } else {
    throw UserError(fmt::format("'{}' names no steps: it is all, last, N, FIRST:LAST or FIRST:LAST:STRIDE", steps));
  }
  if (!chosen.empty()) return chosen;
  std::vector<int> numbers;
  for (const Moment& m : every) numbers.push_back(number(m));
  if (numbers.size() > 40) numbers.erase(numbers.begin() + 20, numbers.end() - 20);
  const bool modes = !every.empty() && parts_[every.back().part].modes;
  throw UserError(fmt::format("{}: there is no {} {}; there are {}", folder_.string(), modes ? "mode" : "step", steps,
                              join(numbers, ", ")));
}

std::shared_ptr<const results::StoredMesh> Recording::mesh(const Moment& moment) const {
  const results::StoredRun& run = parts_[moment.part].run;
  const std::size_t epoch = moment.step ? run.steps()[*moment.step].epoch : 0;
  auto& known = meshes_[{moment.part, epoch}];
  if (!known) known = std::make_shared<const results::StoredMesh>(run.mesh(epoch));
  return known;
}

State Recording::state(const Moment& moment, double scale) const {
  const Part& part = parts_[moment.part];
  State state{mesh(moment), {}, part.run.obstacles().positions};
  const mesh::MeshData& data = state.mesh->data;
  state.positions = data.positions;
  if (!moment.step) return state;
  if (part.modes) {
    if (part.about.size() == data.positions.size()) state.positions = part.about;
    const std::vector<double> shape = part.run.field(*moment.step, "mode", data).values;
    double most = 0.0;
    for (std::size_t v = 0; v < data.positions.size(); ++v)
      most = std::max(most, Vec3(shape[3 * v], shape[3 * v + 1], shape[3 * v + 2]).norm());
    state.positions = moved(state.positions, shape, most > 0.0 ? moment.swing * scale / most : 0.0);
    return state;
  }
  if (part.run.has_field(*moment.step, "displacement"))
    state.positions = moved(data.positions, part.run.field(*moment.step, "displacement", data).values, scale);
  state.obstacles = part.run.obstacle_positions(*moment.step);
  return state;
}

int Recording::number(const Moment& moment) const {
  return moment.step ? parts_[moment.part].run.steps()[*moment.step].number : -1;
}

std::string Recording::caption(const Moment& moment) const {
  const Part& part = parts_[moment.part];
  const std::string stage = part.stage.empty() ? "" : part.stage + ", ";
  if (!moment.step) return stage + "at the start";
  const results::StoredStepInfo& step = part.run.steps()[*moment.step];
  if (part.modes) {
    const auto i = static_cast<std::size_t>(std::max(step.number - 1, 0));
    if (i >= part.mode_values.size()) return fmt::format("{}mode {}", stage, step.number);
    return part.frequency_unit.empty()
               ? fmt::format("{}mode {}: load factor {:.4g}", stage, step.number, part.mode_values[i])
               : fmt::format("{}mode {}: {:.4g} {}", stage, step.number, part.mode_values[i], part.frequency_unit);
  }
  if (part.run.has_field(*moment.step, "displacement_phase"))
    return fmt::format("{}{:.4g} {}", stage, step.time,
                       time_unit_.seconds == 1.0 ? "Hz" : fmt::format("1/{}", time_unit_.name));
  if (part.run.has_field(*moment.step, "displacement_rms")) return stage + "root mean square";
  if (part.in_time) return fmt::format("{}t = {:.4g} {}", stage, step.time, time_unit_.name);
  return fmt::format("{}load factor {:.4g}", stage, step.load_factor);
}

}  // namespace voile::picture
