#include "half_blocks.hpp"

#include <algorithm>

#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

/// What a block of the base is marked with until it gets its number.
constexpr Index counted = 0;

using Nine = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

}  // namespace

HalfBlocks::HalfBlocks(const Dofs& dofs, const BlockMatrix& base) : dofs_(&dofs), base_(&base) {
  for (const auto& columns : base.pattern()) {
    row_.push_back(source_.size());
    source_.resize(source_.size() + columns.size(), unused);
  }
}

/// Number of a block of the base.
std::size_t HalfBlocks::block_of(Index row, Index column) const {
  const std::vector<Index>& columns = base_->pattern()[static_cast<std::size_t>(row)];
  const auto found = std::lower_bound(columns.begin(), columns.end(), column);
  if (found == columns.end() || *found != column) throw InternalError("matrix pattern lacks a block of an element");
  return row_[static_cast<std::size_t>(row)] + static_cast<std::size_t>(found - columns.begin());
}

void HalfBlocks::end_counting() {
  counting_ = false;
  const Index first = dofs_->first_row(), owned = dofs_->local().owned;
  std::size_t at = 0;
  for (Index r = 0; r < owned; ++r)
    for (const Index column : base_->pattern()[static_cast<std::size_t>(r)]) {
      Index& source = source_[at++];
      if (source != counted) continue;
      source = none_++;
      if (column > first + r && column < first + owned) source_[block_of(column - first, first + r)] = turned(source);
    }
}

Index HalfBlocks::place_of(Index a, Index b) {
  const Index row = std::min(a, b), column = dofs_->local().row_of[std::max(a, b)];
  if (row >= dofs_->local().owned) return none_;
  Index& source = source_[block_of(row, column)];
  if (counting_) source = counted;
  return source;
}

Index HalfBlocks::place_alone(Index a, Index b, bool diagonal) {
  if (counting_) return none_;
  alone_.push_back({std::min(a, b), std::max(a, b), diagonal});
  return none_ + static_cast<Index>(alone_.size());
}

double* HalfBlocks::open() {
  values_.assign(9 * (static_cast<std::size_t>(none_) + 1 + alone_.size()), 0.0);
  return values_.data();
}

void HalfBlocks::write_to(const BlockMatrix& matrix, const BlockMatrix::Values& values, const CompactMatrix& k,
                          double factor) const {
  if (matrix.extended()) matrix.clear();
  auto scalars = k.scalars();
  auto &inside = scalars.first, &outside = scalars.second;
  const Index* source = source_.data();
  matrix.for_each_base_slot([&](Slot s) {  // in the order of the two parts
    double* at = s.offset >= 0 ? values.diagonal + s.offset : values.off_diagonal + ~s.offset;
    const double scalar = factor * (s.offset >= 0 ? *inside++ : *outside++);
    const Index from = *source++;
    const auto write = [&](const double* a, int row, int column) {
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) at[r * s.stride + c] = a[r * row + c * column] + (r == c ? scalar : 0.0);
    };
    static const double none[9] = {};
    if (from >= 0)
      write(values_.data() + 9 * static_cast<std::size_t>(from), 3, 1);
    else if (from == unused)
      write(none, 3, 1);
    else
      write(values_.data() + 9 * static_cast<std::size_t>(turned(from)), 1, 3);
  });
  k.add_others(matrix, values, factor);
  const double* from = values_.data() + 9 * (static_cast<std::size_t>(none_) + 1);
  for (const auto& [a, b, diagonal] : alone_) {
    const Mat3 block = Eigen::Map<const Nine>(from);
    add_block(*dofs_, matrix, a, b, block, values);
    if (!diagonal) add_block(*dofs_, matrix, b, a, block.transpose(), values);
    from += 9;
  }
}

}  // namespace voile::system
