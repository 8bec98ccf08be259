// What Nastran bulk data has besides its mesh, in the words of a deck.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "deck.hpp"
#include "nastran_cards.hpp"
#include "nastran_properties.hpp"

namespace voile::formats {

namespace {

using Procedure = Deck::Procedure;

/// Cards that the mesh reader takes, or that change nothing here.
bool is_passed_over(const std::string& name) {
  static const std::set<std::string> all{"GRID",   "GRDSET", "CTRIA3", "CTRIAR", "CTRIA6", "CQUAD4", "CQUADR",
                                         "CQUAD8", "CQUAD",  "SPC",    "SPC1",   "SPCADD", "LOAD",   "FORCE",
                                         "PLOAD2", "PLOAD4", "GRAV",   "MAT1",   "MAT8",   "PSHELL", "PCOMP",
                                         "EIGRL",  "EIGR",   "EIGB",   "NLPARM"};
  return all.contains(name) || name.starts_with("CORD");
}

class NastranDeckReader {
 public:
  explicit NastranDeckReader(const std::string& file) : read_(read_nastran_file(file)), systems_(read_.cards) {
    deck_.words = {"a Nastran deck", "elements", "SPC", "FORCE or PLOAD", "PSHELL or PCOMP", "GRAV", "SOL"};
  }

  Deck run() {
    for (const NastranCard& line : read_.control) take_control(line);
    for (const NastranCard& card : read_.cards) {
      if (card.name.starts_with("CTRIA") || card.name.starts_with("CQUAD")) shells_.insert(card.whole(1));
      if (card.name == "GRID") points_[card.whole(1)] = &card;
      if (card.name == "GRID") grids_.insert(card.whole(1));
      if (card.name == "GRDSET") defaults_ = &card;
      if (card.name == "PARAM" && card.field(1) == "WTMASS") mass_ = card.real(2);
      if (card.name == "PARAM" && card.field(1) == "LGDISP") large_ = card.real(2) > 0.0;
      if (!is_passed_over(card.name) && card.name != "PARAM" && seen_.insert(card.name).second) leave(card, card.name);
    }
    for (const NastranCard& card : read_.cards) take_method(card);
    choose_deflections();
    check_selected();
    NastranProperties(read_.cards, systems_).add_to(deck_, mass_);
    hold_always();
    select_supports();
    select_loads();
    return std::move(deck_);
  }

 private:
  void leave(const NastranCard& card, const std::string& what) {
    deck_.left.push_back({what, fmt::format("{}:{}", card.file, card.line)});
  }

  void take_control(const NastranCard& line) {
    if (line.name.starts_with("PARAM") && line.name.find("LGDISP") != std::string::npos)
      large_ = line.name.find('-') == std::string::npos && line.name.find(",0") == std::string::npos;
    const std::size_t equal = line.name.find('=');
    std::string key = line.name.substr(0, std::min(equal, line.name.find('(')));
    while (!key.empty() && key.back() == ' ') key.pop_back();
    if (key.starts_with("SOL ") || key.starts_with("SOL,")) return take_solution(line, key.substr(4));
    if (key.starts_with("SUBCASE") && ++subcases_ == 2)
      leave(line, "a second SUBCASE; SPC and LOAD are those of the first");
    if (equal == std::string::npos) return;
    std::string value = line.name.substr(equal + 1);
    value.erase(0, value.find_first_not_of(' '));
    if (key == "TITLE") deck_.title = value;
    for (const auto& [name, slot] : {std::pair{"SPC", &spc_}, {"LOAD", &load_}, {"METHOD", &method_}})
      // Those of a subcase win over those above it.
      if (key == name && subcases_ < 2) {
        selected_[key] = NastranCard{key, {value}, line.file, line.line};
        *slot = selected_[key].whole(1);
      }
  }

  /// A set that is selected and not there would be no load or no support at all.
  void check_selected() const {
    static const std::map<std::string, std::vector<const char*>> kinds{
        {"SPC", {"SPC"}},
        {"LOAD", {"LOAD", "FORCE", "MOMENT", "PLOAD", "GRAV", "RFORCE", "ACCEL", "SLOAD", "SPCD", "TEMP"}},
        {"METHOD", {"EIG"}}};
    const auto check = [&](const std::string& kind, const NastranCard& by, const std::string& id) {
      const std::vector<const char*>& names = kinds.at(kind);
      const bool found = std::any_of(read_.cards.begin(), read_.cards.end(), [&](const NastranCard& card) {
        return card.field(1) == id &&
               std::any_of(names.begin(), names.end(), [&](const char* name) { return card.name.starts_with(name); });
      });
      if (!found) by.fail(fmt::format("there is no card {} of set {}; add it, or select another", names[0], id));
    };
    for (const auto& [kind, by] : selected_) check(kind, by, by.field(1));
    for (const NastranCard& card : read_.cards)
      if (card.name == "LOAD" && load_ && card.whole(1) == *load_)
        for (std::size_t k = 3; !card.field(k).empty(); k += 2) check("LOAD", card, card.field(k + 1));
  }

  void take_solution(const NastranCard& line, std::string name) {
    name = name.substr(std::min(name.find_first_not_of(' '), name.size()));
    name = name.substr(0, name.find_first_of(" ,"));
    const auto is = [&](std::initializer_list<const char*> names) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    if (is({"1", "101", "SESTATIC", "SESTATICS"})) deck_.procedure = Procedure::linear;
    if (is({"3", "103", "SEMODES"})) deck_.procedure = Procedure::frequency;
    if (is({"5", "105", "SEBUCKL"})) deck_.procedure = Procedure::buckle;
    if (is({"106", "400", "NLSTATIC", "NONLIN"})) deck_.procedure = Procedure::nonlinear;
    if (deck_.procedure == Procedure::none) leave(line, "SOL " + name);
    small_by_default_ = is({"106", "NLSTATIC"});
    solution_ = line;
  }

  /// A nonlinear solution has large displacements where PARAM,LGDISP says so.
  void choose_deflections() {
    if (deck_.procedure != Procedure::nonlinear || large_.value_or(!small_by_default_)) return;
    deck_.procedure = Procedure::linear;
    leave(solution_, solution_.name + (large_ ? ", PARAM,LGDISP,-1" : " without PARAM,LGDISP,1") +
                         ": small displacements, analysis = \"linear\"; give \"static\" if they are large");
  }

  void take_method(const NastranCard& card) {
    const bool lanczos = card.name == "EIGRL";
    if (!(lanczos || card.name == "EIGR" || card.name == "EIGB") || (method_ && card.whole(1) != *method_)) return;
    deck_.modes = modes(card, lanczos ? 4 : 6);
    for (const std::size_t k : {lanczos ? 2 : 3, lanczos ? 3 : 4})
      if (!card.field(k).empty())
        leave(card, fmt::format("{}, a bound of {}: the lowest modes are found", card.name, card.field(k)));
  }

  static int modes(const NastranCard& card, std::size_t field) {
    return static_cast<int>(std::clamp(card.whole(field, 0L), 0L, 1000L));
  }

  /// Adds digits 1 to 6 of `components` to what holds a grid point.
  void hold(const NastranCard& card, long id, const std::string& components, double value) {
    const auto at = points_.find(id);
    if (at == points_.end()) return;
    const long given = defaults_ ? defaults_->whole(6, 0L) : 0L, system = at->second->whole(6, given);
    const auto moves = std::count_if(components.begin(), components.end(), [](char c) { return c >= '1' && c <= '3'; });
    if (system > 0 && moves > 0 && (moves < 3 || value != 0.0)) {
      if (seen_.insert(fmt::format("CD {}", system)).second)
        leave(card, fmt::format(
                        "{}: components in coordinate system {}, as of grid point {}; write that [[support]] yourself",
                        card.name, system, id));
      return;
    }
    Deck::Support& s = deck_.supports[std::to_string(id)];
    for (const char c : components) {
      if (c == '0') continue;
      if (c < '1' || c > '6') card.fail(fmt::format("'{}' are no components 1 to 6", components));
      const auto k = static_cast<std::size_t>(c - '1');
      s.held[k] = true;
      if (k < 3 && value != 0.0) s.value[k] = value;
      if (k >= 3 && value != 0.0) leave(card, fmt::format("{}: a rotation by {}", card.name, value));
    }
  }

  /// Field 8 of GRID and GRDSET.
  void hold_always() {
    const std::string given = defaults_ ? defaults_->field(7) : "";
    for (const auto& [id, card] : points_) {
      std::string components = card->field(7).empty() ? given : card->field(7);
      // The turn about the normal, which shells do not resist.
      if (components == "6") components.clear();
      if (!components.empty()) hold(*card, id, components, 0.0);
    }
  }

  void select_supports() {
    std::set<long> sets;
    if (spc_) sets.insert(*spc_);
    std::set<long> known;
    for (const NastranCard& card : read_.cards)
      if (card.name == "SPC" || card.name == "SPC1") known.insert(card.whole(1));
    for (const NastranCard& card : read_.cards)
      if (card.name == "SPCADD" && spc_ && card.whole(1) == *spc_)
        for (const long set : card.list(2, known)) sets.insert(set);
    for (const NastranCard& card : read_.cards) {
      if (card.name != "SPC" && card.name != "SPC1") continue;
      if (!read_.control.empty() && !sets.contains(card.whole(1))) continue;
      if (card.name == "SPC1")
        for (const long id : card.list(3, grids_)) hold(card, id, card.field(2), 0.0);
      else
        for (const std::size_t k : {2, 5})
          if (!card.field(k).empty()) hold(card, card.whole(k), card.field(k + 1), card.real(k + 2, 0.0));
    }
  }

  void select_loads() {
    std::map<long, double> factors;
    if (load_) factors[*load_] += 1.0;
    for (const NastranCard& card : read_.cards)
      if (card.name == "LOAD" && load_ && card.whole(1) == *load_)
        for (std::size_t k = 3; !card.field(k).empty(); k += 2)
          factors[card.whole(k + 1)] += card.real(2) * card.real(k);
    for (const NastranCard& card : read_.cards) {
      if (card.name != "FORCE" && card.name != "PLOAD2" && card.name != "PLOAD4" && card.name != "GRAV") continue;
      const auto at = factors.find(card.whole(1));
      if (read_.control.empty())
        take_load(card, 1.0);
      else if (at != factors.end())
        take_load(card, at->second);
    }
  }

  void take_load(const NastranCard& card, double factor) {
    if (card.name == "PLOAD2") return press(card, card.list(3, shells_), factor * card.real(2));
    if (card.name == "PLOAD4") return take_faces(card, factor);
    const bool gravity = card.name == "GRAV";
    const std::size_t k = gravity ? 2 : 3;  // coordinate system, size, direction
    const Vec3 direction(card.real(k + 2, 0.0), card.real(k + 3, 0.0), card.real(k + 4, 0.0));
    const Vec3 v = factor * card.real(k + 1) * systems_.turned(card.whole(k, 0L), direction, card);
    Deck::Load load{
        gravity ? Deck::Load::Kind::gravity : Deck::Load::Kind::force, gravity ? "" : card.field(2), {}, 0.0, ""};
    for (std::size_t i = 0; i < 3; ++i) load.vector[i] = v[static_cast<Eigen::Index>(i)];
    deck_.loads.push_back(load);
  }

  void take_faces(const NastranCard& card, double factor) {
    const double p = card.real(3);
    for (std::size_t k = 4; k <= 6; ++k)
      if (card.real(k, p) != p) return leave(card, "PLOAD4: a pressure that differs between corners");
    for (std::size_t k = 9; k <= 12; ++k)
      if (!card.field(k).empty() && card.real(k) != 0.0) return leave(card, "PLOAD4: a direction of its own");
    const bool range = card.field(7) == "THRU";
    if (!range && !card.field(7).empty()) return leave(card, "PLOAD4: a face of a solid");
    std::vector<long> elements{card.whole(2)};
    if (range)
      for (auto e = shells_.upper_bound(elements[0]); e != shells_.end() && *e <= card.whole(8); ++e)
        elements.push_back(*e);
    press(card, elements, factor * p);
  }

  void press(const NastranCard&, const std::vector<long>& elements, double size) {
    for (const long e : elements) deck_.loads.push_back({Deck::Load::Kind::pressure, std::to_string(e), {}, size, ""});
  }

  NastranFile read_;
  NastranSystems systems_;
  Deck deck_;
  int subcases_ = 0;
  std::optional<long> spc_, load_, method_;
  std::map<std::string, NastranCard> selected_;  ///< lines of the case control, by SPC, LOAD or METHOD
  double mass_ = 1.0;                            ///< PARAM, WTMASS
  std::optional<bool> large_;                    ///< PARAM, LGDISP
  bool small_by_default_ = false;
  NastranCard solution_;
  std::set<long> grids_, shells_;  ///< grid points; elements
  std::set<std::string> seen_;
  std::map<long, const NastranCard*> points_;
  const NastranCard* defaults_ = nullptr;
};

}  // namespace

Deck read_nastran_deck(const std::string& file) {
  return NastranDeckReader(file).run();
}

}  // namespace voile::formats
