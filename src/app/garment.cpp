#include "garment.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mesh_transfer.hpp"
#include "voile/app/run.hpp"
#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/base/petsc.hpp"
#include "voile/base/text.hpp"
#include "voile/pattern/garment.hpp"

namespace voile::app {

namespace {

pattern::Panel panel_of(const input::PanelSection& s, const pattern::Pattern& from, pattern::Piece piece) {
  pattern::Panel p;
  p.file = from.file.string();
  p.size = s.size;
  p.turn = s.placement.rotation();
  p.shift = s.placement.translate;
  if (s.wrap_axis) p.wrap = pattern::Wrap{s.wrap_axis->normalized(), s.wrap_point, s.wrap_radius};
  if (s.mirror) {
    const Mat2 mirror = Vec2(-1.0, 1.0).asDiagonal();
    for (pattern::Edge& e : piece.edges) e.curve = e.curve.mapped(mirror, Vec2::Zero());
  }
  if (!s.name.empty()) piece.name = s.name;
  p.piece = std::move(piece);
  return p;
}

/// What one [[panel]] section adds.
void add_panels(const input::PanelSection& s, std::vector<pattern::Panel>& panels,
                std::vector<pattern::SeamRequest>& seams, std::vector<std::string>& notes) {
  pattern::Pattern from = pattern::read_pattern(s.file, {s.unit, s.euler == input::PanelSection::Euler::xyz, s.pieces});
  if (!s.name.empty() && from.pieces.size() != 1)
    throw UserError(
        fmt::format("{}: [[panel]] name = \"{}\" is for one piece, but there are {}; name one with the key "
                    "pieces",
                    s.file.string(), s.name, from.pieces.size()));
  notes.insert(notes.end(), from.notes.begin(), from.notes.end());
  for (const pattern::Piece& piece : from.pieces) panels.push_back(panel_of(s, from, piece));
  if (!s.stitches) return;
  for (std::size_t k = 0; k < from.stitches.size(); ++k) {
    const pattern::Stitch& stitch = from.stitches[k];
    const auto name = [&](const pattern::StitchEnd& e) {
      return fmt::format("{}/{}", s.name.empty() ? e.piece : s.name, e.edge);
    };
    pattern::SeamRequest r;
    r.where = fmt::format("{}: stitch {}", s.file.string(), k);
    r.edges = {name(stitch.sides[0])};
    r.to = {name(stitch.sides[1])};
    r.sense = stitch.sense;
    seams.push_back(std::move(r));
  }
}

/// Seams that are never sewn would only switch off contact between their sides.
void keep_sewn(const input::Case& c, mesh::MeshData& mesh) {
  std::vector<std::string> known, sewn;
  for (const mesh::Seam& seam : mesh.seams) known.push_back(seam.name);
  for (const input::Case& stage : c.stages)
    for (const std::string& name : stage.stage.sew) {
      if (name != "all" && std::find(known.begin(), known.end(), name) == known.end())
        throw UserError(fmt::format("{}: [[stage]] '{}' sew: there is no seam '{}':{}", c.file.string(),
                                    stage.stage.name, name, suggestion(name, known)));
      if (std::find(sewn.begin(), sewn.end(), name) != sewn.end())
        throw UserError(fmt::format("{}: [[stage]] '{}' sew: '{}' is sewn in a stage before; name it once",
                                    c.file.string(), stage.stage.name, name));
      sewn.push_back(name);
    }
  if (std::find(sewn.begin(), sewn.end(), "all") != sewn.end()) return;
  const auto is_sewn = [&](const mesh::Seam& s) { return std::find(sewn.begin(), sewn.end(), s.name) != sewn.end(); };
  const auto left = std::erase_if(mesh.seams, [&](const mesh::Seam& s) { return !is_sewn(s); });
  if (left > 0)
    mesh.notes.push_back(
        fmt::format("{} of {} seams stay open: no [[stage]] has them in its key sew", left, known.size()));
}

/// On rank 0.
pattern::Garment garment_of(const input::Case& c) {
  std::vector<pattern::Panel> panels;
  std::vector<pattern::SeamRequest> requests;
  std::vector<std::string> notes;
  for (const input::PanelSection& s : c.panels) add_panels(s, panels, requests, notes);
  for (const input::SeamSection& s : c.seams) {
    pattern::SeamRequest r{s.name, fmt::format("{}: [[seam]] {}", c.file.string(), s.name), s.edges, s.to, s.meet};
    requests.push_back(std::move(r));
  }
  pattern::Garment garment = pattern::make_garment(std::move(panels), requests);
  garment.mesh.notes.insert(garment.mesh.notes.begin(), notes.begin(), notes.end());
  return garment;
}

}  // namespace

mesh::SurfaceMesh case_mesh(const input::Case& c) {
  if (c.panels.empty()) return load_mesh(c.mesh.file, c.mesh.options);
  mesh::MeshData data;
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    data = garment_of(c).mesh;
    keep_sewn(c, data);
  });
  broadcast_mesh(PETSC_COMM_WORLD, data);
  return mesh::SurfaceMesh(std::move(data));
}

std::string garment_report(const input::Case& c) {
  std::string text;
  if (!c.panels.empty()) mpi::on_root(PETSC_COMM_WORLD, [&] { text = pattern::garment_text(garment_of(c)); });
  return text;
}

}  // namespace voile::app
