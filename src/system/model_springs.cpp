// Springs to the ground: part of the constant matrix.
#include <algorithm>
#include <cmath>

#include "voile/base/mpi.hpp"
#include "voile/energy/seam.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/spring.hpp"
#include "voile/mesh/weld.hpp"
#include "voile/system/model.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

namespace {

/// When no spring has a length any more, all double their stiffness in this time [s], up to this factor: fabric in
/// tension would keep soft ones open. Before, while all moves, stiff springs that saturate would only cost iterations.
constexpr double doubling_time = 0.03, most_tight = 128.0;

/// Largest distance at the start of points that are sewn together. [m]
double longest_way(const mesh::SurfaceMesh& mesh, const std::vector<std::string>& seams) {
  double longest = 0.0;
  const std::vector<std::string> sewn = mesh::open_seams(mesh.data(), seams);
  for (const mesh::Seam& seam : mesh.data().seams) {
    if (std::find(sewn.begin(), sewn.end(), seam.name) == sewn.end()) continue;
    for (const auto& [v, w] : seam.pairs)
      longest = std::max(longest, (mesh.positions()[w] - mesh.positions()[v]).norm());
  }
  return longest;
}

}  // namespace

void Model::add_springs(const std::vector<Spring>& springs, const BlockMatrix::Values& values) {
  for (const Spring& s : springs) {
    const Mat3 unit =
        s.direction ? Mat3(s.direction->normalized() * s.direction->normalized().transpose()) : Mat3(Mat3::Identity());
    const auto add = [&](Index v, double stiffness) {
      const Index i = on_->owned(v);
      if (i == no_index) return;
      const Mat3 q = dofs().axes(v);
      springs_.push_back({i, stiffness * q.transpose() * unit * q});
      values.add(constant_.bending_blocks().slot(i, dofs().first_row() + i), springs_.back().stiffness);
    };
    const auto spread_over = [&](Load::Kind kind) {  // the same lumping as that of loads
      Load like;
      like.kind = kind;
      like.group = s.group;
      like.vector = s.stiffness * Vec3::UnitX();
      spread(on_->sheet(), like, [&](Index v, const Vec3& share) { add(v, share.x()); });
    };
    if (s.kind == Spring::Kind::point) spread_over(Load::Kind::point);
    if (s.kind == Spring::Kind::line) spread_over(Load::Kind::line);
    if (s.kind == Spring::Kind::area) spread_over(Load::Kind::area);
  }
}

void Model::add_sewing(ElementTerm<energy::SeamTerm>& term) {
  sewing_term_ = &term;
  const LocalPoints& local = dofs().local();
  const mesh::SurfaceMesh& mesh = on_->mesh();
  const std::vector<std::string> sewn = mesh::open_seams(mesh.data(), sewing_.seams);
  for (const mesh::Seam& seam : mesh.data().seams) {
    if (std::find(sewn.begin(), sewn.end(), seam.name) == sewn.end()) continue;
    for (std::size_t k = 0; k < seam.pairs.size(); ++k) {
      const auto& [v, w] = seam.pairs[k];
      if (on_->owned(v) == no_index && on_->owned(w) == no_index) continue;
      const double length = (mesh.positions()[w] - mesh.positions()[v]).norm();
      sewing_springs_.push_back({length, sewing_.stiffness * seam.lengths[k]});
      term.kernel.add({local.local_of[v], local.local_of[w]}, sewing_springs_.back().stiffness,
                      sewing_.force * seam.lengths[k], length, on_->owned(v) != no_index);
    }
  }
}

/// Depends on the time alone, so that a restart needs no memory.
void Model::tighten_seams(double time) {
  if (sewing_.seams.empty()) return;
  const double since = std::max(0.0, time - sewing_.start);
  const double closed_for = std::max(0.0, since - longest_way(on_->mesh(), sewing_.seams) / sewing_.speed);
  const double tighter = std::min(most_tight, std::exp2(closed_for / doubling_time));
  for (std::size_t e = 0; e < sewing_springs_.size(); ++e) {
    const auto& [length, stiffness] = sewing_springs_[e];
    sewing_term_->kernel.set(static_cast<Index>(e), std::max(0.0, length - sewing_.speed * since), stiffness * tighter);
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
