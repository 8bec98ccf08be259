// Vertices that follow others among the unknowns: their points, forces and values.
#include <algorithm>

#include "base/mpi.hpp"
#include "dofs.hpp"

namespace voile::system {

void Dofs::number_ties() {
  if (!ties_->any()) return;
  for (const Index carrier : ties_->carriers) local_carriers_.push_back(local_.local_of[carrier]);
  tied_of_.assign(static_cast<std::size_t>(first_mirror_), no_index);
  for (Index i = 0; i < first_mirror_; ++i) {
    const Index v = local_.point_of[i];
    if (!ties_->is_tied(v)) continue;
    tied_of_[i] = static_cast<Index>(tied_.size());
    tied_.push_back({i, local_.local_of[ties_->root(v)], ties_->sheet->shift[v]});
  }
}

std::vector<Dofs::Share> Dofs::tied_fractions(Index point) const {
  if (point >= first_mirror_) {
    const Mirror& g = mirrors_[point - first_mirror_];
    const Mat3 rest = Mat3::Identity() - g.reflection;
    std::vector<Share> all;
    const auto add = [&](Index vertex, const Mat3& map) {
      for (const Share& s : tied_fractions(vertex)) all.push_back({s.vertex, map * s.map});
    };
    add(g.apex, g.reflection);
    add(g.a, (1.0 - g.foot) * rest);
    add(g.b, g.foot * rest);
    return all;
  }
  const bool tied = tied_of_[point] != no_index;
  const Index from = tied ? tied_[tied_of_[point]].root : point, v = local_.point_of[from];
  std::vector<Share> all{{from, has_axes(v) ? axes_[axes_of_[v]] : Mat3(Mat3::Identity())}};
  for (std::size_t i = 0; tied && i < local_carriers_.size(); ++i)
    if (const int n = tied_[tied_of_[point]].periods[i]; n != 0)
      all.push_back({local_carriers_[i], n * Mat3::Identity()});
  return all;
}

/// Carriers are tied vertices, too: their own share goes on before they take what acts on the differences.
void Dofs::add_tied_forces(std::vector<Vec3>& force) const {
  std::array<Vec3, mesh::ContinuedSurface::most> on_difference;
  on_difference.fill(Vec3::Zero());
  for (const Tied& t : tied_) {
    force[t.root] += force[t.point];
    for (std::size_t i = 0; i < on_difference.size(); ++i) on_difference[i] += t.periods[i] * force[t.point];
    force[t.point].setZero();
  }
  for (std::size_t i = 0; i < local_carriers_.size(); ++i)
    if (local_carriers_[i] != no_index) force[local_carriers_[i]] = on_difference[i];
}

namespace {

Eigen::Map<Vec3> at(std::vector<double>& values, Index v) {
  return Eigen::Map<Vec3>(values.data() + 3 * static_cast<std::size_t>(v));
}

/// Clears what vertices of the mesh have that follow others, and gives `of` to the carriers.
void replace(const Ties& ties, const std::vector<Vec3>& of, std::vector<double>& values) {
  for (Index v = 0; v < ties.mesh->vertex_count(); ++v)
    if (ties.is_tied(v)) at(values, v).setZero();
  for (std::size_t i = 0; i < of.size(); ++i) at(values, ties.carriers[i]) = of[i];
}

}  // namespace

void Dofs::take_differences(std::vector<double>& values) const {
  std::vector<Vec3> d;
  for (const Index v : ties_->carriers) d.emplace_back(at(values, v) - at(values, ties_->root(v)));
  replace(*ties_, d, values);
}

void Dofs::take_tied_forces(std::vector<double>& values) const {
  std::vector<Vec3> on(ties_->carriers.size(), Vec3::Zero());
  for (Index v = 0; v < mesh_->vertex_count(); ++v) {
    if (!ties_->is_tied(v)) continue;
    at(values, ties_->root(v)) += at(values, v);
    for (std::size_t i = 0; i < on.size(); ++i) on[i] += ties_->periods(v, i) * at(values, v);
  }
  replace(*ties_, on, values);
}

std::vector<double> Dofs::gather_tied_forces(Vec f) const {
  std::vector<double> all;
  {
    const petsc::ReadArray in(f);
    all = gather_with(f, [&](Index i) {
      const Index v = local_.point_of[i];
      const bool carries = std::find(ties_->carriers.begin(), ties_->carriers.end(), v) != ties_->carriers.end();
      return carries ? Vec3(Eigen::Map<const Vec3>(in.data() + 3 * i)) : Vec3(Vec3::Zero());
    });
  }
  for (std::size_t i = 0; !all.empty() && i < ties_->carriers.size(); ++i)
    at(all, ties_->root(ties_->carriers[i])) -= Vec3(at(all, ties_->carriers[i]));
  return all;
}

}  // namespace voile::system
