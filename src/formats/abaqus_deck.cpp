#include "deck.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <set>

#include "abaqus_words.hpp"
#include "mesh_text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

using Procedure = Deck::Procedure;

/// Keywords that the mesh reader takes, or that only say what is written.
const std::set<std::string>& passed_over() {
  static const std::set<std::string> all{
      "*NODE",          "*ELEMENT",      "*PART",          "*END PART", "*ASSEMBLY", "*END ASSEMBLY", "*INSTANCE",
      "*END INSTANCE",  "*END STEP",     "*PREPRINT",      "*RESTART",  "*OUTPUT",   "*NODE OUTPUT",  "*ELEMENT OUTPUT",
      "*NODE PRINT",    "*NODE FILE",    "*EL PRINT",      "*EL FILE",  "*PRINT",    "*FILE FORMAT",  "*MONITOR",
      "*CONTACT PRINT", "*ENERGY PRINT", "*ENERGY OUTPUT", "*SYSTEM",   "*SURFACE"};
  return all;
}

class DeckReader {
 public:
  explicit DeckReader(std::string file) : file_(std::move(file)) {}

  Deck run() {
    read(0);
    return std::move(deck_);
  }

 private:
  enum class Data {
    none,
    unread,
    title,
    elastic,
    lamina,
    density,
    section,
    ply,
    axes,
    axis,
    support,
    force,
    pressure,
    procedure,
    amplitude,
    skipped
  };

  void read(int depth) {
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

  void begin(const std::string& text, int depth) {
    const AbaqusWords words = abaqus_fields(text);
    const std::string keyword = abaqus_upper(words[0]);
    parameters_ = abaqus_parameters(words);
    keyword_ = keyword;
    data_ = Data::none;
    if (keyword == "*INCLUDE") return include(depth);
    if (keyword == "*NSET" || keyword == "*ELSET") return note_set(keyword);
    if (keyword == "*HEADING") {
      data_ = Data::title;
    } else if (keyword == "*TIE") {
      deck_.tied = true;
      if (parameters_.contains("POSITION TOLERANCE") &&
          !parse_number(parameters_["POSITION TOLERANCE"], deck_.tie_tolerance))
        fail_in_line(file_, line_, "*TIE: POSITION TOLERANCE is no number");
    } else if (keyword == "*STEP") {
      if (++steps_ > 1) leave("a second *STEP; only the first is taken");
      nonlinear_ = nonlinear_ || (parameters_.contains("NLGEOM") && abaqus_upper(parameters_["NLGEOM"]) != "NO");
    } else if (steps_ > 1) {
      data_ = Data::skipped;
    } else if (!begin_model(keyword) && !begin_step(keyword) && !passed_over().contains(keyword)) {
      leave(keyword);
      data_ = Data::unread;
    }
    if (keyword == "*NODE" && parameters_.contains("NSET")) deck_.node_sets.push_back(parameters_["NSET"]);
    if (keyword == "*ELEMENT" && parameters_.contains("ELSET")) deck_.element_sets.push_back(parameters_["ELSET"]);
  }

  void note_set(const std::string& keyword) {
    const bool nodes = keyword == "*NSET";
    (nodes ? deck_.node_sets : deck_.element_sets).push_back(parameters_[nodes ? "NSET" : "ELSET"]);
  }

  /// Materials and sections.
  bool begin_model(const std::string& keyword) {
    if (keyword == "*MATERIAL") {
      material_ = abaqus_upper(parameters_["NAME"]);
      deck_.materials.emplace(material_, Deck::Material{});
    } else if (keyword == "*ELASTIC") {
      const std::string type = abaqus_upper(parameters_["TYPE"]);
      data_ = type.empty() || type == "ISOTROPIC" || type == "ISO" ? Data::elastic
              : type == "LAMINA"                                   ? Data::lamina
                                                                   : Data::unread;
      if (data_ == Data::unread) leave("*ELASTIC, TYPE=" + type);
    } else if (keyword == "*DENSITY") {
      data_ = Data::density;
    } else if (keyword == "*SHELL SECTION" || keyword == "*MEMBRANE SECTION") {
      if (keyword == "*MEMBRANE SECTION") leave(keyword + ": it bends as a shell of its thickness");
      if (parameters_.contains("NODAL THICKNESS"))
        leave(keyword + ", NODAL THICKNESS: the thickness of the section is taken");
      if (parameters_.contains("OFFSET")) leave(keyword + ", OFFSET");
      deck_.sections.push_back(
          {parameters_["ELSET"], abaqus_upper(parameters_["MATERIAL"]), 0.0, abaqus_upper(parameters_["ORIENTATION"])});
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

  bool begin_amplitude() {
    const std::string definition = abaqus_upper(parameters_["DEFINITION"]), value = abaqus_upper(parameters_["VALUE"]);
    if ((!definition.empty() && definition != "TABULAR") || value == "ABSOLUTE") return false;
    amplitude_ = abaqus_upper(parameters_["NAME"]);
    data_ = Data::amplitude;
    return true;
  }

  /// The table that scales a load, if it is known.
  std::string amplitude_of(const std::string& keyword) {
    std::string name = abaqus_upper(parameters_["AMPLITUDE"]);
    if (name.empty() || (deck_.amplitudes.contains(name) && !deck_.amplitudes[name].empty())) return name;
    leave(fmt::format("{}, AMPLITUDE={}: there is no such table; the load acts without it", keyword, name));
    return "";
  }

  /// Supports, loads and what the step does.
  bool begin_step(const std::string& keyword) {
    const bool acts = keyword == "*BOUNDARY" || keyword == "*CLOAD" || keyword == "*DLOAD";
    if (acts && abaqus_upper(parameters_["OP"]) == "NEW") leave(keyword + ", OP=NEW: what came before stays");
    if (keyword == "*AMPLITUDE") return begin_amplitude();
    if (acts) amplitude_ = amplitude_of(keyword);
    if (keyword == "*BOUNDARY") {
      const std::string type = abaqus_upper(parameters_["TYPE"]);
      data_ = type.empty() || type == "DISPLACEMENT" ? Data::support : Data::unread;
      if (data_ == Data::unread) leave("*BOUNDARY, TYPE=" + type);
    } else if (keyword == "*CLOAD") {
      data_ = Data::force;
      if (parameters_.contains("FOLLOWER")) leave("*CLOAD, FOLLOWER: the force keeps its direction");
    } else if (keyword == "*DLOAD") {
      data_ = Data::pressure;
    } else if (keyword == "*STATIC" || keyword == "*FREQUENCY" || keyword == "*BUCKLE" || keyword == "*DYNAMIC") {
      data_ = Data::procedure;
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

  void take(const std::string& text) {
    const AbaqusWords words = abaqus_fields(text);
    if (words.empty()) return;
    switch (data_) {
      case Data::title:
        if (deck_.title.empty()) deck_.title = abaqus_trimmed(text);
        return;
      case Data::elastic:
      case Data::lamina:
        return take_elastic(words);
      case Data::density:
        deck_.materials[material_].density = number(words, 0);
        data_ = Data::none;
        return;
      case Data::section:
        deck_.sections.back().thickness = number(words, 0);
        data_ = Data::none;
        return;
      case Data::ply:
        return take_ply(words);
      case Data::axes:
        return take_axes(words);
      case Data::axis:
        return take_axis(words);
      case Data::support:
        return take_support(words);
      case Data::force:
        return take_force(words);
      case Data::pressure:
        return take_pressure(words);
      case Data::procedure:
        return take_procedure(words);
      case Data::amplitude:
        return take_amplitude(words);
      default:
        return;
    }
  }

  void take_elastic(const AbaqusWords& words) {
    Deck::Material& m = deck_.materials[material_];
    if (m.young > 0.0) leave("*ELASTIC: properties at other temperatures; the first line is taken");
    if (m.young > 0.0) return;
    m.orthotropic = data_ == Data::lamina;
    m.young = number(words, 0);
    if (m.orthotropic) {
      m.young_2 = number(words, 1);
      m.poisson = number(words, 2);
      m.shear = number(words, 3);
    } else {
      m.poisson = words.size() > 1 ? number(words, 1) : 0.0;
    }
  }

  /// A symmetric stack is given up to its middle.
  void take_ply(const AbaqusWords& words) {
    double angle = 0.0;
    if (words.size() > 3 && !words[3].empty() && !parse_number(words[3], angle))
      leave(fmt::format("{}, COMPOSITE: the orientation {} of a ply; its angle is 0", keyword_, words[3]));
    std::vector<Deck::Ply>& plies = deck_.sections.back().plies;
    const auto half =
        symmetric_ ? static_cast<std::ptrdiff_t>(plies.size() / 2) : static_cast<std::ptrdiff_t>(plies.size());
    const Deck::Ply ply{number(words, 0), words.size() > 2 ? abaqus_upper(words[2]) : "", angle};
    plies.insert(plies.begin() + half, symmetric_ ? 2 : 1, ply);
  }

  /// Two points in the plane of the local axes 1 and 2, and perhaps the origin.
  void take_axes(const AbaqusWords& words) {
    for (std::size_t k = 0; k < 6; ++k)
      points_[k] =
          number(words, k) - (words.size() > 6 + k % 3 && !words[6 + k % 3].empty() ? number(words, 6 + k % 3) : 0.0);
    orient(1);  // unless a second line says so
    data_ = Data::axis;
  }
  void take_axis(const AbaqusWords& words) {
    const long normal = words[0].empty() ? 1 : whole(words, 0);
    if (normal < 1 || normal > 3) fail_in_line(file_, line_, "*ORIENTATION: the axis is 1, 2 or 3");
    orient(normal);
    if (words.size() > 1 && !words[1].empty())
      deck_.orientations[abaqus_upper(parameters_["NAME"])].angle = number(words, 1);
    data_ = Data::none;
  }
  /// Axis 1 of a shell is the local axis that follows the one along its normal.
  void orient(long normal) {
    const Eigen::Map<const Vec3> x(points_.data()), in_plane(points_.data() + 3);
    const Vec3 z = x.cross(in_plane), y = z.cross(x);
    const Vec3 along = normal == 1 ? y.normalized() : normal == 2 ? z.normalized() : x.normalized();
    if (!(along.norm() > 0.5))
      fail_in_line(file_, line_, "*ORIENTATION: the two points and the origin lie on one line");
    deck_.orientations[abaqus_upper(parameters_["NAME"])].direction = {along[0], along[1], along[2]};
  }

  void take_support(const AbaqusWords& words) {
    Deck::Support& s = deck_.supports[words[0]];
    const std::string name = words.size() > 1 ? abaqus_upper(words[1]) : "";
    if (name == "ENCASTRE") {
      s.held.fill(true);
    } else if (name == "PINNED") {
      s.held[0] = s.held[1] = s.held[2] = true;
    } else if (name == "XSYMM" || name == "YSYMM" || name == "ZSYMM") {
      s.mirror = name;
    } else {
      const long first = whole(words, 1), last = words.size() > 2 && !words[2].empty() ? whole(words, 2) : first;
      const double value = words.size() > 3 ? number(words, 3) : 0.0;
      if (first < 1 || last > 6 || last < first)
        return leave("*BOUNDARY " + words[0] + ": degrees of freedom beyond 1 to 6");
      for (long k = first; k <= last; ++k) {
        s.held[static_cast<std::size_t>(k - 1)] = true;
        if (k <= 3) s.value[static_cast<std::size_t>(k - 1)] = value;
        if (k <= 3 && value != 0.0) take_amplitude_of(s, words[0]);
        if (k > 3 && value != 0.0) leave(fmt::format("*BOUNDARY {}: rotation {} by {}", words[0], k, value));
      }
    }
  }

  void take_amplitude_of(Deck::Support& s, const std::string& where) {
    if (!s.amplitude.empty() && s.amplitude != amplitude_)
      leave(fmt::format("*BOUNDARY {}: a second amplitude; {} is taken for all of its values", where, amplitude_));
    s.amplitude = amplitude_;
  }

  void take_amplitude(const AbaqusWords& words) {
    Deck::Table& table = deck_.amplitudes[amplitude_];
    for (std::size_t k = 0; k < words.size(); k += 2) {
      table.push_back({number(words, k), number(words, k + 1)});
      if (table.size() > 1 && !(table.back()[0] > table[table.size() - 2][0]))
        fail_in_line(file_, line_, "*AMPLITUDE: the times do not ascend");
    }
  }

  void take_force(const AbaqusWords& words) {
    const long direction = whole(words, 1);
    if (direction < 1 || direction > 3) return leave(fmt::format("*CLOAD {}: a moment", words[0]));
    Deck::Load load{Deck::Load::Kind::force, words[0], {}, 0.0, amplitude_};
    load.vector[static_cast<std::size_t>(direction - 1)] = number(words, 2);
    deck_.loads.push_back(load);
  }

  void take_pressure(const AbaqusWords& words) {
    const std::string label = words.size() > 1 ? abaqus_upper(words[1]) : "";
    if (label == "P") {
      deck_.loads.push_back({Deck::Load::Kind::pressure, words[0], {}, number(words, 2), amplitude_});
    } else if (label == "GRAV") {
      Deck::Load load{Deck::Load::Kind::gravity, words[0], {}, 0.0, amplitude_};
      for (std::size_t k = 0; k < 3; ++k)
        load.vector[k] = number(words, 2) * (words.size() > 3 + k ? number(words, 3 + k) : 0.0);
      deck_.loads.push_back(load);
    } else {
      leave(fmt::format("*DLOAD {}, {}", words[0], label));
    }
  }

  void take_procedure(const AbaqusWords& words) {
    if (deck_.procedure == Procedure::frequency || deck_.procedure == Procedure::buckle) {
      deck_.modes = static_cast<int>(std::min(whole(words, 0), most_modes));
      for (std::size_t k = 1; k < std::min<std::size_t>(words.size(), 4); ++k)
        if (deck_.procedure == Procedure::frequency && !words[k].empty())
          leave(fmt::format("*FREQUENCY, a bound or shift of {}: the lowest modes are found", words[k]));
    } else if (words.size() > 1) {
      deck_.step = number(words, 0);
      deck_.end = number(words, 1);
    }
    data_ = Data::none;
  }

  void include(int depth) {
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

  void leave(const std::string& what) { deck_.left.push_back({what, fmt::format("{}:{}", file_, line_)}); }

  [[nodiscard]] double number(const AbaqusWords& words, std::size_t k) const {
    double value = 0.0;
    if (k >= words.size() || !parse_number(words[k], value))
      fail_in_line(file_, line_, fmt::format("{}: a number is needed as entry {}", keyword_, k + 1));
    return value;
  }
  [[nodiscard]] long whole(const AbaqusWords& words, std::size_t k) const {
    long value = 0;
    if (k >= words.size() || !parse_integer(words[k], value))
      fail_in_line(file_, line_, fmt::format("{}: a whole number is needed as entry {}", keyword_, k + 1));
    return value;
  }

  static constexpr int most_included = 8;
  static constexpr long most_modes = 1000;

  std::string file_, keyword_, material_, amplitude_;
  std::map<std::string, std::string> parameters_;
  std::size_t line_ = 0;
  Data data_ = Data::none;
  int steps_ = 0;
  bool nonlinear_ = false, symmetric_ = false;
  std::array<double, 6> points_{};
  Deck deck_;
};

}  // namespace

Deck read_abaqus_deck(const std::string& file) {
  return DeckReader(file).run();
}

}  // namespace voile::formats
