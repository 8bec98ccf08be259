#include "model_input.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "energy/natural_state.hpp"
#include "pattern/seams.hpp"

namespace voile::setup {

namespace {

/// Strain of the softest fabric at the force that seams begin to pull with, and at that to which it rises, unless the case says.
constexpr double first_strain = 0.1, most_strain = 0.3;

/// Ratio of lengths from which on the longer side of a seam is gathered.
double gather_from(input::SeamSection::Gather gather) {
  constexpr double round_off = 1e-9;
  if (gather == input::SeamSection::Gather::automatic) return system::SeamRule{}.gather_from;
  return gather == input::SeamSection::Gather::always ? 1.0 + round_off : std::numeric_limits<double>::infinity();
}

system::Sewing sewing_of(const input::Case& c) {
  const double least = softest_membrane(c);
  const bool given = c.sewing.force > 0.0, rises = !std::isnan(c.sewing.strain);
  const double force = given ? c.sewing.force : first_strain * least;
  const double most = rises ? c.sewing.strain * least : given ? force : most_strain * least;
  system::Sewing sewing{c.stage.sew, c.sewing.stiffness, c.sewing.speed, std::min(force, most), 0.0, most};
  for (const input::SeamSection& s : c.seams)
    if (s.zip_speed > 0.0) sewing.zips.push_back({pattern::seam_name(s.name, s.edges, s.to), s.zip_speed});
  return sewing;
}

std::vector<system::RigidGroup> rigid_groups(const input::Case& c) {
  std::vector<system::RigidGroup> groups;
  for (const input::RigidSection& s : c.rigids) groups.push_back(s.group);
  return groups;
}

std::vector<system::PeriodicPair> periodic_pairs(const input::Case& c) {
  std::vector<system::PeriodicPair> pairs;
  for (const input::PeriodicSection& s : c.periodics) pairs.push_back(s.pair);
  return pairs;
}

}  // namespace

double softest_membrane(const input::Case& c) {
  double least = std::numeric_limits<double>::infinity();
  for (const energy::Material& m : c.materials) least = std::min({least, m.membrane(0, 0), m.membrane(1, 1)});
  return least;
}

std::vector<system::SeamRule> seam_rules(const input::Case& c) {
  if (c.panels.empty()) return {};
  std::vector<system::SeamRule> rules{{"", c.sewing.bending, c.sewing.allowance}};
  for (const input::SeamSection& s : c.seams)
    rules.push_back({pattern::seam_name(s.name, s.edges, s.to), std::isnan(s.bending) ? c.sewing.bending : s.bending,
                     std::isnan(s.allowance) ? c.sewing.allowance : s.allowance, gather_from(s.gather)});
  return rules;
}

system::ModelInput model_input(MPI_Comm comm, const input::Case& c, KnownObstacles& known) {
  std::vector<system::Attachment> attachments = c.attachments;
  const input::UnitSystem units(c.units);
  for (std::size_t i = 0; i < attachments.size(); ++i) {
    attachments[i].number = static_cast<int>(c.is_staged() ? c.stage.attachments[i] : i);
    const std::array<const char*, 3> per{"N/m", "N/m^2", "N/m^3"};
    for (std::size_t k = 0; k < per.size(); ++k)
      attachments[i].usual[k] = units.own_default(attachments[i].usual[k], per[k]);
  }
  std::vector<energy::Material> materials;
  for (const energy::Material& m : c.materials) materials.push_back(energy::in_natural_frame(m));
  return {c.element,
          std::move(materials),
          c.supports,
          c.loads,
          contact_input(comm, c, known),
          c.masses,
          c.springs,
          c.analysis == input::Analysis::statics || (c.analysis == input::Analysis::drape && !c.is_staged()),
          sewing_of(c),
          std::move(attachments),
          seam_rules(c),
          {c.temperatures, c.hinges, c.analysis != input::Analysis::dynamic,
           c.analysis == input::Analysis::linear && c.stage.number == 0},
          rigid_groups(c),
          periodic_pairs(c)};
}

}  // namespace voile::setup
