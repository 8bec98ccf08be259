#include "free_motions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "mesh_report.hpp"
#include "system/rigid_motions.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

constexpr std::size_t shown = 4;

std::string describe(const system::FreePiece& piece, Index all) {
  std::vector<std::string> axes;
  for (const Vec3& d : piece.directions) axes.push_back(place_text(d));
  std::string text = piece.triangles == all ? fmt::format("the sheet around {}", place_text(piece.centre))
                                            : fmt::format("the piece of {} triangles around {}", piece.triangles,
                                                          place_text(piece.centre));
  if (piece.motions() == 6 && piece.translations == 3) return text + ": nothing holds it (6 free rigid-body motions)";
  text += fmt::format(": {} free rigid-body motion(s)", piece.motions());
  if (piece.translations > 0) text += fmt::format(", {} translation(s)", piece.translations);
  if (piece.translations > 0 && !axes.empty()) text += " along " + join(axes, " and ");
  if (piece.rotations > 0) text += fmt::format(", {} rotation(s)", piece.rotations);
  return text;
}

std::string list(const std::vector<system::FreePiece>& pieces, Index all) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < std::min(shown, pieces.size()); ++k) texts.push_back(describe(pieces[k], all));
  if (pieces.size() > shown) texts.push_back(fmt::format("{} more pieces", pieces.size() - shown));
  return join(texts, "; ");
}

}  // namespace

namespace {

/// Springs and what else pulls vertices to where they are.
std::vector<system::Spring> all_springs(const input::Case& c) {
  std::vector<system::Spring> springs = c.springs;
  for (const system::Attachment& a : c.attachments)
    for (const std::string& group : a.groups) {
      system::Spring& s = springs.emplace_back();
      s.group = group;
      s.stiffness = a.stiffness;
    }
  return springs;
}

/// What hangs on threads swings as a pendulum: loads end that as they end a turn.
std::vector<system::Spring> as_threads(std::vector<system::Spring> springs) {
  for (system::Spring& s : springs)
    if (s.kind == system::Spring::Kind::pair) s.length = 0.0;
  return springs;
}

}  // namespace

std::vector<std::string> check_free_motions(const input::Case& c, const system::Model& model) {
  const auto pieces = [&](const std::vector<system::Spring>& springs) {
    return system::free_pieces(model.dofs().mesh(), model.discretisation().constraints(), springs);
  };
  const std::vector<system::FreePiece> free = pieces(all_springs(c));
  if (free.empty()) return {};
  Index drifting = 0;  // triangles
  for (const system::FreePiece& piece : pieces(as_threads(all_springs(c))))
    drifting += piece.translations > 0 ? piece.triangles : 0;
  const std::string what = list(free, model.dofs().mesh().triangle_count());
  const bool drifts = drifting > 0, moves = c.analysis == input::Analysis::dynamic || c.vibrates();
  // Pieces that touch only each other still drift.
  const bool contact = model.contact() && (!c.obstacles.empty() || drifting < model.dofs().mesh().triangle_count());
  const bool linear = c.analysis == input::Analysis::linear || c.analysis == input::Analysis::buckling;
  if (linear || (!moves && drifts && !contact))
    throw UserError(
        fmt::format("{}: [[support]]: {}; with analysis = \"{}\" {}: add supports that hold it{}", c.file.string(),
                    what, input::word_of(c.analysis),
                    linear ? "the equations then have no unique solution" : "nothing ends a free translation",
                    drifts && !linear ? ", or let it fall with \"dynamic\" onto something with [contact]" : ""));
  if (moves) return {what};
  std::string remark = contact ? "only contact and loads can hold that"
                               : "only loads can hold that, as the weight of a sheet that hangs does";
  if (c.analysis == input::Analysis::statics)
    remark += "; where that has no stiffness at the start, \"drape\" finds the equilibrium sooner";
  return {what + ": " + remark};
}

}  // namespace voile::setup
