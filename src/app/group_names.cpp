#include "group_names.hpp"

#include <fmt/format.h>

#include "voile/base/error.hpp"

namespace voile::app {

namespace {

class Checker {
 public:
  Checker(const input::Case& c, const mesh::SurfaceMesh& mesh) : c_(c), mesh_(mesh) {}

  /// An empty name is that of everything.
  void check(const char* section, const char* key, const std::string& name) const {
    if (name.empty() || mesh_.has_group(name)) return;
    try {
      (void)mesh_.group(name);
    } catch (const UserError& e) {
      throw UserError(fmt::format("{}: [[{}]] {} = \"{}\": {}", c_.file.string(), section, key, name, e.what()));
    }
  }
  template <class Items>
  void check_all(const char* section, const Items& items) const {
    for (const auto& item : items) check(section, "group", item.group);
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
    for (const std::string& name : m.groups) checker.check("material", "groups", name);
  checker.check_all("support", c.supports);
  checker.check_all("load", c.loads);
  checker.check_all("temperature", c.temperatures);
  checker.check_all("mass", c.masses);
  checker.check_all("spring", c.springs);
  for (const system::Spring& s : c.springs) checker.check("spring", "to", s.to);
  checker.check_all("initial_velocity", c.initial_velocities);
  checker.check_all("probe", c.probes);
  for (const system::Attachment& a : c.attachments)
    for (const std::string& name : a.groups) checker.check("attachment", "groups", name);
}

}  // namespace voile::app
