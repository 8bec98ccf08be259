// Distributed matrices of 3 x 3 blocks for tests of solvers.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "base/petsc.hpp"
#include "base/types.hpp"

namespace voile::testing {

/// An empty matrix of 3 x 3 blocks with so many rows on each rank.
inline petsc::MatHandle empty_matrix(PetscInt rows) {
  petsc::MatHandle k;
  VOILE_PETSC(MatCreate(PETSC_COMM_WORLD, k.out()));
  VOILE_PETSC(MatSetSizes(k, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  VOILE_PETSC(MatSetBlockSize(k, 3));
  VOILE_PETSC(MatSetType(k, MATAIJ));
  constexpr PetscInt most = 36;  // entries of a row in each part, so that large ones are filled in no time
  VOILE_PETSC(MatSeqAIJSetPreallocation(k, most, nullptr));
  VOILE_PETSC(MatMPIAIJSetPreallocation(k, most, nullptr, most, nullptr));
  return k;
}

/// Values of all lengths of waves.
inline petsc::VecHandle right_side(Mat k) {
  petsc::VecHandle b;
  VOILE_PETSC(MatCreateVecs(k, b.out(), nullptr));
  const petsc::WriteArray values(b);
  PetscInt count = 0;
  VOILE_PETSC(VecGetLocalSize(b, &count));
  for (PetscInt i = 0; i < count; ++i) values[i] = std::sin(1.0 + 1.0 * i * i);
  return b;
}

/// A sheet that is stiff in its plane: springs between `along` x `across` vertices per rank, joined over the ranks, on a `ground` as soft
/// as inertia makes it.
inline petsc::MatHandle stiff_strip(int along, int across, double ground = 1e-3) {
  petsc::MatHandle k = empty_matrix(3 * along * across);
  PetscInt first = 0, end = 0, all = 0;
  VOILE_PETSC(MatGetOwnershipRange(k, &first, &end));
  VOILE_PETSC(MatGetSize(k, &all, nullptr));
  const auto add = [&](PetscInt i, PetscInt j, const Mat3& block) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> entries = block;
    VOILE_PETSC(MatSetValuesBlocked(k, 1, &i, 1, &j, entries.data(), ADD_VALUES));
  };
  for (PetscInt i = first / 3; i < end / 3; ++i) {
    add(i, i, ground * Mat3::Identity());
    for (const PetscInt j : {i + 1, i + across, i + across + 1}) {
      if (j >= all / 3 || (j != i + across && j % across == 0)) continue;
      const Vec3 way(static_cast<double>((j - i) / across), static_cast<double>((j - i) % across), 0.1);
      const Mat3 spring = way * way.transpose() + 0.01 * Mat3::Identity();
      add(i, i, spring);
      add(j, j, spring);
      add(i, j, -spring);
      add(j, i, -spring);
    }
  }
  VOILE_PETSC(MatAssemblyBegin(k, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(k, MAT_FINAL_ASSEMBLY));
  return k;
}

}  // namespace voile::testing
