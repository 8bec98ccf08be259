// Nodal forces of dead loads, and elements for follower loads.
#include <fmt/format.h>

#include <functional>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/system/model.hpp"

namespace voile::system {

namespace {

using AddForce = std::function<void(Index vertex, const Vec3& force)>;

std::vector<Index> loaded_triangles(const mesh::SurfaceMesh& mesh, const Load& load) {
  if (!load.group.empty()) return mesh.group(load.group, 2).triangles;
  std::vector<Index> all(static_cast<std::size_t>(mesh.triangle_count()));
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<Index>(t);
  return all;
}

/// Force per rest area on triangle t.
Vec3 traction(const energy::Sheet& sheet, const Load& load, Index t) {
  if (load.kind == Load::Kind::pressure) return load.magnitude * sheet.mesh().start_normal(t);
  if (load.kind == Load::Kind::gravity) return sheet.material(t).areal_density * load.vector;
  return load.vector;
}

void add_surface_load(const energy::Sheet& sheet, const Load& load, const AddForce& add) {
  for (Index t : loaded_triangles(sheet.mesh(), load)) {
    const Vec3 share = traction(sheet, load, t) * sheet.mesh().area(t) / 3.0;
    for (Index v : sheet.mesh().triangles()[t]) add(v, share);
  }
}

void add_line_load(const mesh::SurfaceMesh& mesh, const Load& load, const AddForce& add) {
  for (const mesh::Segment& s : mesh.group(load.group, 1).segments) {
    const double length = mesh.rest_length(s);
    for (Index v : s) add(v, 0.5 * length * load.vector);
  }
}

/// Weight without mass is a mistake that a run would answer with silence.
void check_gravity(const energy::Sheet& sheet, const Load& load) {
  for (Index t : loaded_triangles(sheet.mesh(), load))
    if (sheet.material(t).areal_density > 0.0) return;
  throw UserError("[[load]] type 'gravity': no material under it has a density; give `density` in [[material]]");
}

}  // namespace

Vec Model::force_of(const Load& load) {
  if (!load.history) return load.constant ? constant_ : dead_;
  TimedLoad timed{load.history, followers_.kernel.add_factor(), dofs_->create_vector()};
  timed_.push_back(std::move(timed));
  return timed_.back().force;
}

void Model::build_loads(const std::vector<Load>& loads, const std::vector<PointMass>& masses) {
  for (const Load& load : loads) {
    const petsc::WriteArray force(force_of(load));
    const AddForce add = [&](Index v, const Vec3& f) {
      const Index i = owned(v);
      if (i == no_index) return;
      const Vec3 g = dofs_->to_own(v, f);
      for (int k = 0; k < 3; ++k) force[3 * i + k] += g[k];
    };
    switch (load.kind) {
      case Load::Kind::point:
        for (Index v : mesh_->group(load.group).vertices) add(v, load.vector);
        break;
      case Load::Kind::line:
        add_line_load(*mesh_, load, add);
        break;
      case Load::Kind::gravity:
        if (masses.empty()) check_gravity(*sheet_, load);
        for (const PointMass& m : masses)
          if (load.group.empty() || load.group == m.group)
            for (Index v : mesh_->group(m.group).vertices) add(v, m.mass * load.vector);
        add_surface_load(*sheet_, load, add);
        break;
      case Load::Kind::pressure:
      case Load::Kind::area:
        add_surface_load(*sheet_, load, add);
        break;
      case Load::Kind::follower_pressure:
      case Load::Kind::follower_moment:
        any_follower_ = true;
        add_follower(load);
        break;
    }
  }
}

void Model::add_follower(const Load& load) {
  const int factor = load.history    ? timed_.back().factor
                     : load.constant ? energy::FollowerTerm::constant
                                     : energy::FollowerTerm::load_factor;
  const auto local = [&](const mesh::Triangle& t) {
    const std::vector<Index>& of = dofs_->local().local_of;
    return std::array<Index, 3>{of[t[0]], of[t[1]], of[t[2]]};
  };
  // As for the other elements: every triangle that touches an owned vertex.
  const auto evaluated = [&](const std::array<Index, 3>& p) {
    return std::any_of(p.begin(), p.end(), [&](Index i) { return i != no_index && i < dofs_->local().owned; });
  };
  if (load.kind == Load::Kind::follower_pressure) {
    for (Index t : loaded_triangles(*mesh_, load)) {
      const auto points = local(mesh_->triangles()[t]);
      if (evaluated(points))
        followers_.kernel.add_pressure(points, load.magnitude, factor, partition_.triangle_rank[t] == rank_);
    }
    return;
  }
  for (const mesh::Segment& s : mesh_->group(load.group, 1).segments)
    for (Index t : mesh_->triangles_of_vertex(s[0])) {
      const int side = mesh_->side_of(t, s[0], s[1]);
      if (side < 0) continue;
      if (mesh_->neighbour(t, side) != no_index)
        throw UserError(
            fmt::format("[[load]] group '{}' (follower_moment): the edge {}-{} lies inside the surface; a moment acts "
                        "on a boundary "
                        "edge",
                        load.group, mesh_->data().vertex_tags[s[0]], mesh_->data().vertex_tags[s[1]]));
      const mesh::Triangle& v = mesh_->triangles()[t];
      const auto points = local({v[(side + 1) % 3], v[(side + 2) % 3], v[side]});
      const double length = mesh_->rest_length(s);
      if (evaluated(points))
        followers_.kernel.add_moment(points, load.magnitude, length, factor, partition_.triangle_rank[t] == rank_);
    }
}

void Model::add_springs(const std::vector<Spring>& springs, const BlockMatrix::Values& values) {
  for (const Spring& s : springs) {
    const Mat3 unit =
        s.direction ? Mat3(s.direction->normalized() * s.direction->normalized().transpose()) : Mat3(Mat3::Identity());
    const auto add = [&](Index v, double stiffness) {
      const Index i = owned(v);
      if (i == no_index) return;
      const Mat3 q = dofs_->axes(v);
      springs_.push_back({i, stiffness * q.transpose() * unit * q});
      values.add(bending_.slot(i, dofs_->first_row() + i), springs_.back().stiffness);
    };
    Load like;  // the same lumping as that of loads
    like.group = s.group;
    switch (s.kind) {
      case Spring::Kind::point:
        for (Index v : mesh_->group(s.group).vertices) add(v, s.stiffness);
        break;
      case Spring::Kind::line:
        like.vector = s.stiffness * Vec3::UnitX();
        add_line_load(*mesh_, like, [&](Index v, const Vec3& share) { add(v, share.x()); });
        break;
      case Spring::Kind::area:
        like.kind = Load::Kind::area;
        like.vector = s.stiffness * Vec3::UnitX();
        add_surface_load(*sheet_, like, [&](Index v, const Vec3& share) { add(v, share.x()); });
        break;
      case Spring::Kind::pair:  // a term of its own
        break;
    }
  }
}

double Model::spring_energy(Vec a) const {
  if (!any_spring_) return 0.0;
  double sum = 0.0;
  const petsc::ReadArray u(a);
  for (const NodalSpring& s : springs_) {
    const Vec3 d = Eigen::Map<const Vec3>(u.data() + 3 * s.vertex);
    sum += 0.5 * d.dot(s.stiffness * d);
  }
  return mpi::sum(comm(), sum);
}

}  // namespace voile::system
