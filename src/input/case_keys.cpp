#include "case_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "keys_common.hpp"

namespace voile::input {

std::string Range::text() const {
  constexpr double many_zeros = 1e6;
  const auto number = [](double x) { return std::abs(x) < many_zeros ? fmt::format("{}", x) : fmt::format("{:g}", x); };
  std::string lower =
      low > -std::numeric_limits<double>::infinity() ? fmt::format("{} {}", low_open ? ">" : ">=", number(low)) : "";
  std::string upper = high < std::numeric_limits<double>::infinity() ? fmt::format("<= {}", number(high)) : "";
  return lower + (lower.empty() || upper.empty() ? "" : " and ") + upper;
}

bool applies(const Key& key, const std::string& type) {
  return key.types.empty() || contains(key.types, type);
}

bool is_required(const Key& key, const std::string& type) {
  return applies(key, type) && (key.required || contains(key.required_types, type));
}

namespace {

Slot analysis_slot(Analysis& analysis) {
  return choice(analysis, {analysis_words.begin(), analysis_words.end()});
}

}  // namespace

std::vector<Key> keys_of(StageSection& s) {
  return {{.name = "name",
           .slot = &s.name,
           .meaning = "Of the stage, and of its folder in the output folder: letters, digits, `_` and `-`.",
           .required = true},
          {.name = "analysis",
           .slot = analysis_slot(s.analysis),
           .meaning = "As outside all sections. `linear` can only be the first stage.",
           .required = true},
          {.name = "sew",
           .slot = &s.sew,
           .meaning = "Seams that this stage pulls together, and that are welded at its end: their names, in which `*` "
                      "stands for a text, or `\"all\"`. "
                      "Needs `analysis = \"dynamic\"`.",
           .absent = "none"}};
}

const std::vector<std::string>& stage_tables() {
  static const std::vector<std::string> names{"steps", "eigen", "harmonic", "time",   "damping",
                                              "air",   "drape", "contact",  "remesh", "output"};
  return names;
}

const std::vector<std::string>& staged_items() {
  static const std::vector<std::string> names{"support",      "load",       "temperature",     "mass",
                                              "spring",       "rigid",      "periodic",        "obstacle",
                                              "contact_rule", "attachment", "initial_velocity"};
  return names;
}

std::vector<Key> keys_of(UnitsSection& s) {
  return {{.name = "length", .slot = &s.length, .meaning = "Unit of length, e.g. `\"mm\"`."},
          {.name = "mass",
           .slot = &s.mass,
           .meaning = "Unit of mass, e.g. `\"t\"`: with millimetres and seconds, forces are in N and stresses in MPa."},
          {.name = "time", .slot = &s.time, .meaning = "Unit of time."}};
}

std::vector<Key> top_keys(Case& c) {
  return {
      {.name = "title", .slot = &c.title, .meaning = "Free text, shown at the start of a run."},
      {.name = "analysis",
       .slot = analysis_slot(c.analysis),
       .meaning = "`static`: the load path of `steps`. `linear`: one solution for small deflections at "
                  "`final_load_factor`. `modal`: natural vibrations. `buckling`: critical loads; both about the "
                  "state that `eigen` names. `dynamic`: motion in time. `drape`: a stable equilibrium at load "
                  "factor 1 from any start. `harmonic`: amplitudes of vibration over the frequency, about the state "
                  "that `eigen` names."}};
}

std::vector<Key> placement_keys(formats::Placement& p, const std::vector<std::string>& types) {
  return {
      {.name = "up_axis",
       .slot = choice(p.up_axis, {{"y", formats::Placement::UpAxis::y}, {"z", formats::Placement::UpAxis::z}}),
       .meaning = "Axis that points up in files. From `y` it is turned to z: (x, y, z) becomes (x, -z, y).",
       .types = types},
      {.name = "rotate",
       .slot = &p.rotate,
       .meaning = "Then files are turned about the axes x, y and z of the scene, in this order, through its origin.",
       .unit = "degree",
       .types = types},
      {.name = "translate",
       .slot = &p.translate,
       .meaning = "Then they are moved by this. Everything else in the case (points, directions, loads, motions) "
                  "refers to the scene.",
       .unit = "m",
       .types = types}};
}

std::vector<Key> joined(std::vector<Key> first, const std::vector<Key>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::vector<Key> with_keys_after(const std::string& name, std::vector<Key> first, const std::vector<Key>& second) {
  const auto at = std::find_if(first.begin(), first.end(), [&](const Key& k) { return k.name == name; });
  first.insert(at + 1, second.begin(), second.end());
  return first;
}

const std::vector<SectionInfo>& sections() {
  static const std::vector<SectionInfo> all{
      {"units", false,
       "Units of plain numbers, meshes and results, if they are not SI. A text with a unit, `\"210 GPa\"`, holds in "
       "any "
       "system, as do fabric files and defaults. Not with `[[panel]]`, which is in metres."},
      {"mesh", false, "The surface. Required, unless it is cut from `[[panel]]`."},
      {"panel", true,
       "Pieces of a sewing pattern instead of a mesh, cut, meshed and placed, see [patterns](patterns.md). A piece "
       "is "
       "a physical surface of its name, each of its edges a physical curve `PIECE/EDGE`."},
      {"seam", true, "Edges of pieces that are sewn together, besides the stitches of pattern files."},
      {"mark", true,
       "Points of pieces with a name, each a vertex and a group of it: for buttons ([[spring]] of type \"pair\"), "
       "supports, loads and probes."},
      {"sewing", false, "How seams are closed in a stage that has the key `sew`."},
      {"element", false, "Operators of the shell element."},
      {"material", true, "Stiffness and mass of the shell. At least one."},
      {"support", true, "Prescribed displacements and slopes."},
      {"rigid", true,
       "Groups that move as rigid bodies, held and loaded at a reference point (see [hold "
       "rigidly](../howto/hold-rigidly.md)). Not with contact, panels, [air], `[remesh]`, `drape`, "
       "`central_difference`, "
       "a `spectral_radius` above 0.9, or springs to the ground on its vertices; slopes "
       "are not held beside joints or "
       "unsymmetric laminates."},
      {"periodic", true,
       "Pairs of boundary curves along which the sheet repeats itself: see [one cell of a periodic "
       "sheet](../howto/repeat-a-cell.md). Not with contact, panels, joined sheets, masses, hinges, "
       "rigid groups, gases, `[remesh]` or `[form]`; springs act across differences."},
      {"load", true, "Loads; each grows with the load factor unless it is `constant`."},
      {"temperature", true,
       "Changes of temperature from that at which the sheet has its rest shape; where groups overlap they add up. Each "
       "grows with the load factor unless it is `constant` or an expression of t. The materials there need an "
       "expansion. See [temperatures](../howto/heat-a-sheet.md)."},
      {"form", false,
       "The rest shape is that in which the `prestress` of the materials is in equilibrium: minimal surfaces, tents. "
       "Starts "
       "from the mesh, holds what `[[support]]` holds, pulls with the `force` of bands. See [find a "
       "form](../howto/find-a-form.md)."},
      {"hinge", true,
       "Lines along which the sheet turns like a hinge with a spring: scored, creased or perforated lines. On the "
       "boundary the ground is the other side: an elastic edge. Not with `[[panel]]` or `[remesh]`. See "
       "[hinges](../howto/fold-along-hinges.md)."},
      {"imperfection", true,
       "By how much the shape without stress differs from the mesh; several add up. See "
       "[imperfections](../howto/add-imperfections.md)."},
      {"mass", true, "Masses at vertices."},
      {"spring", true, "Linear springs to where vertices are at rest, between vertices, and elastic bands."},
      {"contact", false,
       "Contact without interpenetration, see [contact](../theory/contact.md). This section, or an obstacle, switches "
       "it on."},
      {"obstacle", true, "What the sheet can touch."},
      {"landmark", true,
       "Points of obstacles by name, from which pieces are placed: keys of `[[panel]]` take `\"OBSTACLE.NAME\"`, see "
       "[patterns](patterns.md). One of `point`, `near` and `vertices` gives its place."},
      {"contact_rule", true, "What holds between two bodies instead of the general rules."},
      {"attachment", true,
       "Vertices that springs hold to the surface of an obstacle, each where it is nearest when the attachment takes "
       "hold: at the start of the first stage that names it. They follow the surface as it moves and deforms, see "
       "[patterns](patterns.md)."},
      {"steps", false, "How the path of equilibria is followed from the unloaded state."},
      {"eigen", false, "Modes of vibration and buckling."},
      {"harmonic", false,
       "Frequency response, `analysis = \"harmonic\"`, to the loads that are not `constant` or to a moving base, in "
       "`response.csv` (see [frequency response](../howto/find-a-frequency-response.md)). Not with contact, panels, "
       "`[air]`, `[remesh]`, follower loads or gas."},
      {"time", false, "Motion in time, `analysis = \"dynamic\"`."},
      {"initial_velocity", true,
       "How a motion starts, unless `--restart` continues another; where groups overlap the last one counts."},
      {"damping", false, "Damping of `dynamic` and `harmonic`."},
      {"air", false, "Drag by air and wind in `dynamic`. Speed and normal are those of the start of each step."},
      {"drape", false, "The search of `analysis = \"drape\"`."},
      {"remesh", false,
       "Meshes that get finer where the sheet folds and coarser where it is flat, see "
       "[remeshing](../theory/remeshing.md). "
       "This section switches it on. While seams are open their two sides are split together and not made coarser."},
      {"probe", true, "Numbers recorded in `history.csv` after every step."},
      {"output", false, "What is written to `results.vtkhdf` and `results.xdmf`."},
      {"stage", true,
       "Stages, run one after the other: each begins in the state that the one before has left, see "
       "[stages](../howto/run-in-stages.md). Tables of its own, `[stage.time]`, `[stage.steps]`, `[stage.drape]`, "
       "`[stage.eigen]`, `[stage.harmonic]`, "
       "`[stage.damping]`, `[stage.air]`, `[stage.contact]`, `[stage.remesh]` and `[stage.output]`, win over those of "
       "the case, key by "
       "key. `[[support]]`, `[[rigid]]`, `[[load]]`, `[[temperature]]`, `[[mass]]`, `[[spring]]`, `[[obstacle]]`, "
       "`[[contact_rule]]`, "
       "`[[attachment]]` and `[[initial_velocity]]` then take the key `stages`: the names of those in which they hold; "
       "absent: all."},
      {"petsc", false, "The solver library."}};
  return all;
}

}  // namespace voile::input
