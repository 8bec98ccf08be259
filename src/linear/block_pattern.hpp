// Which 3 x 3 blocks a matrix has, put together from the compressed rows of several, and where their values are; private to src/solve.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "block_rows.hpp"

namespace voile::linear {

struct BlockPattern {
  /// Entries of each of the matrices that it has been put together from.
  using Values = std::array<const double*, 3>;
  /// The first entry of a block: there, and how many entries are from it to the next row's.
  struct Place {
    int source, first, stride;
  };
  std::vector<int> starts{0}, columns;  ///< of blocks, in compressed rows, columns ascending
  std::vector<Place> places;
  bool full = true;  ///< whether there were only full blocks

  [[nodiscard]] int rows() const { return static_cast<int>(starts.size()) - 1; }

  void reserve(int rows, int blocks) {
    starts.reserve(static_cast<std::size_t>(rows) + 1);
    columns.reserve(static_cast<std::size_t>(blocks));
    places.reserve(static_cast<std::size_t>(blocks));
  }
  /// Adds block row `row` of a matrix in compressed rows of scalars to the row at work, and `shift` to its block columns.
  void add(int source, const int* row_starts, const int* scalar_columns, int row, int shift = 0) {
    full = full && is_block_row(row_starts, scalar_columns, row);
    if (!full) return;
    const int begin = row_starts[3 * row], stride = row_starts[3 * row + 1] - begin;
    for (int at = begin; at < begin + stride; at += 3) {
      columns.push_back(scalar_columns[at] / 3 + shift);
      places.push_back({source, at, stride});
    }
  }
  void end_row() { starts.push_back(static_cast<int>(columns.size())); }
};

}  // namespace voile::linear
