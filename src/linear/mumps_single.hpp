// Symmetric factor in single precision, by MUMPS; private to src/solve.
//
// Half the time and memory of a double factor. Its solutions have about seven digits less the condition number's:
// something to refine (mixed_pc.hpp). Ordering: nested dissection of METIS on the graph of the blocks. Factors of many rows
// are compressed: blocks of low rank to 1e-7 of the scaled matrix, which single precision does not tell from the whole ones.
// Source: A. Buttari et al., ACM Trans. Math. Softw. 34 (2008), article 17.
#pragma once

#include <petscmat.h>

#include <memory>

namespace voile::linear {

class SingleFactor {
 public:
  /// Collective.
  explicit SingleFactor(MPI_Comm comm);
  ~SingleFactor();
  SingleFactor(const SingleFactor&) = delete;
  SingleFactor& operator=(const SingleFactor&) = delete;

  /// Factors an AIJ matrix, of which it reads the lower triangle, with its diagonal times 1 + shift; `new_pattern`: not that of
  /// the last one. False if MUMPS gives up, also with more workspace. Collective.
  [[nodiscard]] bool factor(Mat k, bool new_pattern, double shift = 0.0);
  /// Whether the last pattern had so many rows that blocks of low rank are compressed.
  [[nodiscard]] bool compressed() const;
  /// From the next pattern on: the factor is kept in files, which MUMPS puts where MUMPS_OOC_TMPDIR says.
  void keep_on_disk(bool on_disk);
  /// Gives back the copy of the matrix: the next one is of a new pattern.
  void forget_matrix();
  /// x = K^-1 b to single precision. Collective.
  void solve(Vec b, Vec x);
  /// Negative eigenvalues of the last matrix, shifted as it was (Sylvester's law of inertia).
  [[nodiscard]] long negative_pivots() const;
  /// Of the last factorisation or solution, in the numbers of MUMPS's manual; >= 0: none.
  [[nodiscard]] int error() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::linear
