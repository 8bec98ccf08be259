// How much modes take part in rigid motions.
#include <cmath>

#include "eigen.hpp"

namespace voile::solve {

std::vector<Participation> participation(const std::vector<Mode>& modes, Mat mass,
                                         const system::RigidInertia& inertia) {
  std::vector<Participation> all;
  petsc::VecHandle work;
  VOILE_PETSC(VecDuplicate(inertia.force[0], work.out()));
  for (const Mode& mode : modes) {
    Participation p;
    VOILE_PETSC(MatMult(mass, mode.shape, work));
    VOILE_PETSC(VecDot(mode.shape, work, &p.mass));
    for (std::size_t k = 0; k < p.factor.size(); ++k) {
      double product = std::nan("");
      if (inertia.force[k]) VOILE_PETSC(VecDot(mode.shape, inertia.force[k], &product));
      p.factor[k] = product / p.mass;
      p.effective[k] = product * product / p.mass;
    }
    all.push_back(p);
  }
  return all;
}

}  // namespace voile::solve
