// Parts of distributed matrices of full 3 x 3 blocks as PETSc keeps them, in compressed rows of scalars; private to src/solve.
#pragma once

#include <petscmat.h>

#include "base/petsc.hpp"

namespace voile::linear {

/// Whether rows 3i .. 3i+2 are one row of full blocks: `starts` of scalar rows, ascending `columns`.
[[nodiscard]] inline bool is_block_row(const int* starts, const int* columns, int i) {
  const int begin = starts[3 * i], stride = starts[3 * i + 1] - begin;
  if (stride % 3 != 0 || starts[3 * i + 2] - begin != 2 * stride || starts[3 * i + 3] - begin != 3 * stride)
    return false;
  for (int at = begin; at < begin + stride; at += 3)
    for (int r = 0; r < 3; ++r)
      for (int e = 0; e < 3; ++e)
        if (columns[at] % 3 != 0 || columns[at + r * stride + e] != columns[at] + e) return false;
  return true;
}

/// Values of the columns that a rank has entries in and does not own.
struct GhostColumns {
  petsc::VecHandle values;  ///< sequential, in the order of the off-diagonal part's columns
  petsc::ScatterHandle to_values;

  /// Of k, mpiaij, whose off-diagonal part has these `columns` (MatMPIAIJGetSeqAIJ). Collective.
  void read(Mat k, Mat outside, const PetscInt* columns) {
    PetscInt count = 0;
    petsc::VecHandle x;
    petsc::IndexSetHandle which;
    VOILE_PETSC(MatGetLocalSize(outside, nullptr, &count));
    VOILE_PETSC(MatCreateVecs(k, x.out(), nullptr));
    VOILE_PETSC(VecCreateSeq(PETSC_COMM_SELF, count, values.out()));
    VOILE_PETSC(ISCreateGeneral(PETSC_COMM_SELF, count, columns, PETSC_COPY_VALUES, which.out()));
    VOILE_PETSC(VecScatterCreate(x, which, values, nullptr, to_values.out()));
  }
  void begin(Vec x) const { VOILE_PETSC(VecScatterBegin(to_values, x, values, INSERT_VALUES, SCATTER_FORWARD)); }
  void end(Vec x) const { VOILE_PETSC(VecScatterEnd(to_values, x, values, INSERT_VALUES, SCATTER_FORWARD)); }
  /// Adds the values to those of x where they come from.
  void add(Vec x) const {
    VOILE_PETSC(VecScatterBegin(to_values, values, x, ADD_VALUES, SCATTER_REVERSE));
    VOILE_PETSC(VecScatterEnd(to_values, values, x, ADD_VALUES, SCATTER_REVERSE));
  }
};

}  // namespace voile::linear
