#include "voile/system/contact.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/contact/neighbours.hpp"
#include "voile/mesh/weld.hpp"

namespace voile::system {

namespace {

using contact::ContactSet;
using contact::Pair;
using contact::Plane;

/// Pairs within so many contact distances get their place in the matrix, so that it changes rarely.
constexpr double padding = 4.0;
/// Of the triangles that may be too low for the contact distance: a few slivers are exempt, a whole mesh is not.
constexpr double most_narrow = 0.5;

/// Parts of the sheet that rules name, then the obstacles.
struct Bodies {
  std::vector<contact::Body> list;
  std::size_t sheets = 0;
  std::vector<int> of_triangle, of_vertex;
};

Bodies make_bodies(const mesh::SurfaceMesh& mesh, const ContactInput& input) {
  Bodies b{{{"sheet", input.thickness}},
           0,
           std::vector<int>(static_cast<std::size_t>(mesh.triangle_count()), 0),
           std::vector<int>(static_cast<std::size_t>(mesh.vertex_count()), -1)};
  const auto named = [](const std::string& name) { return [&name](const auto& x) { return x.name == name; }; };
  for (const ContactRule& r : input.rules)
    for (const std::string* name : {&r.first, &r.second}) {
      if (std::any_of(input.obstacles.begin(), input.obstacles.end(), named(*name)) ||
          std::any_of(b.list.begin(), b.list.end(), named(*name)))
        continue;
      if (!mesh.has_group(*name))
        throw UserError(
            fmt::format("[[contact_rule]]: there is no obstacle, physical surface or curve '{}'; correct the name, or "
                        "name the group in the mesh",
                        *name));
      const mesh::Group& group = mesh.group(*name);
      if (group.dimension == 0)
        throw UserError(fmt::format("[[contact_rule]]: '{}' is a physical point; name a surface or a curve", *name));
      for (Index t : group.triangles) b.of_triangle[t] = static_cast<int>(b.list.size());
      if (group.dimension == 1)
        for (Index v : group.vertices) b.of_vertex[v] = static_cast<int>(b.list.size());
      b.list.push_back({*name, input.thickness});
    }
  b.sheets = b.list.size();
  for (const contact::Obstacle& o : input.obstacles) b.list.push_back({o.name, o.thickness + 2.0 * o.radius});
  return b;
}

void set_general_rules(const ContactInput& input, std::size_t sheets, contact::Surface& s) {
  for (std::size_t i = 0; i < s.bodies.size(); ++i)
    for (std::size_t j = 0; j < s.bodies.size(); ++j)
      s.rules[i][j] = i < sheets && j < sheets
                          ? contact::Rule{input.self, input.friction}
                          : contact::Rule{i < sheets || j < sheets, input.obstacles[std::max(i, j) - sheets].friction};
}

}  // namespace

Contact::Contact(const Dofs& dofs, ContactInput input)
    : dofs_(&dofs),
      comm_(dofs.comm()),
      mesh_(&dofs.mesh()),
      partition_(&dofs.partition()),
      input_(std::move(input)),
      first_row_(dofs.first_row()),
      row_count_(dofs.local().owned) {
  const mesh::SurfaceMesh& mesh = *mesh_;
  Bodies bodies = make_bodies(mesh, input_);
  const std::size_t sheets = bodies.sheets;
  contact::Surface surface = contact::make_surface(mesh, std::move(bodies.list), bodies.of_triangle, bodies.of_vertex);
  obstacles_.emplace(input_.obstacles, static_cast<int>(sheets), surface);
  set_general_rules(input_, sheets, surface);
  surface.joined = mesh::joined_vertices(mesh.data());
  if (lacks_room(mesh)) surface.neighbours = contact::find_neighbours(surface, input_.options.distance);
  set_ = std::make_unique<ContactSet>(std::move(surface), obstacles_->planes(), input_.options, [&] {
    std::vector<char> owned(static_cast<std::size_t>(mesh.vertex_count()));
    for (Index i = 0; i < row_count_; ++i) owned[partition_->vertex_of[first_row_ + i]] = 1;
    return owned;
  }());
  for (const ContactRule& r : input_.rules) {
    const int i = body(r.first), j = body(r.second);
    for (contact::Rule* rule : {&set_->rule(i, j), &set_->rule(j, i)}) {
      if (r.ignore) rule->touch = false;
      if (r.friction) rule->friction = *r.friction;
    }
  }

  change_ = dofs_->create_vector();
  VOILE_PETSC(VecScatterCreateToAll(change_, to_all_.out(), all_.out()));
  for (std::vector<Vec3>* v : {&x_, &other_, &start_}) *v = set_->surface().rest;
  if (mpi::size(comm_) > 1)
    halo_ = std::make_unique<ContactHalo>(comm_, mesh, *partition_, std::vector{&x_, &other_, &start_});
  force_.resize(static_cast<std::size_t>(mesh.vertex_count()));
  set_time(0.0);
  start_time_ = 0.0;
}

bool Contact::lacks_room(const mesh::SurfaceMesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  Index narrow = 0, count = 0;
  const double reach = input_.options.distance + input_.thickness;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    double longest = 0.0;
    for (int s = 0; s < 3; ++s)
      longest = std::max(longest, (mesh.rest_corner(t, s) - mesh.rest_corner(t, (s + 1) % 3)).norm());
    const double height = 2.0 * mesh.area(t) / longest;
    count += reach < contact::room_between_neighbours * height ? 0 : 1;
    if (height < least) {
      least = height;
      narrow = t;
    }
  }
  if (!input_.self || count == 0) return false;
  const long tag = mesh.data().triangle_tags.empty() ? narrow : static_cast<long>(mesh.data().triangle_tags[narrow]);
  if (static_cast<double>(count) > most_narrow * mesh.triangle_count())
    throw UserError(fmt::format(
        "[contact]: distance + thickness = {:.4g} m is too much for this mesh: {} of {} triangles are less high than "
        "{:.4g} m, triangle {} only {:.4g} m, and neighbours would push each other; make the sum smaller (less than "
        "{:.4g} m keeps it whole everywhere), or the mesh coarser",
        reach, count, mesh.triangle_count(), reach / contact::room_between_neighbours, tag, least,
        contact::room_between_neighbours * least));
  const Vec3 place = (mesh.start_corner(narrow, 0) + mesh.start_corner(narrow, 1) + mesh.start_corner(narrow, 2)) / 3.0;
  input_.notes.push_back(fmt::format(
      "[contact]: {} of {} triangles are less high than distance + thickness = {:.4g} m asks for ({:.4g} m), the "
      "lowest "
      "is triangle {} near ({:.4g}, {:.4g}, {:.4g}) with {:.4g} m: neighbours there feel each other from {} of their "
      "distance at rest only",
      count, mesh.triangle_count(), reach, reach / contact::room_between_neighbours, tag, place[0], place[1], place[2],
      least, contact::room_between_neighbours));
  return true;
}

int Contact::body(const std::string& name) const {
  const auto& bodies = set_->surface().bodies;
  const auto at = std::find_if(bodies.begin(), bodies.end(), [&](const contact::Body& b) { return b.name == name; });
  if (at == bodies.end()) throw InternalError("a contact rule names no body");
  return static_cast<int>(at - bodies.begin());
}

// ---- positions -----------------------------------------------------------------------------------------------------

void Contact::locate(Vec a, std::vector<Vec3>& x) const {
  {
    const petsc::ReadArray values(a);
    for (Index i = 0; i < row_count_; ++i) {
      const Index v = partition_->vertex_of[first_row_ + i];
      x[v] = mesh_->positions()[v] + dofs_->to_global(v, Eigen::Map<const Vec3>(values.data() + 3 * i));
    }
  }
  if (halo_) halo_->update(x);
}

bool Contact::cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  const petsc::EventScope scope(petsc::events().contact_find);
  return set_->cover(from, to, halo_.get());
}

void Contact::take_positions(Vec a) {
  locate(a, x_);
  cover(x_, x_);
}

void Contact::set_time(double time) {
  time_ = time;
  settle();
  obstacles_->place(held_.value_or(time), x_, set_->planes());
  set_->carry([&](int b, const Vec3& place) { return displacement(b, place); });
}

void Contact::hold_obstacles(bool still) {
  if (held_) start_time_ = *held_;  // no way has been gone since
  held_ = still ? std::optional(time_) : std::nullopt;
}

std::vector<Vec3> Contact::positions(Vec a) const {
  std::vector<Vec3> x = x_;
  VOILE_PETSC(VecScatterBegin(to_all_, a, all_, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecScatterEnd(to_all_, a, all_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray values(all_);
  for (Index v = 0; v < mesh_->vertex_count(); ++v) {
    const Vec3 u = Eigen::Map<const Vec3>(values.data() + 3 * partition_->row_of[v]);
    x[v] = mesh_->positions()[v] + dofs_->to_global(v, u);
  }
  return x;
}

std::vector<Vec3> Contact::obstacle_points(std::size_t k) const {
  return obstacles_->points(k, x_);
}

// ---- terms ---------------------------------------------------------------------------------------------------------

void Contact::start_step(Vec a, double slip) {
  take_positions(a);
  end_yielding();
  start_time_ = time_;
  start_ = x_;
  slip_ = slip;
  set_->lag_friction(x_, start_, slip);
}

void Contact::lag_friction(Vec a) {
  take_positions(a);
  set_->lag_friction(x_, start_, slip_);
  set_->carry([&](int b, const Vec3& place) { return displacement(b, place); });
}

double Contact::energy(Vec a) {
  const petsc::EventScope scope(petsc::events().contact_term);
  take_positions(a);
  return mpi::sum(comm_, set_->energy(x_));
}

void Contact::add_gradient(Vec a, Vec f, ContactSet::Part part) {
  const petsc::EventScope scope(petsc::events().contact_term);
  take_positions(a);
  for (Index p : set_->candidates().seen()) {
    if (!set_->surface().is_sheet(p)) break;  // those of obstacles follow
    force_[p].setZero();
  }
  set_->add_gradient(x_, force_, part);
  const petsc::WriteArray out(f);
  for (Index i = 0; i < row_count_; ++i) {
    const Index v = partition_->vertex_of[first_row_ + i];
    const Vec3 own = dofs_->to_own(v, force_[v]);
    for (int k = 0; k < 3; ++k) out[3 * i + k] += own[k];
  }
}

bool Contact::extend_pattern(Vec a, const BlockMatrix& matrix, const BlockPattern& base, BlockPattern& pattern) {
  take_positions(a);
  const contact::Surface& s = set_->surface();
  const auto for_entries = [&](const Pair& pair, const auto& f) {
    for (Index p : pair.points) {
      if (p == no_index || !s.is_sheet(p) || partition_->row_of[p] < first_row_ ||
          partition_->row_of[p] >= first_row_ + row_count_)
        continue;
      for (Index q : pair.points)
        if (q != no_index && s.is_sheet(q)) f(partition_->row_of[p] - first_row_, partition_->row_of[q]);
    }
  };
  bool lacking = false;
  const auto check = [&](const Pair& pair) {
    for_entries(pair, [&](Index row, Index column) { lacking = lacking || !matrix.has(row, column); });
  };
  set_->for_near(x_, input_.options.distance, check);
  set_->for_sliding([&](const std::array<Index, 4>& points) {
    Pair pair{};
    pair.points = points;
    check(pair);
  });
  if (mpi::max(comm_, lacking ? 1.0 : 0.0) == 0.0) return false;
  pattern = base;
  const auto add = [&](const Pair& pair) {
    for_entries(pair, [&](Index row, Index column) { pattern[row].push_back(column); });
  };
  set_->for_near(x_, padding * input_.options.distance, add);
  set_->for_sliding([&](const std::array<Index, 4>& points) {
    Pair pair{};
    pair.points = points;
    add(pair);
  });
  for (auto& row : pattern) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return true;
}

void Contact::add_blocks(const BlockMatrix& matrix, const BlockMatrix::Values& values, bool positive) {
  const petsc::EventScope scope(petsc::events().contact_term);
  if (positive) set_->follow_slips(x_);
  set_->hessian(x_, positive, [&](Index p, Index q, const Mat3& k) {
    const Index row = partition_->row_of[p] - first_row_;
    if (row < 0 || row >= row_count_) return;
    const bool plain = !dofs_->has_axes(p) && !dofs_->has_axes(q);
    values.add(matrix.slot(row, partition_->row_of[q]),
               plain ? k : Mat3(dofs_->axes(p).transpose() * k * dofs_->axes(q)));
  });
}

// ---- ways ----------------------------------------------------------------------------------------------------------

ContactReport Contact::report(Vec a) {
  take_positions(a);
  const contact::ContactState own = set_->state(x_);
  ContactReport r;
  r.pairs = mpi::sum(comm_, own.pairs);
  r.gap = -mpi::max(comm_, -own.gap);
  r.nearest = lowest_rank_text(own.pairs > 0 && own.gap == r.gap ? words(own.nearest) : "");
  return r;
}

std::vector<double> Contact::gaps(Vec a, double limit) {
  std::vector<double> gaps = set_->gaps_within(positions(a), limit);
  mpi::min(comm_, gaps);
  return gaps;
}

}  // namespace voile::system
