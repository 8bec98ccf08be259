// Rows and columns of 3 x 3 blocks as vector registers hold them: three numbers and a fourth that counts for nothing. Private to
// src/solve.
#pragma once

#include <Eigen/Core>

namespace voile::linear {

using Lanes = Eigen::Vector4d;
/// A block by rows: column r is its row r.
using Rows = Eigen::Matrix<double, 4, 3>;

/// Three numbers and the one that follows them, which must be there.
inline Lanes lanes(const float* a) {
  const Eigen::Vector4f four = Eigen::Map<const Eigen::Vector4f>(a);
  return four.cast<double>();
}
inline Lanes lanes(const double* a) {
  return Eigen::Map<const Lanes>(a);
}

inline double total(const Lanes& a) {
  return a[0] + a[1] + a[2];
}

/// y_0 a_0 + y_1 a_1 + y_2 a_2 for three rows, or columns, a of a block in single precision.
inline Lanes combined(const Lanes& y, const float* a) {
  return y[0] * lanes(a) + y[1] * lanes(a + 3) + y[2] * lanes(a + 6);
}

}  // namespace voile::linear
