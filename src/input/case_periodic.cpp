#include "case_periodic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "case_loads.hpp"
#include "case_sections.hpp"
#include "mesh/periodic.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

constexpr const char* directions[] = {"x", "y", "z"};

using Functions = std::array<std::function<double(double)>, 3>;

std::optional<double> plain_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// What one component of the difference is.
void take_component(const SectionPlace& place, const Case& c, std::size_t k, PeriodicSection& s, Functions& moving) {
  const std::string& text = s.difference[k];
  const auto i = static_cast<Eigen::Index>(k);
  s.pair.held[k] = text != "free";
  if (!s.pair.held[k]) return;
  if (s.pair.force[i] != 0.0)
    place.fail("force", fmt::format("its {} component acts where the difference is prescribed; set it to 0, or the "
                                    "difference to \"free\"",
                                    directions[k]));
  const std::optional<double> number = plain_number(text);
  if (number) s.pair.difference[i] = *number;
  if (number == 0.0) return;
  // A stage may hold what another has moved, and its own are looked at with those (simulation/stage_periodic.cpp).
  if (c.analysis == Analysis::dynamic && !c.is_staged())
    place.fail("difference", fmt::format("{} = {}: edges that move apart in time are not modelled; use 0, or \"free\" "
                                         "with a force",
                                         directions[k], text));
  if (number) return;
  if (!c.is_staged() && (c.analysis != Analysis::statics || c.steps.control != solve::StaticOptions::Control::load))
    place.fail("difference", fmt::format("{} = \"{}\": an expression needs analysis = \"static\" with steps.control = "
                                         "\"load\"; give a number, which grows with the load factor",
                                         directions[k], text));
  moving[k] = time_function(place, "difference", text);
}

void take_difference(const SectionPlace& place, const Case& c, PeriodicSection& s) {
  const std::size_t count = s.difference.empty() ? 3 : s.difference.size();
  if (count != 3)
    place.fail("difference", fmt::format("{} entries; three are needed, for x, y and z", s.difference.size()));
  if (s.difference.empty()) s.difference = {"0", "0", "0"};
  Functions moving;
  for (std::size_t k = 0; k < count; ++k) take_component(place, c, k, s, moving);
  if (std::none_of(moving.begin(), moving.end(), [](const auto& f) { return static_cast<bool>(f); })) return;
  s.pair.motion = [moving](double t) {
    Vec3 d = Vec3::Zero();
    for (std::size_t k = 0; k < moving.size(); ++k)
      if (moving[k]) d[static_cast<Eigen::Index>(k)] = moving[k](t);
    return d;
  };
}

using Refuse = std::function<void(const char*, const char*)>;

/// What springs are fixed to repeats itself with the sheet where edges do not move apart along them.
void refuse_spring(const Case& c, const system::Spring& spring, const Refuse& refuse) {
  using Kind = system::Spring::Kind;
  if (spring.kind == Kind::pair || spring.kind == Kind::band)
    refuse("[[spring]] type", "\"pair\" and \"band\" are not continued beyond the edges; remove one of the sections");
  for (const PeriodicSection& s : c.periodics)
    for (std::size_t k = 0; k < 3; ++k) {
      const bool apart = plain_number(s.difference[k]) != 0.0;
      if (apart && (!spring.direction || (*spring.direction)[static_cast<Eigen::Index>(k)] != 0.0))
        refuse("[[spring]] direction",
               fmt::format("its {0} is not 0, nor is the {0} of the difference of '{1}': what springs are "
                           "fixed to stays; give a direction across it, e.g. [0, 0, 1]",
                           directions[k], s.name)
                   .c_str());
    }
}

void refuse_sections(const Case& c, const Refuse& refuse) {
  constexpr const char* remove = "what it does is not continued beyond the edges; remove one of the sections";
  if (c.contact.input.active)
    refuse("[contact]", "the sheet has no contact with its images; remove one of the sections");
  if (c.remesh.active) refuse("[remesh]", "the mesh of periodic edges stays as it is; remove one of the sections");
  if (!c.panels.empty()) refuse("[[panel]]", "panels have no periodic edges; use a mesh file");
  if (!c.rigids.empty()) refuse("[[rigid]]", remove);
  for (const system::Spring& spring : c.springs) refuse_spring(c, spring, refuse);
  if (!c.hinges.empty()) refuse("[[hinge]]", remove);
  if (!c.masses.empty()) refuse("[[mass]]", remove);
  if (!c.attachments.empty()) refuse("[[attachment]]", remove);
  for (const ImperfectionSection& i : c.imperfections)
    if (i.type == ImperfectionSection::Type::random)
      refuse("[[imperfection]] type = \"random\"", "it does not repeat itself; use \"modes\" or \"expression\"");
  if (c.form.active) refuse("[form]", "forms are not found of periodic sheets; remove one of the sections");
  if (has_gas(c)) refuse("[[load]] type = \"gas\"", "a cell encloses nothing; use \"follower_pressure\"");
  if (!c.mesh.start.empty() || c.mesh.options.rest == formats::RestShape::texture)
    refuse("[mesh]", "periodic sheets begin in the shape without strain; remove mesh.start and mesh.rest");
}

/// Completes a pair.
void read_periodic(const SectionPlace& place, const Case& c, PeriodicSection& s) {
  if (s.name.empty()) s.name = s.pair.to;
  require_column_name(place, s.name);
  for (const PeriodicSection& other : c.periodics) {
    if (other.name == s.name) place.fail("name", fmt::format("'{}': another [[periodic]] has this name", s.name));
    for (const std::string& group : {other.pair.from, other.pair.to})
      for (const auto& [key, own] : {std::pair("from", s.pair.from), std::pair("to", s.pair.to)})
        if (own == group) place.fail(key, fmt::format("'{}' belongs to another pair; name each curve once", own));
  }
  if (s.pair.from == s.pair.to)
    place.fail("to", fmt::format("'{}' is `from` too; name the curve that repeats it", s.pair.to));
  constexpr auto most = mesh::ContinuedSurface::most;
  if (c.periodics.size() >= most)
    place.fail("from", fmt::format("there are {} pairs before; at most {} are possible", c.periodics.size(), most));
  take_difference(place, c, s);
}

}  // namespace

void read_periodics(const CaseReader& reader, Case& c) {
  read_all(reader, "periodic", c.periodics,
           [&](const SectionPlace& place, PeriodicSection& s) { read_periodic(place, c, s); });
}

void check_periodic(const Case& c) {
  if (c.periodics.empty()) return;
  const auto refuse = [&](const char* key, const char* why) {
    throw UserError(fmt::format("{}: [[periodic]] and {}: {}", c.file.string(), key, why));
  };
  refuse_sections(c, refuse);
  for (const PeriodicSection& s : c.periodics)
    for (const char* part : {"", "_force"})
      for (const Probe& probe : c.probes)
        if (probe.name == s.name + part)
          refuse("probe.name", ("'" + probe.name + "': both have columns of this name; rename one of them").c_str());
  const bool any_free = std::any_of(c.periodics.begin(), c.periodics.end(), [](const PeriodicSection& s) {
    return std::find(s.pair.held.begin(), s.pair.held.end(), false) != s.pair.held.end();
  });
  if (!any_free) return;  // where differences are given, no vertex has the mass of another one
  if (c.vibrates() && c.eigen.mass == system::Mass::lumped)
    refuse("eigen.mass", "a free difference needs \"consistent\"");
  if (c.analysis == Analysis::dynamic && c.dynamics.mass == system::Mass::lumped)
    refuse("time.mass", "a free difference needs \"consistent\"");
}

}  // namespace voile::input
