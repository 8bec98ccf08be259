#include "contact_start.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/mpi.hpp"
#include "geometry/winding.hpp"
#include "setup/obstacles.hpp"
#include "system/contact.hpp"
#include "untangle/untangle.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

/// A vertex that would have to move further than so many mean edges is not in a shallow intersection.
constexpr double most_cells = 5.0;
/// Fraction of the activation distance below which two things touch rather than overlap.
constexpr double touching = 1e-6;

/// What an attempt to untangle says if it fails.
std::string attempt(const untangle::UntangleResult& r, double limit) {
  return r.farthest > limit
             ? fmt::format(
                   " Untangling ended after {} rounds with {} intersecting pairs: a vertex would move {:.3g} m, "
                   "more than five cells ({:.3g} m).",
                   r.rounds, r.left, r.farthest, limit)
             : fmt::format(" Untangling left {} intersecting pairs and a smallest gap of {:.3g} m after {} rounds.",
                           r.left, r.gap, r.rounds);
}

/// Where the picture of what intersects is, if it could be drawn.
std::string picture_text(std::filesystem::path file) {
  const std::filesystem::path picture = file.replace_extension(".png");
  return std::filesystem::exists(picture) ? fmt::format(", a picture in {}", picture.string()) : "";
}

/// Throws if the state is no start. Collective.
/// `file`: for the triangles; empty: none.
void check_start(const std::filesystem::path& file, system::Contact& contact, Vec a, const std::string& tried) {
  const std::vector<Vec3> positions = contact.scene().positions(a);
  const setup::IntersectionCheck check(contact);
  const std::vector<geometry::TrianglePair> pairs = check.find_by_ranks(positions);
  mpi::on_root(contact.scene().dofs().comm(), [&] {
    if (pairs.empty()) return;
    const std::string found = check.report(positions, pairs, file);
    throw UserError(fmt::format(
        "[contact]: the start intersects: {}.{}{} Move the parts apart, {}let them ignore each other with a "
        "[[contact_rule]]",
        found,
        file.empty() ? "" : fmt::format(" The triangles are in {} (ParaView){}.", file.string(), picture_text(file)),
        tried, tried.empty() ? "repair shallow intersections with untangle = true, or " : "or "));
  });
  const system::ContactReport report = system::report(contact.scene(), a);
  if (report.gap > 0.0) return;
  const bool touch = report.gap > -touching * contact.scene().input().options.distance;
  throw UserError(fmt::format(
      "[contact]: at the start {}.{} Move them apart, make them thinner, let untangle = true part them, or let them "
      "ignore each other with a [[contact_rule]]",
      touch ? fmt::format("{} touch exactly", report.nearest)
            : fmt::format("{} come nearer than their thicknesses and radii allow (by {:.4g} m)", report.nearest,
                          -report.gap),
      tried));
}

/// Pieces that were placed inside of a body, of which contact would never let them out. One vertex tells: nothing intersects.
std::vector<std::string> enclosed_pieces(const system::ContactScene& scene, const std::vector<Vec3>& positions,
                                         bool panels) {
  std::vector<std::string> notes;
  const mesh::SurfaceMesh& sheet = scene.dofs().mesh();
  for (std::size_t k = 0; k < scene.input().obstacles.size(); ++k) {
    const contact::Obstacle& o = scene.input().obstacles[k];
    if (o.shape != contact::Obstacle::Shape::mesh || !geometry::is_closed(o.triangles)) continue;
    const std::vector<Vec3> body = system::obstacle_points(scene, k);
    const auto encloses = [&](Index v) {
      return std::abs(geometry::winding_number(positions[static_cast<std::size_t>(v)], body, o.triangles)) > 0.5;
    };
    if (!panels && encloses(sheet.triangles().front()[0]))
      notes.push_back(fmt::format(
          "the sheet lies inside of [[obstacle]] '{}', which it cannot leave; to place it outside use mesh.translate",
          o.name));
    for (const mesh::Group& g : sheet.groups())
      if (panels && g.dimension == 2 && !g.vertices.empty() && encloses(g.vertices.front()))
        notes.push_back(
            fmt::format("panel '{}' lies inside of [[obstacle]] '{}', which it cannot leave; place it "
                        "outside by translate, origin or wrap_radius",
                        g.name, o.name));
  }
  return notes;
}

/// Says what is odd about obstacles as they were read: before the start is checked, which that may explain.
void print_obstacle_notes(const system::Contact& contact) {
  mpi::on_root(contact.scene().dofs().comm(), [&] {
    for (const std::string& note : contact.scene().input().notes) fmt::print("note: {}\n", note);
  });
}

/// Says what a user should know of a start that is none the worse for it. Collective.
void print_notes(const input::Case& c, system::Contact& contact, Vec a) {
  const system::ContactReport report = system::report(contact.scene(), a);
  const double settle_time = contact.scene().input().options.settle_time;
  const std::vector<Vec3> positions = contact.scene().positions(a);
  mpi::on_root(contact.scene().dofs().comm(), [&] {
    for (const std::string& note : enclosed_pieces(contact.scene(), positions, !c.panels.empty()))
      fmt::print("note: {}\n", note);
    if (report.pairs == 0) return;
    fmt::print(
        "note: [contact]: the start lies inside the activation distance of {:.4g} m: {} pair(s), smallest gap {:.4g} "
        "m, "
        "{}; {}\n",
        contact.scene().input().options.distance, report.pairs, report.gap, report.nearest,
        c.analysis != input::Analysis::dynamic ? "the search moves them apart"
        : settle_time > 0.0 ? fmt::format("they are let out within settle_time = {:g} s", settle_time)
                            : "settle_time = 0 lets the barrier throw them apart");
  });
}

/// Whether a start needs repair: it intersects or lies inside the activation distance. Collective.
bool is_tangled(system::Contact& contact, Vec a) {
  return !setup::IntersectionCheck(contact).find_by_ranks(contact.scene().positions(a)).empty() ||
         system::report(contact.scene(), a).pairs > 0;
}

/// Moves a if that repairs it; says what was tried if it does not. Rank 0 works for all, so that the result does not
/// depend on their number. Collective.
std::string repair(const record::RunOptions& options, system::Contact& contact, Vec a) {
  std::vector<Vec3> x = contact.scene().positions(a);
  std::string tried;
  std::vector<double> values;
  mpi::on_root(contact.scene().dofs().comm(), [&] {
    const setup::IntersectionCheck check(contact);
    const double limit = most_cells * contact::mean_edge(contact.scene().set().surface());
    const untangle::UntangleResult r = untangle::untangle(
        contact.scene().set().surface(), contact.scene().set().planes(),
        system::free_directions(contact.scene().dofs()), [&](const std::vector<Vec3>& at) { return check.find(at); },
        {.activation_distance = contact.scene().input().options.distance, .limit = limit}, x);
    if (!r.done) tried = attempt(r, limit);
    if (r.done && options.verbosity != record::Verbosity::quiet)
      fmt::print("untangled: {} vertices moved, at most {:.3g} m, in {} rounds\n", r.moved, r.farthest, r.rounds);
    for (const Vec3& p : x) values.insert(values.end(), p.begin(), p.end());
  });
  mpi::broadcast(contact.scene().dofs().comm(), tried);
  mpi::broadcast(contact.scene().dofs().comm(), values);
  if (!tried.empty()) return tried;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = Eigen::Map<const Vec3>(values.data() + 3 * i);
  system::set_positions(contact.scene().dofs(), x, a);
  return tried;
}

/// What a user should know of an intersection where obstacles may let the sheet pass.
std::string passing_text(const input::Case& c, const system::Contact& contact) {
  if (!system::has_passable_obstacles(contact.scene().input())) return "";
  return c.analysis == input::Analysis::dynamic ? " What passes through obstacles with on_pinch = \"pass\" is known to "
                                                  "checkpoint.h5 alone: restart from it."
                                                : " Obstacles with on_pinch = \"pass\" let the sheet pass in a motion "
                                                  "only: let that go on until it is free.";
}

}  // namespace

void examine_start(const input::Case& c, system::Contact& contact, Vec a) {
  contact.set_time(0.0);
  print_obstacle_notes(contact);
  if (c.contact.untangle && is_tangled(contact, a))
    mpi::on_root(contact.scene().dofs().comm(), [] {
      fmt::print(
          "note: [contact]: the start intersects or lies inside the activation distance; a run begins with "
          "untangling\n");
    });
  else
    check_start({}, contact, a, "");
  print_notes(c, contact, a);
}

void settle_start(const input::Case& c, const record::RunOptions& options, system::Contact& contact, Vec a, double time,
                  bool is_first) {
  contact.set_time(time);
  const bool says = options.verbosity != record::Verbosity::quiet && is_first;
  if (says) print_obstacle_notes(contact);
  const bool repairs = c.contact.untangle && is_first && is_tangled(contact, a);
  const std::string tried = repairs ? repair(options, contact, a) : is_first ? "" : passing_text(c, contact);
  check_start(options.output.empty() ? "" : options.output / "intersections.vtk", contact, a, tried);
  if (says) print_notes(c, contact, a);
}

}  // namespace voile::simulation
