#include "group_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/group_list.hpp"
#include "base/text.hpp"
#include "input/case_lines.hpp"
#include "system/gas_surface.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

/// Of the groups that a load can act on; -1: any.
int dimension_of(system::Load::Kind kind) {
  using Kind = system::Load::Kind;
  if (kind == Kind::line || kind == Kind::follower_moment) return 1;
  return kind == Kind::pressure || kind == Kind::follower_pressure || kind == Kind::area || kind == Kind::gas ? 2 : -1;
}

class Checker {
 public:
  Checker(const input::Case& c, const mesh::SurfaceMesh& mesh) : c_(c), mesh_(mesh) {}

  /// Throws what all checks have found, if anything.
  void finish() const {
    constexpr std::size_t most = 10;
    if (mistakes_.empty()) return;
    std::string all = mistakes_.front();
    for (std::size_t i = 1; i < std::min(most, mistakes_.size()); ++i) all += "\n" + mistakes_[i];
    if (mistakes_.size() > most) all += fmt::format("\nand {} more", mistakes_.size() - most);
    throw UserError(all);
  }
  /// An empty name is that of everything. `dimension`: 1 a curve, 2 a surface, -1 any.
  void check(const char* section, const char* key, const std::string& name, int dimension = -1) {
    if (name.empty()) return;
    if (const std::vector<std::string> several = groups_of(name); several.size() > 1 && !mesh_.has_group(name)) {
      for (const std::string& one : several) check(section, key, one, dimension);
      return;
    }
    try {
      (void)mesh_.group(name, dimension);
    } catch (const UserError& e) {
      take(fmt::format("{}: [[{}]] {} = \"{}\": {}", input::place_in_case(c_.file, section, key, name), section, key,
                       name, e.what()));
    }
  }
  /// Of the two bodies of a rule.
  void check_body(const char* key, const std::string& name) {
    std::vector<std::string> known{"sheet"};
    for (const input::ObstacleSection& o : c_.obstacles) known.push_back(o.shape.name);
    for (const mesh::Group& g : mesh_.groups())
      if (g.dimension > 0) known.push_back(g.name);
    if (contains(known, name)) return;
    const bool is_point = mesh_.has_group(name);
    take(fmt::format("{}: [[contact_rule]] {}: {} '{}';{}", input::place_in_case(c_.file, "contact_rule", key, name),
                     key,
                     is_point ? "a rule is of surfaces and curves, not of the physical point"
                              : "there is no obstacle, physical surface or curve",
                     name, suggestion(name, known)));
  }
  void check_gas(const system::Load& load) {
    try {
      (void)system::gas_surface(mesh_, load);
    } catch (const UserError& e) {
      take(fmt::format("{}: {}", c_.file.string(), e.what()));
    }
  }
  /// The ground of an elastic edge does not turn with a support.
  void check_ground(const system::Hinge& hinge) {
    if (!mesh_.has_group(hinge.group)) return;
    const std::vector<Index>& line = mesh_.group(hinge.group).vertices;
    for (std::size_t i = 0; i < c_.supports.size(); ++i) {
      if (!c_.motions[i].axis || !mesh_.has_group(c_.supports[i].group)) continue;
      const std::vector<Index>& held = mesh_.group(c_.supports[i].group).vertices;
      std::vector<Index> both;
      std::set_intersection(line.begin(), line.end(), held.begin(), held.end(), std::back_inserter(both));
      if (both.size() < 2) continue;
      take(fmt::format(
          "{}: [[hinge]] group = \"{}\": the [[support]] of '{}' turns, and the ground of an elastic edge does "
          "not; turn a `clamped` edge, or remove the hinge",
          c_.file.string(), hinge.group, c_.supports[i].group));
    }
  }
  template <class Items>
  void check_all(const char* section, const Items& items, int dimension = -1) {
    for (const auto& item : items) check(section, "group", item.group, dimension);
  }

 private:
  void take(const std::string& mistake) {
    if (!contains(mistakes_, mistake)) mistakes_.push_back(mistake);
  }

  const input::Case& c_;
  const mesh::SurfaceMesh& mesh_;
  std::vector<std::string> mistakes_;
};

}  // namespace

void check_group_names(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  for (const input::Case& stage : c.stages) check_group_names(stage, mesh);
  if (!c.stages.empty()) return;
  Checker checker(c, mesh);
  for (const energy::Material& m : c.materials)
    for (const std::string& name : m.groups) checker.check("material", "groups", name, 2);
  checker.check_all("support", c.supports);
  for (const input::RigidSection& s : c.rigids) checker.check("rigid", "group", s.group.group);
  for (const input::PeriodicSection& s : c.periodics) {
    checker.check("periodic", "from", s.pair.from, 1);
    checker.check("periodic", "to", s.pair.to, 1);
  }
  for (const system::Load& l : c.loads) checker.check("load", "group", l.group, dimension_of(l.kind));
  for (const system::Load& l : c.loads)
    if (l.kind == system::Load::Kind::gas) checker.check_gas(l);
  checker.check_all("temperature", c.temperatures, 2);
  checker.check_all("hinge", c.hinges, 1);
  for (const system::Hinge& hinge : c.hinges) checker.check_ground(hinge);
  checker.check_all("mass", c.masses);
  checker.check_all("spring", c.springs);
  for (const system::Spring& s : c.springs) checker.check("spring", "to", s.to);
  checker.check_all("initial_velocity", c.initial_velocities);
  checker.check_all("probe", c.probes);
  for (const input::RuleSection& r : c.contact_rules) {
    checker.check_body("first", r.first);
    checker.check_body("second", r.second);
  }
  for (const system::Attachment& a : c.attachments)
    for (const std::string& name : a.groups) checker.check("attachment", "groups", name);
  checker.finish();
}

}  // namespace voile::setup
