#include "sewing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/mpi.hpp"
#include "base/text.hpp"
#include "base/wildcard.hpp"
#include "mesh/weld.hpp"
#include "pattern/seams.hpp"
#include "remesh/carry.hpp"
#include "seam_obstruction.hpp"
#include "setup/mesh_transfer.hpp"
#include "setup/model_input.hpp"
#include "system/attachments.hpp"
#include "system/contact.hpp"
#include "system/sewing_springs.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using Mesh = std::shared_ptr<const mesh::SurfaceMesh>;

std::vector<Vec3> places_of(const mesh::SurfaceMesh& mesh, const std::vector<double>& displacement) {
  std::vector<Vec3> x = mesh.positions();
  for (std::size_t v = 0; 3 * v < displacement.size(); ++v) x[v] += Eigen::Map<const Vec3>(&displacement[3 * v]);
  return x;
}

/// Of an edge of a triangle, relative to its length at rest, above which a garment counts as tight.
constexpr double tight = 0.05;

/// Whether all of it lies in the plane of its first triangle.
bool is_plane(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& x) {
  constexpr double round_off = 1e-9;
  const auto& [a, b, c] = mesh.triangles().front();
  const Vec3 normal = (x[b] - x[a]).cross(x[c] - x[a]).normalized();
  return std::all_of(x.begin(), x.end(), [&, from = x[a]](const Vec3& p) {
    return std::abs(normal.dot(p - from)) <= round_off * mesh.extent();
  });
}

struct Stretch {
  double largest = 0.0;
  Vec3 place = Vec3::Zero();
  bool in_plane = false;  ///< all fabric is
};

/// Of the edges of triangles.
Stretch stretch_of(const mesh::SurfaceMesh& mesh, const std::vector<double>& displacement) {
  const std::vector<Vec3> x = places_of(mesh, displacement);
  Stretch most;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const int next = (s + 1) % 3;
      const Vec3 &a = x[mesh.triangles()[t][s]], &b = x[mesh.triangles()[t][next]];
      const double stretch = (b - a).norm() / (mesh.rest_corner(t, next) - mesh.rest_corner(t, s)).norm() - 1.0;
      if (stretch <= most.largest) continue;
      most.largest = stretch;
      most.place = 0.5 * (a + b);
    }
  most.in_plane = is_plane(mesh, x);
  return most;
}

constexpr const char* plane_text =
    "all of it lies in one plane, and nothing lets it bulge; bend pieces at the start (wrap_point), or let a load "
    "across "
    "the plane act in this stage";

/// Where the fabric is stretched most, if that is much.
std::string stretch_text(const Stretch& s) {
  if (s.largest < tight) return "";
  return fmt::format("the fabric is stretched by {:.0f} % near ({:.4g}, {:.4g}, {:.4g}): {}", 100.0 * s.largest,
                     s.place[0], s.place[1], s.place[2],
                     s.in_plane ? plane_text
                                : "it may be too tight there, or held by friction where the body is too wide for it: "
                                  "[sewing] friction lets it slide");
}

/// A dart closes in its plane, too.
void warn_of_plane(const Stretch& s) {
  if (s.in_plane && s.largest >= tight) fmt::print(stderr, "voile: warning: {}\n", stretch_text(s));
}

/// The group of a support or hard attachment that holds a vertex; empty if none does.
std::string holder_of(const input::Case& c, const mesh::SurfaceMesh& mesh, Index vertex) {
  const auto holds = [&](const std::string& group) { return contains(mesh.group(group).vertices, vertex); };
  for (const system::Support& s : c.supports)
    if (holds(s.group)) return s.group;
  for (const system::Attachment& s : c.attachments)
    if (const auto at = std::find_if(s.groups.begin(), s.groups.end(), holds); s.hard && at != s.groups.end())
      return *at;
  return "";
}

/// The ratio of the lengths of a seam's sides from which on cells that are not gathered are too strained to close.
constexpr double strained = 1.6;

/// Where one side is much longer.
std::string gathers_text(const input::Case& c, const mesh::SurfaceMesh& mesh, const std::string& seam) {
  const auto [first, second] = mesh::side_lengths(mesh, seam);
  const double longer = std::max(first, second), shorter = std::min(first, second);
  if (!(shorter > 0.0) || longer < strained * shorter) return "";
  const bool gathers = std::none_of(c.seams.begin(), c.seams.end(), [&](const input::SeamSection& s) {
    const std::string name = pattern::seam_name(s.name, s.edges, s.to);
    return (name == seam || star_of(name, seam)) && s.gather == input::SeamSection::Gather::never;
  });
  return fmt::format("; one of its sides is {:.2g} times as long as the other, and {}", longer / shorter,
                     gathers ? "its folds may have got between them: let gravity act in this stage, so that the piece "
                               "hangs while it is gathered, or give it more [stage.damping] mass"
                             : "gather = \"never\" leaves all of that to the cells beside the seam; remove the key");
}

/// What may help.
std::string remedy(const input::Case& c, const mesh::SurfaceMesh& mesh, const mesh::SeamGap& widest) {
  const std::string first = holder_of(c, mesh, widest.pair[0]), second = holder_of(c, mesh, widest.pair[1]);
  if (first.empty() || second.empty())
    return "give the stage more time, or the springs more force, or see what is in the way";
  return fmt::format(
      "supports or hard attachments hold both of its sides there, by the group{} '{}'{}: let them hold from a later "
      "stage on",
      first == second ? "" : "s", first, first == second ? "" : fmt::format(" and '{}'", second));
}

/// On rank 0.
std::string too_wide(const input::Case& c, const mesh::SurfaceMesh& mesh, const std::vector<std::string>& seams,
                     const std::vector<double>& displacement) {
  const mesh::SeamGap widest =
      mesh::widest_gap(mesh.data(), mesh::open_seams(mesh.data(), seams), places_of(mesh, displacement));
  if (widest.gap <= c.sewing.gap) return "";
  const std::string tightness = stretch_text(stretch_of(mesh, displacement));
  return fmt::format(
             "seam '{}' is still open by {:.3g} m near ({:.4g}, {:.4g}, {:.4g}), more than [sewing] gap = {:g} m: {}",
             widest.seam, widest.gap, widest.place[0], widest.place[1], widest.place[2], c.sewing.gap,
             remedy(c, mesh, widest)) +
         gathers_text(c, mesh, widest.seam) + (tightness.empty() ? "" : "; " + tightness);
}

/// How hard the seams were pulled at the end, and whether more is to be had.
std::string force_text(const input::Case& c, const system::Model& model, double time) {
  const system::SewingSprings* springs = model.potential().sewing();
  if (springs == nullptr) return "";
  if (springs->zipped_at() > time)
    return fmt::format("; a zipper is closed at t = {:.3g} s: give the stage more time, or the seam more zip_speed",
                       springs->zipped_at());
  const double force = springs->largest_force(time);
  return fmt::format("; seams were pulled with up to {:.3g} N/m, which stretches the softest material by {:.2g} %: {}",
                     force, 100.0 * force / setup::softest_membrane(c),
                     springs->rises(time) ? "the force was rising yet; give the stage more time"
                                          : "[sewing] strain lets it rise further");
}

/// Per vertex, on rank 0. Collective.
std::vector<double> masses(const Stage& stage, const mesh::SurfaceMesh& mesh) {
  system::ModelInput input;
  input.element = stage.input.element;
  input.materials = stage.input.materials;
  input.masses = stage.input.masses;
  input.seams = stage.input.seams;
  const system::Model model(stage.options.comm, mesh, std::move(input));
  std::vector<double> all = model.dofs().gather(model.potential().constant().mass()), mass;
  for (std::size_t i = 0; i < all.size(); i += 3) mass.push_back(all[i]);
  if (std::all_of(mass.begin(), mass.end(), [](double m) { return m == 0.0; })) mass.assign(mass.size(), 1.0);
  return mass;
}

/// What contact remembers: the nearer gap, both forces, every obstacle that is ignored.
void merge_contact(const std::vector<Index>& target, std::size_t count, results::Checkpoint& c) {
  const auto merge = [&](std::vector<double>& values, double none, const auto& join) {
    if (values.empty()) return;
    std::vector<double> merged(count, none);
    for (std::size_t v = 0; v < target.size(); ++v) merged[target[v]] = join(merged[target[v]], values[v]);
    values = std::move(merged);
  };
  merge(c.contact_gaps, std::numeric_limits<double>::infinity(), [](double a, double b) { return std::min(a, b); });
  if (!c.contact_push.empty()) {
    std::vector<double> merged(3 * count, 0.0);
    for (std::size_t v = 0; v < target.size(); ++v)
      for (std::size_t k = 0; k < 3; ++k)
        merged[3 * static_cast<std::size_t>(target[v]) + k] += c.contact_push[3 * v + k];
    c.contact_push = std::move(merged);
  }
  merge(c.passing, 0.0, [](double a, double b) {
    return static_cast<double>(static_cast<std::uint64_t>(a) | static_cast<std::uint64_t>(b));
  });
}

/// Of vertices that have become one the first stays held.
void merge_anchors(const std::vector<Index>& target, results::Checkpoint& c) {
  std::vector<system::Anchor> merged;
  for (system::Anchor a : system::anchors_of(c.anchors)) {
    a.vertex = target[a.vertex];
    if (std::none_of(merged.begin(), merged.end(),
                     [&](const system::Anchor& b) { return b.attachment == a.attachment && b.vertex == a.vertex; }))
      merged.push_back(a);
  }
  c.anchors = system::numbers_of(merged);
}

/// Closes seams and counts displacements from where the state is. Collective.
void weld_state(const Stage& stage, const std::vector<std::string>& seams, Mesh& mesh, results::Checkpoint& state) {
  const MPI_Comm comm = stage.options.comm;
  const std::vector<double> mass = masses(stage, *mesh);
  mesh::MeshData data;
  std::vector<Index> target;
  mpi::on_root(comm, [&] {
    mesh::Welded w = mesh::weld(mesh->data(), seams, places_of(*mesh, state.displacement), mass);
    data = std::move(w.data);
    target = std::move(w.target);
    for (std::vector<double>* values : {&state.velocity, &state.acceleration})
      *values = mesh::merged_means(target, mass, *values, 3);
    state.displacement.assign(3 * data.positions.size(), 0.0);
    state.previous.clear();
    state.previous_velocity.clear();
  });
  state.step_start.clear();
  results::forget_stability(state);
  setup::broadcast_mesh(comm, data);
  mpi::broadcast(comm, target);
  merge_contact(target, data.positions.size(), state);
  merge_anchors(target, state);
  mesh = std::make_shared<const mesh::SurfaceMesh>(std::move(data));
  state.couplings.clear();                           // of vertices before the weld; an unbroken run begins without any
  state.remeshings = std::max(state.remeshings, 1);  // so that checkpoints hold the mesh
  state.in_equilibrium = false;
}

}  // namespace

std::string open_seam_text(const input::Case& c, const system::Model& model, const system::State& state) {
  std::string text;
  if (c.stage.sew.empty()) return text;
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const std::vector<double> displacement = remesh::gather(state, model).displacement;
  const system::Contact* contact = model.contact();
  const std::vector<Vec3> positions = contact != nullptr ? contact->scene().positions(state.u) : std::vector<Vec3>{};
  mpi::on_root(model.dofs().comm(), [&] {
    text = too_wide(c, mesh, c.stage.sew, displacement);
    if (text.empty()) return warn_of_plane(stretch_of(mesh, displacement));
    text += force_text(c, model, state.time);
    if (contact == nullptr) return;
    text += obstruction_text(contact->scene(), positions, mesh::open_seams(mesh.data(), c.stage.sew), c.sewing.gap);
  });
  mpi::broadcast(model.dofs().comm(), text);
  return text;
}

std::vector<Mesh> stage_meshes(const std::vector<Stage>& stages, const Mesh& first) {
  std::vector<Mesh> meshes;
  Mesh mesh = first;
  const auto close = [&](const std::vector<std::string>& names) {
    const std::vector<std::string> open = mesh::open_seams(mesh->data(), names);
    if (open.empty()) return;
    // Where pieces lie now, means of two sides may all be one point, as those of the halves of an edge that is folded.
    const std::vector<Index> first_of = mesh::joined_vertices(mesh->data(), open);
    std::vector<double> mass(first_of.size());
    for (std::size_t v = 0; v < mass.size(); ++v) mass[v] = first_of[v] == static_cast<Index>(v) ? 1.0 : 0.0;
    mesh = std::make_shared<const mesh::SurfaceMesh>(mesh::weld(mesh->data(), open, mesh->positions(), mass).data);
  };
  for (const Stage& stage : stages) {
    close(stage.sewn_before);
    meshes.push_back(mesh);
  }
  return meshes;
}

std::vector<std::string> weld_before(const Stage& stage, Origin origin, Mesh& mesh, results::Checkpoint& state) {
  std::vector<std::string> open = mesh::open_seams(mesh->data(), stage.sewn_before);
  std::string wrong;
  double moved = 0.0;
  mpi::on_root(stage.options.comm, [&] {
    wrong = too_wide(stage.c, *mesh, open, state.displacement);
    for (const double u : state.displacement) moved = std::max(moved, std::abs(u));
  });
  mpi::broadcast(stage.options.comm, wrong);
  if (!wrong.empty())
    throw UserError(fmt::format("{}: stage '{}' begins with welded seams, but {}", stage.c.file.string(),
                                stage.c.stage.name, wrong));
  const bool begins_to_sew =
      !stage.c.stage.sew.empty() && origin == Origin::stage && mpi::max(stage.options.comm, moved) > 0.0;
  if (!open.empty() || begins_to_sew) weld_state(stage, open, mesh, state);
  return open;
}

}  // namespace voile::simulation
