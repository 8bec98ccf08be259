// The case as text: values in TOML, the echo of a resolved case, the reference page.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>

#include "base/group_list.hpp"
#include "base/text.hpp"
#include "case_declarations.hpp"
#include "units.hpp"

namespace voile::input {

namespace {

/// Shortest text that reads back as the same number, with a point or exponent so that TOML takes it for a float.
std::string number(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

/// The angle in degrees, chosen among its neighbours so that reading it gives exactly `radians` back.
double degrees(double radians) {
  const double guess = radians / degree;
  double best = guess;
  for (double low = guess, high = guess; best * degree != radians && high < guess * (1 + 1e-14);) {
    low = std::nextafter(low, 0.0);
    high = std::nextafter(high, 1e3);
    best = low * degree == radians ? low : high;
  }
  return best * degree == radians ? best : guess;
}

template <class List, class Print>
std::string list(const List& items, const Print& print) {
  std::vector<std::string> texts;
  for (const auto& item : items) texts.push_back(print(item));
  return fmt::format("[{}]", join(texts, ", "));
}

std::string vector_text(const Vec3& v) {
  return list(v, number);
}

/// Writes one alternative of Slot; an empty text means that there is nothing to write.
struct Printer {
  std::string operator()(const double* x) const { return std::isfinite(*x) ? number(*x) : ""; }
  std::string operator()(const int* x) const { return fmt::format("{}", *x); }
  std::string operator()(const bool* x) const { return *x ? "true" : "false"; }
  std::string operator()(const std::string* x) const { return toml_text(*x); }
  std::string operator()(const std::filesystem::path* x) const { return toml_text(x->string()); }
  std::string operator()(const Degrees& x) const { return number(degrees(*x.radians)); }
  std::string operator()(const Choice& x) const { return toml_text(x.names[static_cast<std::size_t>(x.get())]); }
  std::string operator()(const Words& x) const { return x.values->empty() ? "" : list(*x.values, toml_text); }
  std::string operator()(const std::vector<std::string>* x) const { return x->empty() ? "" : list(*x, toml_text); }
  std::string operator()(const GroupList& x) const {
    const std::vector<std::string> groups = groups_of(*x.name);
    return groups.size() > 1 ? list(groups, toml_text) : toml_text(*x.name);
  }
  std::string operator()(const std::vector<double>* x) const { return x->empty() ? "" : list(*x, number); }
  std::string operator()(const std::vector<int>* x) const {
    return x->empty() ? "" : list(*x, [](int i) { return toml_text(std::string(1, "xyz"[i])); });
  }
  std::string operator()(const std::array<bool, 3>* x) const {
    std::vector<int> axes;
    for (int i = 0; i < 3; ++i)
      if ((*x)[static_cast<std::size_t>(i)]) axes.push_back(i);
    return (*this)(&axes);
  }
  std::string operator()(const Vec3* x) const { return vector_text(*x); }
  std::string operator()(const std::optional<Vec3>* x) const { return *x ? vector_text(**x) : ""; }
  std::string operator()(const PointInput* x) const {
    return x->landmark.empty() ? vector_text(x->at) : toml_text(x->landmark);
  }
  std::string operator()(const std::optional<PointInput>* x) const { return *x ? (*this)(&**x) : ""; }
  std::string operator()(const Mat3* x) const {
    return list(std::array{0, 1, 2}, [&](int i) { return vector_text(x->row(i)); });
  }
  std::string operator()(const std::map<std::string, double>* x) const {
    std::vector<std::string> texts;
    for (const auto& [name, value] : *x) texts.push_back(fmt::format("{} = {}", toml_text(name), number(value)));
    return texts.empty() ? "" : fmt::format("{{ {} }}", join(texts, ", "));
  }
};

/// What may be written for a key, in words.
struct TypeName {
  std::string operator()(const double*) const { return "number"; }
  std::string operator()(const int*) const { return "whole number"; }
  std::string operator()(const bool*) const { return "`true` or `false`"; }
  std::string operator()(const std::string*) const { return "text"; }
  std::string operator()(const std::filesystem::path*) const { return "file name"; }
  std::string operator()(const Degrees&) const { return "number"; }
  std::string operator()(const Choice& x) const { return fmt::format("`\"{}\"`", join(x.names, "\"`, `\"")); }
  std::string operator()(const Words&) const { return "list of texts"; }
  std::string operator()(const std::vector<std::string>*) const { return "list of texts"; }
  std::string operator()(const GroupList&) const { return "text, or list of texts"; }
  std::string operator()(const std::vector<double>*) const { return "list of numbers"; }
  std::string operator()(const std::vector<int>*) const { return "list of axes"; }
  std::string operator()(const std::array<bool, 3>*) const { return "list of axes"; }
  std::string operator()(const Vec3*) const { return "3 numbers"; }
  std::string operator()(const std::optional<Vec3>*) const { return "3 numbers"; }
  std::string operator()(const PointInput*) const { return "3 numbers, or a landmark `\"OBSTACLE.NAME\"`"; }
  std::string operator()(const std::optional<PointInput>*) const { return (*this)(static_cast<PointInput*>(nullptr)); }
  std::string operator()(const Mat3*) const { return "3 rows of 3 numbers"; }
  std::string operator()(const std::map<std::string, double>*) const { return "table of numbers"; }
};

/// The name of the section's type in force, "" if it has no key `type`.
std::string type_of(const std::vector<Key>& keys) {
  for (const Key& key : keys)
    if (key.name == "type")
      return std::get<Choice>(key.slot).names[static_cast<std::size_t>(std::get<Choice>(key.slot).get())];
  return "";
}

template <class Section>
std::string echo_all(const char* name, std::vector<Section> items) {
  std::string out;
  for (Section& item : items) out += fmt::format("\n[[{}]]\n{}", name, echo_keys(keys_of(item)));
  return out;
}

/// Back from the sliders, which are made of these numbers.
void set_hysteresis(const energy::YarnFriction& friction, MaterialInput& input) {
  if (friction.sliders.empty()) return;
  Vec3 loop = Vec3::Zero();
  double spread = 0.0;
  for (const energy::YarnFriction::Slider& s : friction.sliders) {
    loop += 2.0 * s.limit;
    const int r = s.limit[0] > 0.0 ? 0 : s.limit[1] > 0.0 ? 1 : 2;
    spread += 2.0 * s.limit[r] / s.stiffness[r];
  }
  input.bending_hysteresis = {loop[0], loop[1], loop[2]};
  input.bending_sliders = static_cast<int>(friction.sliders.size());
  input.bending_hysteresis_spread = spread / input.bending_sliders;
}

void set_yarns(const energy::YarnLaw& law, MaterialInput& input) {
  if (!law.any()) return;
  const std::array lists{&input.stiffening_warp, &input.stiffening_weft, &input.stiffening_shear};
  for (std::size_t r = 0; r < 3; ++r)
    for (const energy::YarnLaw::Knot& k : law.knots[r]) lists[r]->insert(lists[r]->end(), {k.strain, k.bend});
  if (law.rubs()) input.shear_hysteresis = {law.limit, law.rise, law.stiffness};
}

/// A fabric is stored as a pair of matrices, so that its file is not needed again.
MaterialInput as_input(const energy::Material& m) {
  MaterialInput input;
  input.type = MaterialInput::Type::matrices;
  input.groups = m.groups;
  input.membrane = m.membrane;
  input.bending = m.bending;
  input.coupling = m.coupling;
  input.areal_density = m.areal_density;
  input.bending_damping = m.bending_damping;
  input.membrane_damping = m.viscous_time;
  if (m.expands) {
    input.expansion_strain = m.expansion;
    input.expansion_curvature = m.expansion_curvature;
    if (!m.coupled_strain.isZero(0.0)) input.coupled_strain = m.coupled_strain;
    if (!m.coupled_curvature.isZero(0.0)) input.coupled_curvature = m.coupled_curvature;
  }
  const auto given = [](const Vec3& v) {
    return v.isZero(0.0) ? std::vector<double>{} : std::vector<double>{v[0], v[1], v[2]};
  };
  input.initial_strain = given(m.initial_strain);
  input.prestress = given(m.prestress);
  input.direction = m.direction;
  input.warp_angle = m.friction.sliders.empty() ? m.yarns.warp_angle : m.friction.warp_angle;
  set_hysteresis(m.friction, input);
  set_yarns(m.yarns, input);
  if (m.texture_direction) input.texture_direction = {(*m.texture_direction)[0], (*m.texture_direction)[1]};
  return input;
}

std::string default_text(const Key& key) {
  if (key.required) return "required";
  std::string value = toml_value(key.slot);
  if (value == "\"\"" || value.empty())
    value = key.absent.empty() ? "empty" : key.absent;
  else
    value = fmt::format("`{}`", value);
  if (key.required_types.empty()) return value;
  const bool only_those = key.types == key.required_types;
  return only_those ? "required" : fmt::format("required for {}; else {}", join(key.required_types, ", "), value);
}

std::string reference_table(const std::vector<Key>& keys, bool by_type) {
  std::string out = by_type ? "| key | for `type` | value | unit | default | meaning |\n|---|---|---|---|---|---|\n"
                            : "| key | value | unit | default | meaning |\n|---|---|---|---|---|\n";
  for (const Key& key : keys) {
    std::string value = std::visit(TypeName{}, key.slot);
    if (const std::string range = key.range.text(); !range.empty()) value += ", " + range;
    const std::string types = key.types.empty() ? "all" : join(key.types, ", ");
    out += fmt::format("| `{}` |{} {} | {} | {} | {} |\n", key.name, by_type ? fmt::format(" {} |", types) : "", value,
                       key.unit.empty() ? "-" : key.unit, default_text(key), key.meaning);
  }
  return out;
}

constexpr const char* reference_head = R"(# Case file reference

Generated by `voile reference`; do not edit by hand.

A case is a [TOML](https://toml.io) file. Numbers are in SI units; a text with a unit does as well
where a key has one, `"0.5 mm"`, see [other units](../howto/use-other-units.md). A key that is not listed here is an error, so is a value
of another type or outside its range. A run writes the case with every value in force to `resolved_case.toml` in its output
folder; materials appear there as `matrices`, paths as absolute paths.

```toml
title = "Plate strip bent by a line load"

[mesh]
file = "strip.geo"
parameters = { n = 40 }

[[material]]
type = "isotropic"
young = 1.2e6
poisson = 0.0
thickness = 0.1

[[support]]
group = "fixed edge"
type = "clamped"

[[load]]
group = "free edge"
type = "line"
vector = [0, 0, 4.0]

[[probe]]
name = "tip"
type = "displacement"
group = "free edge"
```

## Outside all sections

)";

constexpr const char* reference_tail = R"(
Where an option is given more than once, the first of these wins: the command line, the environment variable
`PETSC_OPTIONS`, the case file, Voile's own default. `check` and `info` do not apply those of the case file. The file
`.petscrc` is read only with `-skip_petscrc 0` on the command line. Everything on the command line that starts with a
single dash and at least two characters belongs to PETSc; the word after it is its value unless it starts with a dash and a
letter. Options that nothing used are reported at the end of a run.
)";

}  // namespace

std::string toml_value(const Slot& slot) {
  return std::visit(Printer{}, slot);
}

std::string echo_keys(const std::vector<Key>& keys) {
  const std::string type = type_of(keys);
  std::string out;
  for (const Key& key : keys) {
    if (!applies(key, type)) continue;
    std::string value = toml_value(key.slot);
    if (!key.absent.empty() && value == "\"\"") value.clear();
    const std::string unit = key.unit.empty() ? "" : fmt::format("  # [{}]", key.unit);
    out += value.empty() ? fmt::format("# {}: {}\n", key.name, key.absent)
                         : fmt::format("{} = {}{}\n", key.name, value, unit);
  }
  return out;
}

/// Makes a comment of a key that would be refused as it has no meaning.
void disable(const std::string& key, std::string& text) {
  if (const std::size_t at = text.find("\n" + key + " = "); at != std::string::npos) text.insert(at + 1, "# ");
}

/// Of sections whose keys exclude each other: what is as usual is a comment.
std::string echo_changes(const std::vector<Key>& keys, const std::vector<Key>& usual) {
  std::istringstream given(echo_keys(keys)), defaults(echo_keys(usual));
  std::set<std::string> as_usual;
  for (std::string line; std::getline(defaults, line);) as_usual.insert(line);
  std::string out;
  for (std::string line; std::getline(given, line);)
    out += (line[0] != '#' && as_usual.contains(line) ? "# " : "") + line + "\n";
  return out;
}

/// The comments behind values name the units of the case.
std::string with_units(const std::string& text, const UnitSystem& units) {
  if (units.is_si()) return text;
  const std::string begin = "  # [";
  std::istringstream in(text);
  std::string out;
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.rfind(begin);
    if (at != std::string::npos && line.ends_with(']')) {
      const std::string unit = line.substr(at + begin.size(), line.size() - at - begin.size() - 1);
      // One that depends on a type or a group names several.
      const bool one = unit.find(',') == std::string::npos && unit != "file unit";
      line = line.substr(0, at) + (one ? begin + units.label(unit) + "]" : "");
    }
    out += line + "\n";
  }
  return out;
}

std::string echo_case(const Case& c) {
  if (!c.stages.empty())
    return "# The case with its stages; the folder of each has it with every value in force.\n" + c.staged_text;
  Case copy = c;
  std::string out = "# The case with every value in force.\n" + echo_keys(top_keys(copy));
  if (!UnitSystem(copy.units).is_si()) out += "\n[units]\n" + echo_keys(keys_of(copy.units));
  MeshSection usual_mesh;
  PanelSection usual_panel;
  out += "\n[mesh]\n" +
         (copy.panels.empty() ? echo_keys(keys_of(copy.mesh)) : echo_changes(keys_of(copy.mesh), keys_of(usual_mesh)));
  for (PanelSection& s : copy.panels) out += "\n[[panel]]\n" + echo_changes(keys_of(s), keys_of(usual_panel));
  out += echo_all("seam", copy.seams);
  out += echo_all("mark", copy.marks);
  if (!copy.panels.empty()) out += "\n[sewing]\n" + echo_keys(keys_of(copy.sewing));
  out += "\n[element]\n" + echo_keys(keys_of(copy.element));
  for (std::size_t i = 0; i < c.materials.size(); ++i) {
    MaterialInput material = as_input(c.materials[i]);
    const std::string& written = c.written_materials[i];
    out += "\n[[material]]\n" + (written.empty() ? echo_keys(keys_of(material)) : written);
  }
  for (std::size_t i = 0; i < copy.supports.size(); ++i)
    out += "\n[[support]]\n" + echo_keys(keys_of(copy.supports[i], copy.motions[i]));
  out += echo_all("rigid", copy.rigids);
  out += echo_all("periodic", copy.periodics);
  for (system::Load& load : copy.loads) {
    std::string text = echo_keys(keys_of(load));
    if (!(load.leak_area > 0.0)) disable("density", text);
    out += "\n[[load]]\n" + text;
  }
  out += echo_all("temperature", copy.temperatures);
  if (copy.form.active) out += "\n[form]\n" + echo_keys(keys_of(copy.form));
  out += echo_all("hinge", copy.hinges);
  out += echo_all("imperfection", copy.imperfections);
  out += echo_all("mass", copy.masses);
  out += echo_all("spring", copy.springs);
  if (copy.contact.input.active) {
    out += "\n[contact]\n" + echo_keys(keys_of(copy.contact));
    out += echo_all("obstacle", copy.obstacles);
    out += echo_all("landmark", copy.landmarks);
    out += echo_all("contact_rule", copy.contact_rules);
    out += echo_all("attachment", copy.attachments);
  }
  out += "\n[steps]\n" + echo_keys(keys_of(copy.steps));
  out += "\n[eigen]\n" + echo_keys(keys_of(copy.eigen));
  out += "\n[harmonic]\n" + echo_keys(keys_of(copy.harmonic));
  out += "\n[time]\n" + echo_keys(keys_of(copy.time, copy.dynamics.mass));
  out += echo_all("initial_velocity", copy.initial_velocities);
  out += "\n[damping]\n" + echo_keys(damping_keys(copy.dynamics));
  out += "\n[air]\n" + echo_keys(keys_of(copy.dynamics.drag));
  out += "\n[drape]\n" + echo_keys(keys_of(copy.drape));
  if (copy.remesh.active) out += "\n[remesh]\n" + echo_keys(keys_of(copy.remesh));
  out += echo_all("probe", copy.probes);
  out += "\n[output]\n" + echo_keys(keys_of(copy.output));
  out += "\n[petsc]\n" + echo_keys(petsc_keys(copy));
  return with_units(out, UnitSystem(copy.units));
}

std::string case_reference_markdown() {
  const Declarations declared;
  std::string out = reference_head + reference_table(declared.top(), false);
  for (const SectionInfo& section : sections()) {
    const std::vector<Key>& list = declared.of(section.name);
    const bool by_type = std::any_of(list.begin(), list.end(), [](const Key& k) { return !k.types.empty(); });
    const std::string title =
        section.repeated ? fmt::format("[[{}]]", section.name) : fmt::format("[{}]", section.name);
    out += fmt::format("\n## `{}`\n\n{}\n\n{}", title, section.meaning, reference_table(list, by_type));
  }
  return out + reference_tail;
}

}  // namespace voile::input
