#include "deck_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "base/text.hpp"
#include "deck_loads.hpp"
#include "deck_material.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

using formats::Deck;
using Procedure = Deck::Procedure;

bool is_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

class CaseWriter {
 public:
  CaseWriter(Deck deck, mesh::MeshData mesh) : deck_(std::move(deck)), mesh_(std::move(mesh)) {}

  std::string text() {
    out_ = fmt::format(
        "# From {0}, in the units of the deck; name them in [units] if they are not SI.\ntitle = "
        "{1}\nanalysis = {2}\n\n",
        deck_.words.deck, toml_text(deck_.title.empty() ? "From " + deck_.words.deck : deck_.title),
        toml_text(analysis()));
    out_ += "[mesh]\nfile = \"mesh.inp\"\n";
    if (deck_.tied) out_ += "merge = true  # *TIE: parts are joined wherever they touch\n";
    if (deck_.tie_tolerance > 0.0)
      out_ += fmt::format("merge_tolerance = {}  # goes with `scale`\n", deck_.tie_tolerance);
    for (const Deck::Section& s : deck_.sections) add_material(s);
    add_supports();
    add_loads();
    out_ += temperature_;
    add_procedure();
    if (!left_.empty()) {
      out_ += "\n# Left out:\n";
      for (const std::string& text : left_) out_ += "# * " + text + "\n";
    }
    return out_;
  }
  /// Sets of single nodes and elements that the case names.
  [[nodiscard]] const std::string& sets() const { return sets_; }
  [[nodiscard]] const std::vector<std::string>& left() const { return left_; }
  [[nodiscard]] const Deck& deck() const { return deck_; }
  [[nodiscard]] bool has_material() const { return has_material_; }

  void collect_left() {
    for (const Deck::Left& l : deck_.left) leave(fmt::format("{}: {}", l.place, l.what));
    for (const std::string& note : mesh_.notes)
      if (const std::size_t end = note.find(" were left out"); end != note.npos)
        leave(deck_.words.element + ": " + note.substr(0, end) + ", which are no shells");
    drop_elsewhere();
    drop_turned(deck_, mesh_, left_);
    temperature_ = temperature_of(deck_, mesh_, left_);
    complete_clamps();
    note_turned();
    if (deck_.sections.empty()) leave("no " + deck_.words.section + ": write a [[material]] yourself");
    if (deck_.procedure == Procedure::none)
      leave("no " + deck_.words.step + " that is known: analysis = \"static\" is assumed");
  }

 private:
  [[nodiscard]] std::string analysis() const {
    switch (deck_.procedure) {
      case Procedure::linear:
        return "linear";
      case Procedure::frequency:
        return "modal";
      case Procedure::buckle:
        return "buckling";
      case Procedure::dynamic:
        return "dynamic";
      default:
        return "static";
    }
  }

  void leave(const std::string& text) {
    if (std::find(left_.begin(), left_.end(), text) == left_.end()) left_.push_back(text);
  }

  /// A shell does not resist the turn about its normal: held in the other two turns, it is clamped.
  void complete_clamps() {
    for (auto& [where, s] : deck_.supports) {
      auto& h = s.held;
      if (!(h[0] && h[1] && h[2]) || h[3] + h[4] + h[5] != 2) continue;
      const std::size_t left = h[3] ? (h[4] ? 5 : 4) : 3;
      const std::vector<char> at = vertices_of(mesh_, where);
      const auto turns_freely = [&](const mesh::Triangle& t) {
        if (std::none_of(t.begin(), t.end(), [&](Index v) { return at[static_cast<std::size_t>(v)]; })) return true;
        const auto x = [&](std::size_t k) { return mesh_.positions[static_cast<std::size_t>(t[k])]; };
        const Vec3 normal = (x(1) - x(0)).cross(x(2) - x(0));
        return std::abs(normal[static_cast<Eigen::Index>(left) - 3]) > 0.99 * normal.norm();
      };
      h[left] = std::all_of(mesh_.triangles.begin(), mesh_.triangles.end(), turns_freely);
    }
  }

  /// Pressures act along the normals of the deck, plies lie along them, and a surface is oriented as one.
  void note_turned() {
    const auto presses = [](const Deck::Load& l) { return l.kind == Deck::Load::Kind::pressure; };
    const auto has_sides = [](const Deck::Section& s) { return !s.plies.empty() || !s.orientation.empty(); };
    const bool pressed = std::any_of(deck_.loads.begin(), deck_.loads.end(), presses),
               sided = std::any_of(deck_.sections.begin(), deck_.sections.end(), has_sides);
    if (!pressed && !sided) return;
    const Index turned = mesh::SurfaceMesh(mesh_).reoriented_count();
    if (turned == 0) return;
    for (const auto& [what, keyword] : {std::pair{pressed ? "pressures change their sign" : "", &deck_.words.load},
                                        {sided ? "plies and angles are reversed" : "", &deck_.words.section}})
      if (*what)
        leave(fmt::format("{}: {} triangles are turned round, where {}; orient the deck's elements alike", *keyword,
                          turned, what));
  }

  /// Supports and loads of nodes and elements that are no part of a shell.
  void drop_elsewhere() {
    std::erase_if(deck_.supports, [&](const auto& s) { return !is_on_sheet(s.first, true, deck_.words.support); });
    std::erase_if(deck_.loads, [&](const Deck::Load& l) {
      if (l.kind != Deck::Load::Kind::gravity)
        return !is_on_sheet(l.where, l.kind == Deck::Load::Kind::force, deck_.words.load);
      return !l.where.empty() && !is_on_sheet(l.where, false, deck_.words.gravity);
    });
    divide_gravity(deck_, mesh_, left_);
    for (const auto& [keyword, members] : elsewhere_)
      leave(fmt::format("{}: {} {} no part of a shell: {}{}", keyword, members.size(),
                        members.size() == 1 ? "place is" : "places are", members.front(),
                        members.size() == 1 ? "" : ", ..."));
  }

  [[nodiscard]] const mesh::Group* group_of(const std::string& name) const { return group_named(mesh_, name); }

  [[nodiscard]] bool is_on_sheet(const std::string& where, bool node, const std::string& keyword) {
    bool there = group_of(where) != nullptr;
    if (is_number(where)) {
      const auto& tags = node ? mesh_.vertex_tags : mesh_.triangle_tags;
      there = std::find(tags.begin(), tags.end(), std::strtoull(where.c_str(), nullptr, 10)) != tags.end();
    }
    if (!there) elsewhere_[keyword].push_back(where);
    return there;
  }

  void add_material(const Deck::Section& s) {
    const DeckMaterial made = deck_material(deck_, s, square_to_x(mesh_, group_of(s.elements)));
    for (const std::string& text : made.left) leave(text);
    if (made.text.empty()) return;
    has_material_ = true;
    out_ += made.text;
    if (!covers_all(s.elements))
      out_ += fmt::format("groups = [{}]\n", toml_text(known(s.elements, deck_.element_sets)));
  }

  [[nodiscard]] bool covers_all(const std::string& elements) {
    const mesh::Group* group = group_of(elements);
    if (!group)
      leave(
          fmt::format("{} of {}: there is no such set of shells; name one in `groups`", deck_.words.section, elements));
    return group && std::set(group->triangles.begin(), group->triangles.end()).size() == mesh_.triangles.size();
  }

  void add_supports() {
    // Nodes that are held alike are one group.
    std::map<std::string, std::vector<std::string>> nodes;
    std::map<std::string, Deck::Support> alike;
    for (const auto& [where, s] : deck_.supports) {
      if (!is_number(where)) {
        add_support(known(where, deck_.node_sets), s, vertices_of(mesh_, where));
        continue;
      }
      const std::string key =
          fmt::format("{}{}{} {}", s.mirror, fmt::join(s.held, ""), s.amplitude, fmt::join(s.value, " "));
      nodes[key].push_back(where);
      alike[key] = s;
    }
    for (const auto& [key, members] : nodes) {
      const std::set<std::string> all(members.begin(), members.end());
      std::vector<char> at(mesh_.positions.size(), 0);
      for (std::size_t v = 0; v < at.size(); ++v) at[v] = all.contains(std::to_string(mesh_.vertex_tags[v])) ? 1 : 0;
      add_support(new_set("*NSET, NSET=", "HELD", members), alike[key], at);
    }
  }

  void add_support(const std::string& group, const Deck::Support& s, const std::vector<char>& at) {
    const auto& h = s.held;
    const int moves = h[0] + h[1] + h[2], turns = h[3] + h[4] + h[5];
    const int mirror = mirror_of(s, mesh_, at);
    const bool moved = s.value != std::array<double, 3>{};
    const auto head = [&](const char* type) {
      out_ += fmt::format("\n[[support]]\ngroup = {}\ntype = \"{}\"\n", toml_text(group), type);
    };
    if (mirror >= 0 && !moved && !lies_in_mirror(mirror, mesh_, at)) {
      head("symmetry");
      out_ += fmt::format("normal = [{}, {}, {}]\n", mirror == 0 ? 1 : 0, mirror == 1 ? 1 : 0, mirror == 2 ? 1 : 0);
      const std::string rest = components_of(s, mirror, false);
      if (!rest.empty())
        out_ += fmt::format("\n[[support]]\ngroup = {}\ntype = \"displacement\"\n{}", toml_text(group), rest);
      return;
    }
    if (mirror >= 0) {  // an edge that does not turn
      head(has_slopes(group, at) && !is_area(mesh_, group) ? "sliding" : "displacement");
      if (!has_slopes(group, at)) leave_slopes(group);
      out_ += components_of(s, mirror, true) + (moved ? moved_by(s) : "");
      return;
    }
    if (moves == 3 && turns == 3 && !has_slopes(group, at)) {
      head("hinged");
      leave_slopes(group);
    } else if (moves == 3 && turns == 3) {
      head("clamped");
    } else if (moves == 3) {
      head("hinged");
    } else if (moves > 0) {
      head("displacement");
      out_ += components_of(s, -1, false);
    }
    if (moved) out_ += moved_by(s);
    if (turns > 0 && !(moves == 3 && turns == 3))
      leave(fmt::format("{} {}: rotations held in part; slopes are held only where 1 to 6 all are", deck_.words.support,
                        group));
  }

  /// Whether the slope at a group of these vertices can be held: not at points.
  [[nodiscard]] bool has_slopes(const std::string& group, const std::vector<char>& at) const {
    const auto is = [&](const mesh::Group& g) { return g.name == group; };
    return (std::none_of(mesh_.groups.begin(), mesh_.groups.end(), is) && has_edge(mesh_, at)) ||
           std::any_of(mesh_.groups.begin(), mesh_.groups.end(),
                       [&](const mesh::Group& g) { return is(g) && g.dimension > 0; });
  }
  void leave_slopes(const std::string& group) {
    leave(fmt::format("{} {}: rotations; no boundary edges connect its nodes, nor triangles, so that it has no slope",
                      deck_.words.support, group));
  }

  /// What is held, with or without the normal of a mirror plane; empty if nothing is.
  [[nodiscard]] static std::string components_of(const Deck::Support& s, int mirror, bool normal) {
    std::vector<std::string> names;
    for (int k = 0; k < 3; ++k)
      if (k == mirror ? normal : s.held[static_cast<std::size_t>(k)]) names.push_back(fmt::format("\"{}\"", "xyz"[k]));
    return names.empty() ? "" : fmt::format("components = [{}]\n", fmt::join(names, ", "));
  }

  [[nodiscard]] std::string moved_by(const Deck::Support& s) {
    const auto& v = s.value;
    if (s.amplitude.empty() || deck_.procedure != Procedure::dynamic) {
      const double factor = factor_at_end(s.amplitude);
      return fmt::format("value = [{}, {}, {}]\n", factor * v[0], factor * v[1], factor * v[2]);
    }
    const std::string table = table_of(s.amplitude);
    const auto along = [&](double size) { return size == 0.0 ? "0" : fmt::format("{} * {}", size, table); };
    return fmt::format("motion = [{}, {}, {}]\n", toml_text(along(v[0])), toml_text(along(v[1])),
                       toml_text(along(v[2])));
  }

  /// An amplitude as an expression of the time.
  [[nodiscard]] std::string table_of(const std::string& amplitude) const {
    std::string text = "table(t";
    for (const auto& [time, factor] : deck_.amplitudes.at(amplitude)) text += fmt::format(", {}, {}", time, factor);
    return text + ")";
  }

  /// What loads of a step without time end with: there they grow in proportion.
  [[nodiscard]] double factor_at_end(const std::string& amplitude) {
    if (amplitude.empty()) return 1.0;
    const Deck::Table& table = deck_.amplitudes.at(amplitude);
    const auto next =
        std::find_if(table.begin(), table.end(), [&](const auto& entry) { return entry[0] >= deck_.end; });
    double factor = next == table.end() ? table.back()[1] : (*next)[1];
    if (next != table.end() && next != table.begin()) {
      const auto& [t0, f0] = *(next - 1);
      const auto& [t1, f1] = *next;
      factor = f0 + (f1 - f0) * (deck_.end - t0) / (t1 - t0);
    }
    if (std::any_of(table.begin(), table.end(), [&](const auto& entry) {
          return entry[0] <= deck_.end && std::abs(entry[1] * deck_.end - entry[0] * factor) > 1e-9 * std::abs(factor);
        }))
      leave(fmt::format("*AMPLITUDE {}: loads grow in proportion to {}, its value at the end of the step", amplitude,
                        factor));
    return factor;
  }

  /// Lines of a load that say how it depends on time; the factor of its size, if it does not.
  [[nodiscard]] std::string history_of(const Deck::Load& l, double& factor) {
    factor = 1.0;
    if (l.amplitude.empty()) return "";
    if (deck_.procedure == Procedure::dynamic) return fmt::format("history = {}\n", toml_text(table_of(l.amplitude)));
    factor = factor_at_end(l.amplitude);
    return "";
  }

  [[nodiscard]] static std::string vector_text(const std::array<double, 3>& v, const std::string& history) {
    return fmt::format("vector = [{}, {}, {}]\n{}", v[0], v[1], v[2], history);
  }

  [[nodiscard]] static std::string size_text(double size, const std::string& history) {
    return fmt::format("magnitude = {}            # along the normals of the triangles\n{}", size, history);
  }

  void add_loads() {
    // Several lines on one node or element add up.
    std::map<std::pair<std::string, std::string>, std::array<double, 3>> forces;  // by history and place
    std::map<std::pair<std::string, std::string>, double> pressures;
    for (const Deck::Load& l : deck_.loads) {
      double factor = 1.0;
      const std::string history = history_of(l, factor);
      const std::string vector =
          vector_text({factor * l.vector[0], factor * l.vector[1], factor * l.vector[2]}, history);
      if (l.kind == Deck::Load::Kind::gravity) {
        out_ += "\n[[load]]\ntype = \"gravity\"\n" + vector;
      } else if (l.kind == Deck::Load::Kind::area) {
        out_ += fmt::format("\n[[load]]                   # weight per area\ntype = \"area\"\ngroup = {}\n{}",
                            toml_text(known(l.where, deck_.element_sets)), vector);
      } else if (l.kind == Deck::Load::Kind::pressure) {
        if (is_number(l.where))
          pressures[{history, l.where}] += factor * l.size;
        else
          out_ += fmt::format("\n[[load]]\ntype = \"{}\"\ngroup = {}\n{}", pressure(),
                              toml_text(known(l.where, deck_.element_sets)), size_text(factor * l.size, history));
      } else if (is_number(l.where)) {
        std::array<double, 3>& sum = forces[{history, l.where}];
        for (std::size_t k = 0; k < 3; ++k) sum[k] += factor * l.vector[k];
      } else {
        out_ += fmt::format("\n[[load]]                   # on every node\ntype = \"point\"\ngroup = {}\n{}",
                            toml_text(known(l.where, deck_.node_sets)), vector);
      }
    }
    std::map<std::string, std::vector<std::string>> nodes, elements;  // by what acts on them
    for (const auto& [at, sum] : forces) nodes[vector_text(sum, at.first)].push_back(at.second);
    for (const auto& [at, sum] : pressures) elements[size_text(sum, at.first)].push_back(at.second);
    for (const auto& [vector, members] : nodes)
      out_ += fmt::format("\n[[load]]                   # on every node\ntype = \"point\"\ngroup = {}\n{}",
                          toml_text(new_set("*NSET, NSET=", "LOADED", members)), vector);
    for (const auto& [size, members] : elements)
      out_ += fmt::format("\n[[load]]\ntype = \"{}\"\ngroup = {}\n{}", pressure(),
                          toml_text(new_set("*ELSET, ELSET=", "PRESSED", members)), size);
  }

  /// With large deflections Abaqus lets a pressure follow the surface.
  [[nodiscard]] const char* pressure() const {
    const bool large = deck_.procedure != Procedure::linear && deck_.procedure != Procedure::frequency &&
                       deck_.procedure != Procedure::buckle;
    return large ? "follower_pressure" : "pressure";
  }

  void add_procedure() {
    if (deck_.procedure == Procedure::riks) {
      out_ += fmt::format("\n[steps]\ncontrol = \"arc_length\"\nfinal_load_factor = {}\n", deck_.factor);
      if (deck_.step > 0.0) out_ += fmt::format("initial_step = {}\n", deck_.step / deck_.end);
    }
    if (deck_.modes > 0) out_ += fmt::format("\n[eigen]\nmodes = {}\n", deck_.modes);
    if (deck_.procedure == Procedure::dynamic && deck_.end > 0.0)
      out_ += fmt::format("\n[time]\nend = {}\nstep = {}\n", deck_.end, deck_.step);
  }

  std::string new_set(const char* keyword, const char* kind, const std::vector<std::string>& members) {
    std::string name = fmt::format("{}_{}", kind, ++made_);
    sets_ += keyword + name + "\n";
    for (const std::string& m : members) sets_ += m + ",\n";
    return name;
  }

  /// A set as the deck writes it where it is made.
  [[nodiscard]] static std::string known(const std::string& name, const std::vector<std::string>& sets) {
    const auto at = std::find_if(sets.begin(), sets.end(), [&](const std::string& s) { return same_name(s, name); });
    return at == sets.end() ? name : *at;
  }

  Deck deck_;
  mesh::MeshData mesh_;
  bool has_material_ = false;
  std::map<std::string, std::vector<std::string>> elsewhere_;  ///< by keyword
  std::string out_, sets_, temperature_;
  std::vector<std::string> left_;
  int made_ = 0;
};

}  // namespace

DeckCase deck_case(const Deck& deck, const mesh::MeshData& mesh) {
  CaseWriter writer(deck, mesh);
  writer.collect_left();
  DeckCase made;
  made.text = writer.text();
  made.sets = writer.sets();
  made.left = writer.left();
  made.has_material = writer.has_material();
  made.materials = writer.deck().sections.size();
  return made;
}

}  // namespace voile::cli
