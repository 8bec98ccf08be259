// A PETSc AIJ matrix of 3x3 blocks with a fixed pattern, written to directly at precomputed places.
//
// The pattern is made once and keeps explicit zeros, so that a direct solver repeats its symbolic factorisation only
// when the mesh changes. A Slot says where a block lies in the value arrays of the rank that owns its row.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "base/types.hpp"
#include "mesh/partition.hpp"

namespace voile::system {

/// Block columns (global block rows numbers, ascending) of each owned block row.
using BlockPattern = std::vector<std::vector<Index>>;

/// Place of a 3x3 block: offset of its first entry, distance between its rows. Blocks of other ranks have stride 0.
struct Slot {
  Index offset = 0;  ///< >= 0: in the diagonal part; otherwise ~offset in the off-diagonal part
  Index stride = 0;
};

class BlockMatrix {
 public:
  /// Value arrays of this rank while being written.
  struct Values {
    double* diagonal = nullptr;
    double* off_diagonal = nullptr;
    void add(Slot slot, const Mat3& block) const {
      if (slot.stride == 0) return;
      double* at = slot.offset >= 0 ? diagonal + slot.offset : off_diagonal + ~slot.offset;
      for (int r = 0; r < 3; ++r, at += slot.stride)
        for (int c = 0; c < 3; ++c) at[c] += block(r, c);
    }
    /// Has the place of a block fetched from memory for an add() that will follow soon.
    void fetch(Slot slot) const {
      const double* at = slot.offset >= 0 ? diagonal + slot.offset : off_diagonal + ~slot.offset;
      for (int r = 0; r < 3; ++r, at += slot.stride) __builtin_prefetch(at, 1);
    }
  };

  BlockMatrix() = default;
  /// Collective. The pattern holds this rank's rows.
  BlockMatrix(MPI_Comm comm, const mesh::Partition& partition, BlockPattern pattern);

  [[nodiscard]] Mat mat() const { return mat_; }
  /// A second matrix with the same pattern and the same slots, filled with zeros; not of one that was extended. Collective.
  [[nodiscard]] BlockMatrix twin() const;
  /// Slot of the block (owned block row counted from the first of this rank, global block column).
  /// Throws InternalError if the pattern has no such block.
  [[nodiscard]] Slot slot(Index local_row, Index column) const;
  [[nodiscard]] bool has(Index local_row, Index column) const;
  [[nodiscard]] const BlockPattern& pattern() const { return *pattern_; }
  /// Gives the values back to the system; pattern, slots and twins remain. Collective.
  void release();
  /// Gives the same PETSc matrix another pattern, which holds that of `base` (a matrix never extended): slots change,
  /// values are lost, and `base` and its twins can be copied from as before. Collective.
  void extend(const BlockMatrix& base, BlockPattern pattern);

  /// Opens the value arrays; close() ends the assembly. Collective as a pair.
  [[nodiscard]] Values open();
  void close();
  /// Sets the open value arrays to zero.
  void clear() const;
  /// Overwrites the open value arrays with those of a twin (nothing but two copies of memory) or of the base that this
  /// matrix extends.
  void copy_values_from(const BlockMatrix& twin) const;
  /// Adds a multiple of a twin's values to the open value arrays.
  void add_values_from(const BlockMatrix& twin, double factor) const;

  /// Whether extend() was called.
  [[nodiscard]] bool extended() const { return extended_; }

  /// How often values have been closed; the same on all ranks.
  [[nodiscard]] long version() const { return version_; }

  /// Calls f(slot) for every block of this rank in the pattern of the base (its own one, if never extended): rows one after
  /// the other, columns ascending.
  template <class F>
  void for_each_base_slot(F&& f) const {
    if (extended_) {
      for (const Place& p : places_) f(p.to);
      return;
    }
    for (Index r = 0; r < row_count_; ++r)
      for (Index at = 0; at < static_cast<Index>((*pattern_)[r].size()); ++at) f(slot_at(r, at));
  }

  /// Calls f(owned block row, global block column, block) for every stored block of this rank.
  template <class F>
  void for_each_block(F&& f) const {
    const auto [inside, outside] = read();
    for (Index r = 0; r < static_cast<Index>(pattern_->size()); ++r)
      for (Index column : (*pattern_)[r]) {
        const Slot s = slot(r, column);
        const double* at = s.offset >= 0 ? inside + s.offset : outside + ~s.offset;
        f(r, column, Mat3(Eigen::Map<const Stored, 0, Eigen::OuterStride<>>(at, Eigen::OuterStride<>(s.stride))));
      }
  }

  /// Calls f(is_diagonal_part, offset, scalar row, scalar column) for every stored entry of this rank; global numbers.
  template <class F>
  void for_each_entry(F&& f) const {
    for (Index r = 0; r < static_cast<Index>(pattern_->size()); ++r)
      for (Index column : (*pattern_)[r]) {
        const Slot s = slot(r, column);
        for (Index i = 0; i < 3; ++i)
          for (Index j = 0; j < 3; ++j) {
            const Index at = (s.offset >= 0 ? s.offset : ~s.offset) + i * s.stride + j;
            f(s.offset >= 0, at, 3 * (first_row_ + r) + i, 3 * column + j);
          }
      }
  }

 private:
  using Stored = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  /// Where a block of the base lies there and here.
  struct Place {
    Slot from, to;
  };
  /// Where the rows of a block row lie. PETSc stores both parts by rows with ascending columns, so that places follow from
  /// counts alone.
  struct Row {
    Index before = 0, in = 0;              ///< blocks before those of the diagonal part, and those in it
    Index diagonal = 0, off_diagonal = 0;  ///< offset of the first entry in each part
  };
  /// Slot of a block by its position in its row.
  [[nodiscard]] Slot slot_at(Index local_row, Index at) const {
    const Row& row = rows_[local_row];
    const Index out = static_cast<Index>((*pattern_)[local_row].size()) - row.in;
    if (at >= row.before && at < row.before + row.in) return {row.diagonal + 3 * (at - row.before), 3 * row.in};
    return {~(row.off_diagonal + 3 * (at < row.before ? at : at - row.in)), 3 * out};
  }
  void create();
  void preallocate();
  void find_parts();
  /// Values of both parts.
  [[nodiscard]] std::pair<const double*, const double*> read() const;

  petsc::MatHandle mat_;
  Mat diagonal_ = nullptr, off_diagonal_ = nullptr;  ///< parts of mat_, not owned
  Values open_values_;
  std::vector<Place> places_;  ///< after extend()
  std::vector<Row> rows_;
  bool extended_ = false;
  long version_ = 0;
  std::shared_ptr<const BlockPattern> pattern_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  Index first_row_ = 0, row_count_ = 0;
};

}  // namespace voile::system
