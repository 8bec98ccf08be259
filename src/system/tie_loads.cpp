// What acts on vertices that repeat others, and on the differences of a periodic sheet.
#include <utility>

#include "boundary_conditions.hpp"

namespace voile::system {

std::vector<Support> with_differences(std::vector<Support> supports, const std::vector<PeriodicPair>& periodic) {
  for (const PeriodicPair& p : periodic) {
    Support s;
    if (p.motion) s.motion = [motion = p.motion](const Vec3&, double time) { return motion(time); };
    supports.push_back(std::move(s));
  }
  return supports;
}

/// On a vertex that repeats another one it acts on that one and on the differences.
void BoundaryConditions::add_vertex_force(Index v, const Vec3& f, const petsc::WriteArray& force) const {
  const Ties& ties = on_->constraints().ties;
  const Index of = ties.any() ? ties.root(v) : v;
  const auto add = [&](Index at, const Vec3& g) {
    const Index i = on_->owned(at);
    for (int k = 0; i != no_index && k < 3; ++k) force[3 * i + k] += g[k];
  };
  add(of, on_->dofs().to_own(of, f));
  for (std::size_t p = 0; p < ties.carriers.size(); ++p)
    if (const int n = ties.periods(v, p); n != 0) add(ties.carriers[p], n * f);
}

void BoundaryConditions::add_differences(const std::vector<PeriodicPair>& periodic) {
  const petsc::WriteArray dead(dead_), constant(constant_);
  for (std::size_t p = 0; p < periodic.size(); ++p)
    if (const Index i = on_->owned(on_->constraints().ties.carriers[p]); i != no_index)
      for (int k = 0; k < 3; ++k) (periodic[p].constant ? constant : dead)[3 * i + k] += periodic[p].force[k];
}

}  // namespace voile::system
