// Rigid bodies among the unknowns: their points, forces and blocks.
#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "base/decompositions.hpp"
#include "base/mpi.hpp"
#include "dofs.hpp"
#include "mesh/patch.hpp"

namespace voile::system {

void Dofs::number_bodies(const mesh::PatchMesh& patches, const Constraints& constraints,
                         const std::vector<char>& needed) {
  first_frame_ = local_.count();
  bodies_of_mesh_ = &constraints.bodies;
  if (constraints.bodies.empty()) return;
  body_of_.assign(static_cast<std::size_t>(mesh_->vertex_count()), no_index);
  Index frame = patches.point_count();
  for (const RigidBody& body : constraints.bodies) {
    Body local;
    for (std::size_t k = 0; k < 3; ++k) local.carriers[k] = local_.local_of[body.carriers[k]];
    for (const Index v : body.members) {
      body_of_[v] = static_cast<Index>(bodies_.size());
      if (local_.local_of[v] != no_index && local_.local_of[v] < local_.vertices)
        local.points.push_back({local_.local_of[v], mesh_->positions()[v] - body.point});
    }
    for (int k = 0; k < RigidBody::frame_points; ++k, ++frame) {
      if (!needed[frame]) continue;
      local_.local_of[frame] = local_.count();
      local.points.push_back({local_.count(), body.frame_point(k) - body.point});
      local_.point_of.push_back(frame);
      local_.start.push_back(body.frame_point(k));
      frame_body_.push_back(static_cast<Index>(bodies_.size()));
    }
    bodies_.push_back(std::move(local));
    motions_.emplace_back(body);
  }
  arms_.assign(static_cast<std::size_t>(local_.count()), Vec3::Zero());
  for (const Body& body : bodies_)
    for (const BodyPoint& p : body.points) arms_[p.point] = p.arm;
}

Index Dofs::body_of_point(Index point) const {
  if (bodies_.empty()) return no_index;
  if (point >= first_frame_) return frame_body_[static_cast<std::size_t>(point - first_frame_)];
  return point < local_.vertices ? body_of_[local_.point_of[point]] : no_index;
}

std::vector<Dofs::Share> Dofs::body_fractions(std::size_t body, Index point) const {
  const RigidMotion& motion = motions_[body];
  const Vec3& arm = arms_[point];
  Mat3 second, third = Mat3::Zero();
  for (int i = 0; i < 3; ++i) second.col(i) = motion.slope(i) * arm;
  third.col(0) = motion.slope(3) * arm;
  const std::array<Index, 3>& at = bodies_[body].carriers;
  return {{at[0], Mat3::Identity()}, {at[1], second}, {at[2], third}};
}

void Dofs::set_motion(std::size_t body, const petsc::ReadArray& halo) const {
  const auto b = [&](std::size_t k) {
    return Vec3(Eigen::Map<const Vec3>(halo.data() + 3 * bodies_[body].carriers[k]));
  };
  motions_[body].set(b(0), b(1), b(2));
}

std::vector<BodyForce> Dofs::body_forces(const std::vector<Vec3>& force) const {
  std::vector<BodyForce> all(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for (const BodyPoint& p : bodies_[b].points) all[b].add(force[p.point], p.arm);
  return all;
}

void Dofs::add_body_force(std::size_t body, const BodyForce& on, const petsc::WriteArray& f) const {
  RigidMotion::Row row;
  row.head<3>() = on.force;
  for (int i = 0; i < RigidMotion::turns; ++i) row[3 + i] = motions_[body].slope(i).cwiseProduct(on.moments).sum();
  add_body_row(body, row, f);
}

void Dofs::add_body_row(std::size_t body, const RigidMotion::Row& on, const petsc::WriteArray& f) const {
  const Index first = bodies_[body].carriers[0];
  for (int k = 0; k < 3 && first < local_.owned; ++k) f[3 * first + k] += on[k];
  add_turning_force(body, on.tail<RigidMotion::turns>(), f);
}

void Dofs::add_turning_force(std::size_t body, const Eigen::Vector4d& on, const petsc::WriteArray& f) const {
  const std::array<Index, 3>& at = bodies_[body].carriers;
  for (int k = 0; k < 3 && at[1] < local_.owned; ++k) f[3 * at[1] + k] += on[k];
  if (at[2] < local_.owned) f[3 * at[2]] += on[3];
}

void Dofs::add_unknowns_block(std::size_t body, const RigidMotion::Block& k, const BlockMatrix& tangent,
                              const BlockMatrix::Values& values) const {
  const std::array<Index, 3>& at = bodies_[body].carriers;
  Eigen::Matrix<double, 9, 9> all = Eigen::Matrix<double, 9, 9>::Zero();
  all.topLeftCorner<7, 7>() = k;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (at[i] < local_.owned)
        values.add(tangent.slot(at[i], local_.row_of[at[j]]),
                   Mat3(all.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j))));
}

std::vector<RigidMotion::Row> Dofs::body_rows(Vec a) const {
  take_halo(a);
  const petsc::ReadArray values(halo_);
  std::vector<RigidMotion::Row> rows(bodies_.size());
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const std::array<Index, 3>& at = bodies_[b].carriers;
    rows[b] << Eigen::Map<const Vec3>(values.data() + 3 * at[0]), Eigen::Map<const Vec3>(values.data() + 3 * at[1]),
        values[3 * at[2]];
  }
  return rows;
}

namespace {

/// Velocities of vertices by the velocity of a body's point and its turning, and what they are.
struct RateFit {
  Eigen::MatrixXd map;
  Eigen::VectorXd values;
};

RateFit rate_fit(const mesh::SurfaceMesh& mesh, const RigidBody& body, const std::vector<Index>& vertices,
                 const std::vector<double>& velocity) {
  const auto rows = 3 * static_cast<Eigen::Index>(vertices.size());
  RateFit fit{Eigen::MatrixXd(rows, 6), Eigen::VectorXd(rows)};
  Eigen::Index row = 0;
  for (const Index v : vertices) {
    const Vec3 arm = mesh.positions()[v] - body.point;  // rates are given before anything has turned
    fit.map.block<3, 3>(row, 0).setIdentity();
    for (int k = 0; k < 3; ++k) fit.map.block<3, 1>(row, 3 + k) = Vec3::Unit(k).cross(arm);
    fit.values.segment<3>(row) = Eigen::Map<const Vec3>(velocity.data() + 3 * static_cast<std::size_t>(v));
    row += 3;
  }
  return fit;
}

/// Members and the other vertices of their triangles.
std::vector<Index> with_neighbours(const mesh::SurfaceMesh& mesh, const RigidBody& body) {
  const std::set<Index> members(body.members.begin(), body.members.end());
  std::set<Index> all = members;
  for (const mesh::Triangle& t : mesh.triangles())
    if (std::any_of(t.begin(), t.end(), [&](Index v) { return members.count(v) > 0; })) all.insert(t.begin(), t.end());
  return {all.begin(), all.end()};
}

}  // namespace

std::vector<double> Dofs::body_rates(const std::vector<double>& velocity) const {
  constexpr double same = 1e-6;  // relative, of velocities
  std::vector<double> rates;
  const auto solve = [](const RateFit& f, Eigen::Index& rank) -> Eigen::VectorXd {
    const SingularValues svd = singular_value_decomposition(f.map);
    rank = svd.rank(1e-8);
    return svd.v.leftCols(rank) * svd.values.head(rank).cwiseInverse().asDiagonal() * svd.u.leftCols(rank).transpose() *
           f.values;
  };
  for (const RigidBody& body : *bodies_of_mesh_) {
    Eigen::Index rank = 0;
    Eigen::VectorXd fit = solve(rate_fit(*mesh_, body, body.members, velocity), rank);
    if (rank < 6) {  // the spin of a straight group about its line, where what is around it turns with it
      const RateFit around = rate_fit(*mesh_, body, with_neighbours(*mesh_, body), velocity);
      const Eigen::VectorXd both = solve(around, rank);
      if ((around.map * both - around.values).norm() <= same * around.values.norm()) fit = both;
    }
    const Vec3 turning = 0.5 * body.length * (body.basis.transpose() * fit.tail<3>());
    rates.insert(rates.end(), {fit[0], fit[1], fit[2], turning[0], turning[1], turning[2], 0.0, 0.0, 0.0});
  }
  return rates;
}

std::vector<double> Dofs::gather_bodies(Vec a) const {
  constexpr std::size_t numbers = 9;
  std::vector<double> all(numbers * bodies_.size(), 0.0);
  {
    const petsc::ReadArray in(a);
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      for (std::size_t k = 0; k < 3; ++k)
        if (const Index at = bodies_[b].carriers[k]; at < local_.owned)
          std::copy_n(in.data() + 3 * at, 3, all.begin() + static_cast<std::ptrdiff_t>(numbers * b + 3 * k));
  }
  mpi::sum_to_root(comm_, all);
  return mpi::rank(comm_) == 0 ? all : std::vector<double>{};
}

void Dofs::scatter_bodies(const std::vector<double>& unknowns, Vec a) const {
  constexpr std::size_t numbers = 9;
  std::vector<double> all = unknowns;
  mpi::broadcast(comm_, all);
  const petsc::WriteArray out(a);
  for (std::size_t b = 0; numbers * (b + 1) <= all.size() && b < bodies_.size(); ++b)
    for (std::size_t k = 0; k < 3; ++k)
      if (const Index at = bodies_[b].carriers[k]; at < local_.owned)
        for (std::size_t i = 0; i < 3; ++i) out[3 * at + static_cast<Index>(i)] = all[numbers * b + 3 * k + i];
}

std::vector<double> Dofs::gather(Vec a) const {
  if (ties_->any()) return gather_change(a);
  if (bodies_.empty()) return gather_with(a, {});
  const std::vector<RigidMotion> kept = motions_;
  take_halo(a);
  {
    const petsc::ReadArray values(halo_);
    for (std::size_t b = 0; b < bodies_.size(); ++b) set_motion(b, values);
  }
  std::vector<double> all = gather_with(a, [&](Index i) {
    const auto b = static_cast<std::size_t>(body_of(local_.point_of[i]));
    return Vec3(motions_[b].displacement() + motions_[b].turned() * arms_[i]);
  });
  motions_ = kept;
  return all;
}

std::vector<double> Dofs::gather_change(Vec da) const {
  if (bodies_.empty() && !ties_->any()) return gather_with(da, {});
  take_halo(da);
  const petsc::ReadArray values(halo_);
  return gather_with(da, [&](Index i) {
    Vec3 u = Vec3::Zero();
    for (const Share& s : fractions(i)) u += s.map * Eigen::Map<const Vec3>(values.data() + 3 * s.vertex);
    return u;
  });
}

void Dofs::scatter(const std::vector<double>& values, Vec a) const {
  scatter_with(values, a, false);
}

void Dofs::scatter_forces(const std::vector<double>& values, Vec f) const {
  scatter_with(values, f, true);
}

std::vector<double> Dofs::gather_forces(Vec f) const {
  if (ties_->any()) return gather_tied_forces(f);
  return gather_with(f, [](Index) { return Vec3(Vec3::Zero()); });
}

}  // namespace voile::system
