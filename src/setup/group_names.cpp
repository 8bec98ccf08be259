#include "group_names.hpp"

#include <fmt/format.h>

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

  /// An empty name is that of everything. `dimension`: 1 a curve, 2 a surface, -1 any.
  void check(const char* section, const char* key, const std::string& name, int dimension = -1) const {
    if (name.empty()) return;
    try {
      (void)mesh_.group(name, dimension);
    } catch (const UserError& e) {
      throw UserError(fmt::format("{}: [[{}]] {} = \"{}\": {}", c_.file.string(), section, key, name, e.what()));
    }
  }
  void check_gas(const system::Load& load) const {
    try {
      (void)system::gas_surface(mesh_, load);
    } catch (const UserError& e) {
      throw UserError(fmt::format("{}: {}", c_.file.string(), e.what()));
    }
  }
  template <class Items>
  void check_all(const char* section, const Items& items, int dimension = -1) const {
    for (const auto& item : items) check(section, "group", item.group, dimension);
  }

 private:
  const input::Case& c_;
  const mesh::SurfaceMesh& mesh_;
};

}  // namespace

void check_group_names(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  for (const input::Case& stage : c.stages) check_group_names(stage, mesh);
  if (!c.stages.empty()) return;
  const Checker checker(c, mesh);
  for (const energy::Material& m : c.materials)
    for (const std::string& name : m.groups) checker.check("material", "groups", name, 2);
  checker.check_all("support", c.supports);
  for (const input::RigidSection& s : c.rigids) checker.check("rigid", "group", s.group.group);
  for (const system::Load& l : c.loads) checker.check("load", "group", l.group, dimension_of(l.kind));
  for (const system::Load& l : c.loads)
    if (l.kind == system::Load::Kind::gas) checker.check_gas(l);
  checker.check_all("temperature", c.temperatures, 2);
  checker.check_all("mass", c.masses);
  checker.check_all("spring", c.springs);
  for (const system::Spring& s : c.springs) checker.check("spring", "to", s.to);
  checker.check_all("initial_velocity", c.initial_velocities);
  checker.check_all("probe", c.probes);
  for (const system::Attachment& a : c.attachments)
    for (const std::string& name : a.groups) checker.check("attachment", "groups", name);
}

}  // namespace voile::setup
