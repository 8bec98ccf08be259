// A case to begin with.
#include <fmt/format.h>

#include <algorithm>

#include "voile/base/error.hpp"
#include "voile/base/text.hpp"
#include "voile/input/case_declarations.hpp"

namespace voile::input {

namespace {

/// Sections that an analysis can have besides the common ones, and what stands in them.
struct Example {
  const char* analysis;
  const char* text;                  ///< sections with values
  std::vector<const char*> further;  ///< sections that can be added
};

constexpr const char* common = R"([mesh]
file = "plate.geo"
parameters = {{ n = 20 }}

[[material]]
type = "isotropic"
young = 2.1e11
poisson = 0.3
thickness = 0.005
density = 7850.0

[[support]]
type = "clamped"
group = "left"
)";

const std::vector<Example>& examples() {
  static const std::vector<Example> all{
      {"static",
       "[[load]]\ntype = \"pressure\"\nmagnitude = 1000.0\n\n[steps]\ninitial_step = 0.25\n",
       {"mass", "spring", "contact", "obstacle", "contact_rule"}},
      {"linear", "[[load]]\ntype = \"pressure\"\nmagnitude = 1000.0\n", {"steps", "spring"}},
      {"modal", "[eigen]\nmodes = 6\n", {"load", "steps", "mass", "spring"}},
      {"buckling",
       "[[load]]\ntype = \"line\"\ngroup = \"right\"\nvector = [-1000.0, 0.0, 0.0]\n\n[eigen]\nmodes = 4\n",
       {"steps", "spring"}},
      {"dynamic",
       "[[load]]\ntype = \"pressure\"\nmagnitude = 1000.0\n\n[time]\nend = 0.1\nstep = 0.001\n",
       {"initial_velocity", "damping", "air", "mass", "spring", "contact", "obstacle", "contact_rule"}},
      {"drape",
       "[[load]]\ntype = \"gravity\"\nvector = [0.0, 0.0, -9.81]\n",
       {"drape", "mass", "spring", "contact", "obstacle", "contact_rule"}}};
  return all;
}

/// The keys of a section in comments.
std::string commented(const Declarations& declared, const SectionInfo& section) {
  std::string out =
      fmt::format("\n# {}\n# {}\n", section.meaning,
                  section.repeated ? fmt::format("[[{}]]", section.name) : fmt::format("[{}]", section.name));
  for (const Key& key : declared.of(section.name)) {
    std::string value = toml_value(key.slot);
    if (key.required || value.empty() || value == "\"\"") value = "...";
    const std::string unit = key.unit.empty() ? "" : fmt::format(" [{}]", key.unit);
    const std::string types = key.types.empty() ? "" : fmt::format(" ({})", join(key.types, ", "));
    out += fmt::format("# {} = {}  # {}{}{}\n", key.name, value, key.meaning, unit, types);
  }
  return out;
}

}  // namespace

std::string case_template(const std::string& analysis) {
  const auto at =
      std::find_if(examples().begin(), examples().end(), [&](const Example& e) { return e.analysis == analysis; });
  if (at == examples().end()) {
    std::vector<std::string> names;
    for (const Example& e : examples()) names.emplace_back(e.analysis);
    throw UserError(fmt::format("--analysis {}: unknown:{}", analysis, suggestion(analysis, names)));
  }
  const Declarations declared;
  std::string out = fmt::format(
      "# A case for Voile; `voile check case.toml` validates it, `voile run case.toml` solves it.\n"
      "# Below the line are all other keys it can have, with their defaults.\n"
      "title = \"Plate\"\nanalysis = \"{}\"\n\n{}\n{}\n"
      "[[probe]]\nname = \"edge\"\ntype = \"displacement\"\ngroup = \"right\"\ncomponents = [\"z\"]\n\n"
      "# -----------------------------------------------------------------------------------------\n",
      analysis, fmt::format(common), at->text);
  std::vector<std::string> wanted{"mesh",  "element", "material", "support", "load", "steps",
                                  "eigen", "time",    "probe",    "output",  "petsc"};
  const bool in_time = analysis == "dynamic", modes = analysis == "modal" || analysis == "buckling";
  std::erase_if(wanted, [&](const std::string& s) {
    return (s == "time" && !in_time) || (s == "eigen" && !modes) || (s == "steps" && analysis != "static");
  });
  wanted.insert(wanted.end(), at->further.begin(), at->further.end());
  for (const SectionInfo& section : sections())
    if (std::find(wanted.begin(), wanted.end(), section.name) != wanted.end()) out += commented(declared, section);
  return out;
}

std::string template_geometry() {
  return R"(// A plate of 1 m x 0.5 m, n cells along its length.
DefineConstant[ n = 20 ];
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {1, 0.5, 0};
Point(4) = {0, 0.5, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("plate") = {1};
Physical Curve("left") = {4};
Physical Curve("right") = {2};
Physical Curve("bottom") = {1};
Physical Curve("top") = {3};
Mesh.MeshSizeMin = 1/n;
Mesh.MeshSizeMax = 1/n;
)";
}

}  // namespace voile::input
