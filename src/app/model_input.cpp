#include "model_input.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "voile/pattern/seams.hpp"

namespace voile::app {

namespace {

/// Share by which the softest fabric may be stretched by a seam that pulls, unless the case says how much.
constexpr double sewing_strain = 0.1;

/// Ratio of lengths from which on the longer side of a seam is gathered.
double gather_from(input::SeamSection::Gather gather) {
  constexpr double round_off = 1e-9;
  if (gather == input::SeamSection::Gather::automatic) return system::SeamRule{}.gather_from;
  return gather == input::SeamSection::Gather::always ? 1.0 + round_off : std::numeric_limits<double>::infinity();
}

/// Largest tension across a seam [N/m].
double sewing_force(const input::Case& c) {
  if (c.sewing.force > 0.0) return c.sewing.force;
  double least = std::numeric_limits<double>::infinity();
  for (const energy::Material& m : c.materials) least = std::min({least, m.membrane(0, 0), m.membrane(1, 1)});
  return sewing_strain * least;
}

}  // namespace

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
  for (std::size_t i = 0; i < attachments.size(); ++i)
    attachments[i].number = static_cast<int>(c.is_staged() ? c.stage.attachments[i] : i);
  return {c.element,
          c.materials,
          c.supports,
          c.loads,
          contact_input(comm, c, known),
          c.masses,
          c.springs,
          c.analysis == "static" || (c.analysis == "drape" && !c.is_staged()),
          {c.stage.sew, c.sewing.stiffness, c.sewing.speed, sewing_force(c), 0.0},
          std::move(attachments),
          seam_rules(c)};
}

}  // namespace voile::app
