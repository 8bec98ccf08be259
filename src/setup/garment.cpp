#include "garment.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "base/decompositions.hpp"
#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "base/text.hpp"
#include "base/wildcard.hpp"
#include "form.hpp"
#include "group_names.hpp"
#include "imperfections.hpp"
#include "landmarks.hpp"
#include "mesh/weld.hpp"
#include "mesh_transfer.hpp"
#include "model_input.hpp"
#include "panel_measures.hpp"
#include "parting.hpp"
#include "pattern/garment.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

/// What a panel is called in messages.
std::string where_of(const input::Case& c, const input::PanelSection& s) {
  const std::size_t number = static_cast<std::size_t>(&s - c.panels.data());
  const std::string name = s.name.empty() ? fmt::format("number {}", number + 1) : fmt::format("'{}'", s.name);
  return fmt::format("{}: [[panel]] {}", c.file.string(), name);
}

/// The cylinder or cone that pieces are bent onto.
std::optional<pattern::Wrap> wrap_of(const input::Case& c, const input::PanelSection& s, Landmarks& landmarks) {
  if (!s.wrap_axis && !s.wrap_end) return std::nullopt;
  const std::string where = where_of(c, s);
  const Vec3 point = landmarks.place(s.wrap_point, where + " wrap_point");
  const Vec3 end = s.wrap_end ? landmarks.place(*s.wrap_end, where + " wrap_end") : Vec3(point + *s.wrap_axis);
  const Vec3 along = end - point;
  if (!(along.norm() > 0.0))
    throw UserError(fmt::format("{} wrap_end: it is where wrap_point is; name another point on the axis", where));
  pattern::Wrap wrap{along.normalized(), point, s.wrap_radius, s.wrap_angle};
  if (s.wrap_radii.empty()) return wrap;
  wrap.half_angle = std::atan2(s.wrap_radii[1] - s.wrap_radii[0], along.norm());
  wrap.radius = s.wrap_radii[0];
  if (wrap.radius > 0.0) return wrap;
  wrap.point = end;  // it begins at the apex
  wrap.radius = s.wrap_radii[1];
  return wrap;
}

/// Turns a panel about its origin until a direction in it is that of the axis.
void turn_along(const input::Case& c, const input::PanelSection& s, pattern::Panel& p) {
  using Along = input::PanelSection::Along;
  if (s.wrap_along == Along::as_placed || !p.wrap) return;
  const bool is_x = s.wrap_along == Along::x || s.wrap_along == Along::minus_x;
  const bool is_flipped = is_x && s.mirror;  // x as it is drawn
  const bool is_against = (s.wrap_along == Along::minus_x || s.wrap_along == Along::minus_y) != is_flipped;
  const Vec3 drawn = (is_against ? -1.0 : 1.0) * (is_x ? Vec3::UnitX() : Vec3::UnitY());
  const Vec3 placed = p.turn * p.piece.rotation * drawn;
  constexpr double opposite = 1e-6;
  if ((placed + p.wrap->axis).norm() < opposite)
    throw UserError(
        fmt::format("{} wrap_along: piece '{}' would be turned by 180 degrees, any way round; turn it "
                    "nearer to the axis with rotate, or name the opposite direction",
                    where_of(c, s), p.piece.name));
  const Mat3 turn = rotation_between(placed, p.wrap->axis) * p.turn;
  p.shift += (p.turn - turn) * p.piece.translation;
  p.turn = turn;
}

/// Where the origin of the file comes, or the anchor, before pieces are wrapped. [m]
Vec3 origin_of(const input::Case& c, const input::PanelSection& s, Landmarks& landmarks) {
  return landmarks.place(s.origin, where_of(c, s) + " origin") + s.placement.translate;
}

/// How far outside the clothes begin that a piece is worn over: contact, and what chords of cells cut off where both are bent. [m]
double layer_offset(const input::Case& c, const input::PanelSection& s, const pattern::Panel& p) {
  if (s.layer == 0) return 0.0;
  const std::string where = where_of(c, s);
  if (!c.touches_itself())
    throw UserError(
        fmt::format("{} layer: without contact of the sheet with itself nothing keeps layers apart; add "
                    "[contact], or remove the key",
                    where));
  if (p.piece.bent)
    throw UserError(
        fmt::format("{} layer: piece '{}' is bent where its file has it, and has no right side to move to; "
                    "remove the key, or lay the piece flat in the file",
                    where, p.piece.name));
  double offset = c.contact.input.options.distance + c.contact.input.thickness;
  if (p.wrap) {
    constexpr double longest_edge = 1.5;  // over the size of cells
    double size = 0.0;
    for (const input::PanelSection& one : c.panels) size = std::max(size, longest_edge * one.size);
    const Vec3 from_axis = p.turn * p.piece.translation + p.shift - p.wrap->point;
    const double radius =
        p.wrap->radius > 0.0 ? p.wrap->radius : std::abs(from_axis.dot(p.turn * p.piece.rotation.col(2)));
    offset += size * size / (8.0 * radius);
  }
  return s.layer * offset;
}

pattern::Panel panel_of(const input::Case& c, const input::PanelSection& s, const pattern::Pattern& from,
                        pattern::Piece piece, Landmarks& landmarks) {
  pattern::Panel p;
  p.file = from.file.string();
  p.size = s.size;
  p.turn = s.placement.rotation();
  p.shift = origin_of(c, s, landmarks);
  p.wrap = wrap_of(c, s, landmarks);
  if (!s.grain.empty()) piece.grain = Vec2(s.grain[0], s.grain[1]).normalized();
  if (s.mirror && piece.bent)
    throw UserError(
        fmt::format("{} mirror: piece '{}' is bent where its file has it, and its mirror image has no place; "
                    "remove the key, or lay the piece flat in the file",
                    where_of(c, s), piece.name));
  if (s.mirror) {
    const Mat2 mirror = Vec2(-1.0, 1.0).asDiagonal();
    for (pattern::Edge& e : piece.edges) e.curve = e.curve.mapped(mirror, Vec2::Zero());
    piece.grain = mirror * piece.grain;
  }
  if (!s.name.empty()) piece.name = s.name;
  p.piece = std::move(piece);
  turn_along(c, s, p);
  if (p.wrap) p.shift += s.wrap_shift * p.wrap->axis;
  return p;
}

std::vector<pattern::Panel> panels_of(const input::Case& c, const input::PanelSection& s, const pattern::Pattern& from,
                                      Landmarks& landmarks) {
  std::vector<pattern::Panel> panels;
  for (const pattern::Piece& piece : from.pieces) panels.push_back(panel_of(c, s, from, piece, landmarks));
  if (s.anchor.empty()) return panels;
  const Vec3 wrap = s.wrap_shift * (panels.front().wrap ? panels.front().wrap->axis : Vec3(Vec3::Zero()));
  const Vec3 way =
      origin_of(c, s, landmarks) + wrap - pattern::flat_place(panels, where_of(c, s) + " anchor", s.anchor);
  for (pattern::Panel& p : panels) p.shift += way;
  return panels;
}

/// What one [[panel]] section takes from its file.
struct Cut {
  const input::PanelSection* section;
  pattern::Pattern from;

  /// Name of the edge in the garment; nothing if its piece is not in this section.
  [[nodiscard]] std::optional<std::string> edge(const pattern::StitchEnd& e) const {
    const auto is_it = [&](const pattern::Piece& p) { return p.name == e.piece; };
    if (std::none_of(from.pieces.begin(), from.pieces.end(), is_it)) return std::nullopt;
    return fmt::format("{}/{}", section->name.empty() ? e.piece : section->name, e.edge);
  }
  /// Whether a piece of the garment is one of these.
  [[nodiscard]] bool holds(const std::string& name) const {
    if (!section->name.empty()) return section->name == name;
    return std::any_of(from.pieces.begin(), from.pieces.end(), [&](const pattern::Piece& p) { return p.name == name; });
  }
};

Cut read_panels(const input::PanelSection& s, bool allow_system_call) {
  Cut cut{&s, pattern::read_pattern(s.file, {s.unit, s.euler == input::PanelSection::Euler::xyz, s.pieces, s.unfold,
                                             s.texture_unit, s.parameters, allow_system_call, s.nest_size})};
  if (!s.name.empty() && cut.from.pieces.size() != 1)
    throw UserError(
        fmt::format("{}: [[panel]] name = \"{}\" is for one piece, but there are {}; name one with the key "
                    "pieces",
                    s.file.string(), s.name, cut.from.pieces.size()));
  return cut;
}

/// Edges of the garment that one side of a stitch is: of all sections of the file.
std::vector<std::string> edges_of(const std::vector<Cut>& cuts, const Cut& here, const pattern::StitchEnd& end) {
  std::vector<std::string> found;
  for (const Cut& c : cuts)
    if (c.section->stitches && c.section->file == here.section->file)
      if (const auto edge = c.edge(end)) found.push_back(*edge);
  return found;
}

/// Whether both sides of a stitch between sections are one edge each; says if not.
bool joins(const pattern::Stitch& stitch, const std::array<std::vector<std::string>, 2>& edges, const Cut& here,
           std::vector<std::string>& notes) {
  for (std::size_t i = 0; i < 2; ++i) {
    if (edges[i].size() == 1) continue;
    const pattern::StitchEnd& end = stitch.sides[i];
    notes.push_back(
        fmt::format("{}: stitch {} joins edge {} of piece '{}', which {}: it is no seam; name one by [[seam]]",
                    here.section->file.string(), stitch.number, end.edge, end.piece,
                    edges[i].empty() ? "no [[panel]] with stitches cuts" : "several [[panel]] sections cut"));
    return false;
  }
  return true;
}

/// Seams of the stitches of one section, and of those between it and others, unless an earlier one knows them.
void add_stitches(const std::vector<Cut>& cuts, const Cut& here, std::set<std::string>& known,
                  std::vector<pattern::SeamRequest>& seams, std::vector<std::string>& notes) {
  for (const pattern::Stitch& stitch : here.from.stitches) {
    pattern::SeamRequest r;
    r.where = fmt::format("{}: stitch {}", here.section->file.string(), stitch.number);
    r.sense = stitch.sense;
    const std::optional<std::string> first = here.edge(stitch.sides[0]), second = here.edge(stitch.sides[1]);
    if (first && second) {
      r.edges = {*first};
      r.to = {*second};
    } else {
      if (!known.insert(r.where).second) continue;
      const std::array edges{edges_of(cuts, here, stitch.sides[0]), edges_of(cuts, here, stitch.sides[1])};
      if (!joins(stitch, edges, here, notes)) continue;
      r.edges = edges[0];
      r.to = edges[1];
    }
    seams.push_back(std::move(r));
  }
}

/// Seams that are never sewn would only switch off contact between their sides.
void keep_sewn(const input::Case& c, mesh::MeshData& mesh) {
  std::vector<std::string> known, sewn;
  for (const mesh::Seam& seam : mesh.seams) known.push_back(seam.name);
  for (const input::Case& stage : c.stages)
    for (const std::string& name : stage.stage.sew) {
      const auto is_it = [&](const std::string& seam) { return seam == name || star_of(name, seam); };
      if (name != "all" && std::none_of(known.begin(), known.end(), is_it))
        throw UserError(fmt::format("{}: [[stage]] '{}' sew: there is no seam '{}':{}", c.file.string(),
                                    stage.stage.name, name, suggestion(name, known)));
      if (std::find(sewn.begin(), sewn.end(), name) != sewn.end())
        throw UserError(fmt::format("{}: [[stage]] '{}' sew: '{}' is sewn in a stage before; name it once",
                                    c.file.string(), stage.stage.name, name));
      if (!has_star(name)) sewn.push_back(name);
      for (const std::string& seam : known)
        if (star_of(name, seam)) sewn.push_back(seam);
    }
  if (std::find(sewn.begin(), sewn.end(), "all") != sewn.end()) return;
  const auto is_sewn = [&](const mesh::Seam& s) { return std::find(sewn.begin(), sewn.end(), s.name) != sewn.end(); };
  const auto is_left = [&](const mesh::Seam& s) { return !is_sewn(s); };
  std::erase_if(mesh.groups, [&](const mesh::Group& g) {
    return std::any_of(mesh.seams.begin(), mesh.seams.end(),
                       [&](const mesh::Seam& s) { return is_left(s) && g.name == mesh::seam_group(s.name); });
  });
  const auto left = std::erase_if(mesh.seams, is_left);
  if (left > 0)
    mesh.notes.push_back(
        fmt::format("{} of {} seams stay open: no [[stage]] has them in its key sew", left, known.size()));
}

/// What seams of three layers and more cannot have.
void check_layers(const input::Case& c, const pattern::Garment& garment) {
  const std::map<std::string, std::vector<std::string>> layered = pattern::layered_edges(garment);
  if (layered.empty()) return;
  const auto& [edge, seams] = *layered.begin();
  const auto remeshes = [](const input::Case& one) { return one.remesh.active; };
  if (remeshes(c) || std::any_of(c.stages.begin(), c.stages.end(), remeshes))
    throw UserError(
        fmt::format("{}: [remesh]: edge {} is in seams '{}' and '{}', and a new mesh would lose the line in "
                    "which three layers meet; remove the section, or one of the seams",
                    c.file.string(), edge, seams[0], seams[1]));
  const std::vector<system::SeamRule> rules = seam_rules(c);
  const auto require_one = [&](const char* key, const char* unit, const char* why, const auto& value) {
    for (const auto& [of, names] : layered)
      for (const std::string& name : names)
        if (const double own = value(name, rules), first = value(names[0], rules); own != first)
          throw UserError(
              fmt::format("{}: [[seam]] {}: edge {} is in seams '{}' and '{}', which say {:g} and {:g}{}, and {}; "
                          "give both seams the same",
                          c.file.string(), key, of, names[0], name, first, own, unit, why));
  };
  require_one("allowance", " m", "has one strip", system::allowance_of);
  require_one("bending", "", "its layers bend about one line", system::bending_of);
}

/// Marks are where the file draws them, also in a piece that is cut from its mirror image.
std::vector<pattern::MarkRequest> marks_of(const input::Case& c, const std::vector<Cut>& cuts) {
  std::vector<pattern::MarkRequest> marks;
  for (const input::MarkSection& s : c.marks) {
    pattern::MarkRequest m{s.name, fmt::format("{}: [[mark]] '{}'", c.file.string(), s.name), s.point, s.panel};
    if (s.at.size() == 2) m.at = Vec2(s.at[0], s.at[1]);
    for (const Cut& cut : cuts)
      if (cut.section->mirror && cut.holds(s.panel)) m.at[0] = -m.at[0];
    marks.push_back(std::move(m));
  }
  return marks;
}

/// On rank 0.
pattern::Garment garment_of(const input::Case& c) {
  std::vector<pattern::Panel> panels;
  std::vector<pattern::SeamRequest> requests;
  std::vector<std::string> notes;
  std::vector<Cut> cuts;
  Landmarks landmarks(c);
  for (const input::PanelSection& section : c.panels) {
    const Cut& cut = cuts.emplace_back(read_panels(section, c.mesh.options.allow_system_call));
    notes.insert(notes.end(), cut.from.notes.begin(), cut.from.notes.end());
    for (pattern::Panel& p : panels_of(c, section, cut.from, landmarks)) {
      p.outwards = layer_offset(c, section, p);
      panels.push_back(std::move(p));
    }
  }
  notes.insert(notes.end(), landmarks.notes().begin(), landmarks.notes().end());
  std::set<std::string> known;
  for (const Cut& cut : cuts)
    if (cut.section->stitches) add_stitches(cuts, cut, known, requests, notes);
  for (std::size_t k = 0; k < c.seams.size(); ++k) {
    const input::SeamSection& s = c.seams[k];
    const std::string which = s.name.empty() ? fmt::format("number {}", k + 1) : s.name;
    pattern::SeamRequest r{s.name, fmt::format("{}: [[seam]] {}", c.file.string(), which), s.edges, s.to, s.meet};
    for (pattern::SeamRequest& one : pattern::with_stars_replaced(panels, r)) requests.push_back(std::move(one));
  }
  pattern::Garment garment = pattern::make_garment(std::move(panels), requests, marks_of(c, cuts));
  garment.mesh.notes.insert(garment.mesh.notes.begin(), notes.begin(), notes.end());
  check_layers(c, garment);
  return garment;
}

/// The model would tell of the mesh only, where the mistake is in the case.
void check_attached_groups(const input::Case& stage, const mesh::SurfaceMesh& mesh) {
  std::vector<std::string> known;
  for (const mesh::Group& g : mesh.groups()) known.push_back(g.name);
  for (std::size_t i = 0; i < stage.attachments.size(); ++i)
    for (const std::string& name : stage.attachments[i].groups)
      if (!contains(known, name))
        throw UserError(fmt::format("{}: [[attachment]] number {} groups: there is no group '{}' in {}:{}",
                                    stage.file.string(), 1 + (stage.is_staged() ? stage.stage.attachments[i] : i), name,
                                    mesh.source(), suggestion(name, known)));
}

mesh::SurfaceMesh mesh_of(MPI_Comm comm, const input::Case& c) {
  if (c.panels.empty()) {
    formats::MeshOptions options = c.mesh.options;
    options.join_crossing = !c.touches_itself();  // cloth that starts through itself is no joint
    return load_mesh(comm, c.mesh.file, options);
  }
  mesh::MeshData data;
  mpi::on_root(comm, [&] {
    data = garment_of(c).mesh;
    keep_sewn(c, data);
  });
  broadcast_mesh(comm, data);
  return mesh::SurfaceMesh(std::move(data));
}

}  // namespace

mesh::SurfaceMesh case_mesh(MPI_Comm comm, const input::Case& c) {
  mesh::SurfaceMesh mesh =
      with_imperfections(comm, c, with_form(comm, c, parted(c, with_group_unions(c, mesh_of(comm, c)))));
  check_attached_groups(c, mesh);
  for (const input::Case& stage : c.stages) check_attached_groups(stage, mesh);
  return mesh;
}

std::string garment_report(MPI_Comm comm, const input::Case& c) {
  std::string text;
  if (c.panels.empty()) return text;
  mpi::on_root(comm, [&] {
    const pattern::Garment garment = garment_of(c);
    std::vector<double> densities, allowances;
    for (const PanelMeasures& p : measure_panels(mesh::SurfaceMesh(garment.mesh), c.materials, seam_rules(c))) {
      densities.push_back(p.mass / (p.area + p.allowance));
      allowances.push_back(p.allowance);
    }
    text = pattern::garment_text(garment, densities, allowances);
  });
  return text;
}

}  // namespace voile::setup
