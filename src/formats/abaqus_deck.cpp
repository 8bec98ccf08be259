#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <sstream>

#include "abaqus_deck_reader.hpp"
#include "mesh_text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

/// Keywords that the mesh reader takes, or that only say what is written.
const std::set<std::string>& passed_over() {
  static const std::set<std::string> all{
      "*NODE",        "*ELEMENT",        "*PART",       "*END PART",      "*ASSEMBLY",     "*END ASSEMBLY",
      "*INSTANCE",    "*END INSTANCE",   "*END STEP",   "*PREPRINT",      "*RESTART",      "*OUTPUT",
      "*NODE OUTPUT", "*ELEMENT OUTPUT", "*NODE PRINT", "*NODE FILE",     "*EL PRINT",     "*EL FILE",
      "*PRINT",       "*FILE FORMAT",    "*MONITOR",    "*CONTACT PRINT", "*ENERGY PRINT", "*ENERGY OUTPUT"};
  return all;
}

/// Parameters that are taken, or change nothing here, of keywords that say what acts and of what the sheet is; what others
/// say is listed.
const std::map<std::string, std::set<std::string>>& known_parameters() {
  static const std::set<std::string> load{"OP", "AMPLITUDE", "LOAD CASE", "FOLLOWER", "REGION TYPE"};
  static const std::map<std::string, std::set<std::string>> all{
      {"*BOUNDARY", {"OP", "AMPLITUDE", "LOAD CASE", "TYPE"}},
      {"*CLOAD", load},
      {"*DLOAD", load},
      {"*DSLOAD", load},
      {"*BUCKLE", {"EIGENSOLVER"}},
      {"*STATIC", {"RIKS", "DIRECT"}},
      {"*ELASTIC", {"TYPE"}},
      {"*AMPLITUDE", {"NAME", "DEFINITION", "VALUE", "TIME"}},
      {"*SHELL SECTION",
       {"ELSET", "MATERIAL", "COMPOSITE", "ORIENTATION", "SYMMETRIC", "OFFSET", "NODAL THICKNESS",
        "SECTION INTEGRATION", "POISSON", "STACK DIRECTION", "LAYUP", "CONTROLS", "TEMPERATURE", "DENSITY"}}};
  return all;
}

}  // namespace

/// What stands in a keyword line and is not understood.
void AbaqusDeckReader::list_parameters() {
  const auto known = known_parameters().find(keyword_);
  if (known == known_parameters().end()) return;
  for (const auto& [name, value] : parameters_)
    if (!name.empty() && !known->second.contains(name))
      leave(fmt::format("{}, {}{}{}", keyword_, name, value.empty() ? "" : "=", value));
}

void AbaqusDeckReader::read(int depth) {
  std::istringstream in(file_text(file_));
  line_ = 0;
  for (std::string text; abaqus_line(in, text, line_);) {
    if (text.starts_with("*")) {
      begin(text, depth);
    } else if (!abaqus_trimmed(text).empty()) {
      take(text);
    }
  }
}

void AbaqusDeckReader::begin(const std::string& text, int depth) {
  const AbaqusWords words = abaqus_fields(text);
  const std::string keyword = abaqus_upper(words[0]);
  parameters_ = abaqus_parameters(words);
  keyword_ = keyword;
  data_ = Data::none;
  if (keyword == "*INCLUDE") return include(depth);
  if (steps_ <= 1) list_parameters();
  if (keyword == "*NSET" || keyword == "*ELSET") return note_set(keyword);
  if (keyword == "*ASSEMBLY" || keyword == "*END ASSEMBLY") in_assembly_ = keyword == "*ASSEMBLY";
  if (keyword == "*HEADING") {
    data_ = Data::title;
  } else if (keyword == "*TIE") {
    deck_.tied = true;
    if (parameters_.contains("POSITION TOLERANCE") &&
        !parse_number(parameters_["POSITION TOLERANCE"], deck_.tie_tolerance))
      fail_in_line(file_, line_, "*TIE: POSITION TOLERANCE is no number");
  } else if (keyword == "*STEP") {
    if (++steps_ > 1) leave("a second *STEP; only the first is taken");
    ramp_ = ramp_ || abaqus_upper(parameters_["AMPLITUDE"]) == "RAMP";
    nonlinear_ = nonlinear_ || (parameters_.contains("NLGEOM") && abaqus_upper(parameters_["NLGEOM"]) != "NO");
  } else if (steps_ > 1) {
    data_ = Data::skipped;
  } else if (!begin_model(keyword) && !begin_step(keyword) && !passed_over().contains(keyword)) {
    leave(keyword);
    data_ = Data::unread;
  }
  if (keyword == "*TRANSFORM") deck_.turned.push_back(place_of(parameters_["NSET"]));
  if (keyword == "*NODE" && parameters_.contains("NSET")) deck_.node_sets.push_back(parameters_["NSET"]);
  if (keyword == "*ELEMENT" && parameters_.contains("ELSET")) deck_.element_sets.push_back(parameters_["ELSET"]);
}

void AbaqusDeckReader::note_set(const std::string& keyword) {
  const bool nodes = keyword == "*NSET";
  const std::string name = parameters_[nodes ? "NSET" : "ELSET"];
  const auto is_same = [&](const std::string& other) { return abaqus_upper(other) == abaqus_upper(name); };
  if (in_assembly_ && assembly_sets_.insert(abaqus_upper(name)).second) {
    for (std::vector<std::string>* sets : {&deck_.node_sets, &deck_.element_sets})
      for (std::string& other : *sets)
        if (is_same(other)) other = abaqus_part_set(other);
    for (Deck::Section& s : deck_.sections)
      if (is_same(s.elements)) s.elements = abaqus_part_set(s.elements);
  }
  (nodes ? deck_.node_sets : deck_.element_sets).push_back(name);
}

std::string AbaqusDeckReader::place_of(const std::string& word) const {
  if (word.find('.') == std::string::npos) return word;
  for (const std::vector<std::string>* sets : {&deck_.node_sets, &deck_.element_sets})
    for (const std::string& name : *sets)
      if (abaqus_upper(name) == abaqus_upper(word)) return word;
  return abaqus_without_instance(word);
}

/// Materials and sections.
bool AbaqusDeckReader::begin_model(const std::string& keyword) {
  if (keyword == "*MATERIAL") {
    material_ = abaqus_upper(parameters_["NAME"]);
    deck_.materials.emplace(material_, Deck::Material{});
  } else if (keyword == "*ELASTIC") {
    const std::string type = abaqus_upper(parameters_["TYPE"]);
    data_ = type.empty() || type == "ISOTROPIC" || type == "ISO" ? Data::elastic
            : type == "LAMINA"                                   ? Data::lamina
                                                                 : Data::unread;
    if (data_ == Data::unread) leave("*ELASTIC, TYPE=" + type);
  } else if (keyword == "*HYPERELASTIC") {
    deck_.materials[material_].ogden = parameters_.contains("OGDEN");
    const bool known =
        parameters_.contains("OGDEN") || parameters_.contains("NEO HOOKE") || parameters_.contains("MOONEY-RIVLIN");
    data_ = known && !parameters_.contains("TEST DATA INPUT") ? Data::rubber : Data::unread;
    if (data_ == Data::unread) leave("*HYPERELASTIC that is no NEO HOOKE, MOONEY-RIVLIN or OGDEN with its constants");
  } else if (keyword == "*EXPANSION") {
    const std::string type = abaqus_upper(parameters_["TYPE"]);
    if (!type.empty() && type != "ISO" && type != "ORTHO") return false;
    data_ = Data::expansion;
  } else if (keyword == "*DENSITY") {
    data_ = Data::density;
  } else if (keyword == "*SURFACE") {
    const std::string type = abaqus_upper(parameters_["TYPE"]);
    data_ = type.empty() || type == "ELEMENT" ? Data::surface : Data::none;
  } else if (keyword == "*INITIAL CONDITIONS") {
    if (abaqus_upper(parameters_["TYPE"]) != "TEMPERATURE") return false;
    data_ = Data::initial_temperature;
  } else if (keyword == "*SHELL SECTION" || keyword == "*MEMBRANE SECTION") {
    if (keyword == "*MEMBRANE SECTION") leave(keyword + ": it bends as a shell of its thickness");
    if (parameters_.contains("NODAL THICKNESS"))
      leave(keyword + ", NODAL THICKNESS: the thickness of the section is taken");
    if (parameters_.contains("OFFSET")) leave(keyword + ", OFFSET");
    deck_.sections.push_back(
        {parameters_["ELSET"], abaqus_upper(parameters_["MATERIAL"]), 0.0, abaqus_upper(parameters_["ORIENTATION"])});
    if (parameters_.contains("DENSITY") && !parse_number(parameters_["DENSITY"], deck_.sections.back().mass))
      fail_in_line(file_, line_, keyword + ": DENSITY is no number");
    data_ = parameters_.contains("COMPOSITE") ? Data::ply : Data::section;
    symmetric_ = parameters_.contains("SYMMETRIC");
  } else if (keyword == "*ORIENTATION") {
    const std::string system = abaqus_upper(parameters_["SYSTEM"]), by = abaqus_upper(parameters_["DEFINITION"]);
    if ((!system.empty() && system != "RECTANGULAR") || (!by.empty() && by != "COORDINATES")) return false;
    data_ = Data::axes;
  } else {
    return false;
  }
  return true;
}

bool AbaqusDeckReader::begin_amplitude() {
  const std::string definition = abaqus_upper(parameters_["DEFINITION"]), value = abaqus_upper(parameters_["VALUE"]);
  if ((!definition.empty() && definition != "TABULAR") || value == "ABSOLUTE") return false;
  amplitude_ = abaqus_upper(parameters_["NAME"]);
  data_ = Data::amplitude;
  return true;
}

/// The table that scales a load, if it is known.
std::string AbaqusDeckReader::amplitude_of(const std::string& keyword) {
  std::string name = abaqus_upper(parameters_["AMPLITUDE"]);
  if (name.empty() || (deck_.amplitudes.contains(name) && !deck_.amplitudes[name].empty())) return name;
  leave(fmt::format("{}, AMPLITUDE={}: there is no such table; the load acts without it", keyword, name));
  return "";
}

/// Supports, loads and what the step does.
bool AbaqusDeckReader::begin_step(const std::string& keyword) {
  const bool acts = keyword == "*BOUNDARY" || keyword == "*CLOAD" || keyword == "*DLOAD" || keyword == "*DSLOAD";
  if (acts && abaqus_upper(parameters_["OP"]) == "NEW") leave(keyword + ", OP=NEW: what came before stays");
  if (keyword == "*AMPLITUDE") return begin_amplitude();
  if (acts) amplitude_ = amplitude_of(keyword);
  if (acts && parameters_.contains("LOAD CASE") && parameters_["LOAD CASE"] != "1") {
    leave(fmt::format("{}, LOAD CASE={}: it acts on the modes alone; here they keep the supports of the load", keyword,
                      parameters_["LOAD CASE"]));
    data_ = Data::unread;
    return true;
  }
  if (keyword == "*BOUNDARY") {
    const std::string type = abaqus_upper(parameters_["TYPE"]);
    data_ = type.empty() || type == "DISPLACEMENT" ? Data::support : Data::unread;
    if (data_ == Data::unread) leave("*BOUNDARY, TYPE=" + type);
  } else if (keyword == "*CLOAD") {
    data_ = Data::force;
    if (parameters_.contains("FOLLOWER")) leave("*CLOAD, FOLLOWER: the force keeps its direction");
  } else if (keyword == "*DLOAD") {
    data_ = Data::pressure;
  } else if (keyword == "*DSLOAD") {
    data_ = Data::surface_pressure;
  } else if (keyword == "*TEMPERATURE") {
    data_ = parameters_.contains("FILE") ? Data::unread : Data::temperature;
    if (parameters_.contains("AMPLITUDE")) leave("*TEMPERATURE, AMPLITUDE: its values are taken as they are");
    if (data_ == Data::unread) leave("*TEMPERATURE, FILE");
  } else if (keyword == "*STATIC" || keyword == "*FREQUENCY" || keyword == "*BUCKLE" || keyword == "*DYNAMIC") {
    data_ = Data::procedure;
    if (ramp_ && keyword == "*DYNAMIC") leave("*STEP, AMPLITUDE=RAMP: loads act in full from the start");
    if (keyword == "*DYNAMIC" && parameters_.contains("EXPLICIT"))
      leave("*DYNAMIC, EXPLICIT: steps are implicit; time.method = \"central_difference\" has explicit ones");
    if (keyword == "*DYNAMIC" && parameters_.contains("ALPHA"))
      leave("*DYNAMIC, ALPHA: time.spectral_radius sets what damps high frequencies");
    deck_.procedure = keyword == "*FREQUENCY"        ? Procedure::frequency
                      : keyword == "*BUCKLE"         ? Procedure::buckle
                      : keyword == "*DYNAMIC"        ? Procedure::dynamic
                      : parameters_.contains("RIKS") ? Procedure::riks
                      : nonlinear_                   ? Procedure::nonlinear
                                                     : Procedure::linear;
  } else {
    return false;
  }
  return true;
}

void AbaqusDeckReader::include(int depth) {
  const std::string name = parameters_["INPUT"];
  const std::filesystem::path inner = std::filesystem::path(file_).parent_path() / name;
  std::error_code ignored;
  if (name.empty() || std::filesystem::path(name).is_absolute() || depth >= most_included ||
      !std::filesystem::is_regular_file(inner, ignored))
    fail_in_line(file_, line_, fmt::format("*INCLUDE: there is no file '{}' beside this one", name));
  deck_.included.push_back(name);
  const std::string outer = file_;
  const std::size_t line = line_;
  file_ = inner.string();
  read(depth + 1);
  file_ = outer;
  line_ = line;
}

void AbaqusDeckReader::leave(const std::string& what) {
  deck_.left.push_back({what, fmt::format("{}:{}", file_, line_)});
}

double AbaqusDeckReader::number(const AbaqusWords& words, std::size_t k) const {
  double value = 0.0;
  if (k >= words.size() || !parse_number(words[k], value))
    fail_in_line(file_, line_, fmt::format("{}: a number is needed as entry {}", keyword_, k + 1));
  return value;
}

long AbaqusDeckReader::whole(const AbaqusWords& words, std::size_t k) const {
  long value = 0;
  if (k >= words.size() || !parse_integer(words[k], value))
    fail_in_line(file_, line_, fmt::format("{}: a whole number is needed as entry {}", keyword_, k + 1));
  return value;
}

Deck read_abaqus_deck(const std::string& file) {
  return AbaqusDeckReader(file).run();
}

}  // namespace voile::formats
