#include "voile/system/half_blocks.hpp"

#include <algorithm>

#include "voile/base/error.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

HalfBlocks::HalfBlocks(const Dofs& dofs, const BlockMatrix& base) : dofs_(&dofs), base_(&base) {
  const Index first = dofs.first_row(), owned = dofs.local().owned;
  for (Index r = 0; r < owned; ++r) {
    row_.push_back(number_.size());
    for (const Index column : base.pattern()[static_cast<std::size_t>(r)]) {
      const bool lower = column >= first && column < first + r;
      number_.push_back(lower ? no_index : static_cast<Index>(pairs_.size()));
      if (!lower) pairs_.push_back({r, column});
    }
  }
  none_ = static_cast<Index>(pairs_.size());
}

Index HalfBlocks::place_of(Index a, Index b) const {
  const LocalPoints& local = dofs_->local();
  const auto row = static_cast<std::size_t>(std::min(a, b));
  if (static_cast<Index>(row) >= local.owned) return none_;
  const std::vector<Index>& columns = base_->pattern()[row];
  const Index column = local.row_of[std::max(a, b)];
  const auto found = std::lower_bound(columns.begin(), columns.end(), column);
  if (found == columns.end() || *found != column) throw InternalError("matrix pattern lacks a block of an element");
  return number_[row_[row] + static_cast<std::size_t>(found - columns.begin())];
}

Index HalfBlocks::place_alone(Index a, Index b, bool diagonal) {
  alone_.push_back({std::min(a, b), std::max(a, b), diagonal});
  return none_ + static_cast<Index>(alone_.size());
}

double* HalfBlocks::open() {
  values_.assign(9 * (pairs_.size() + 1 + alone_.size()), 0.0);
  return values_.data();
}

void HalfBlocks::locate(const Dofs& dofs, const BlockMatrix& matrix) {
  const Index first = dofs.first_row(), owned = dofs.local().owned;
  places_.clear();
  places_.reserve(pairs_.size());
  for (const Pair& p : pairs_) {
    const Index other = p.b - first;
    const bool mirrored = other >= 0 && other < owned && other != p.a;
    places_.push_back({matrix.slot(p.a, p.b), mirrored ? matrix.slot(other, first + p.a) : Slot{}});
  }
}

void HalfBlocks::add_to(const Dofs& dofs, const BlockMatrix& matrix, int pattern, const BlockMatrix::Values& values) {
  if (pattern != located_) locate(dofs, matrix);
  located_ = pattern;
  const auto at = [&](const Slot& s) {
    return s.offset >= 0 ? values.diagonal + s.offset : values.off_diagonal + ~s.offset;
  };
  const double* from = values_.data();
  constexpr std::size_t ahead = 8;
  for (std::size_t k = 0; k < places_.size(); ++k, from += 9) {
    const Places& p = places_[k];
    if (k + ahead < places_.size() && places_[k + ahead].lower.stride != 0) values.fetch(places_[k + ahead].lower);
    double* to = at(p.upper);
    for (int r = 0; r < 3; ++r, to += p.upper.stride)
      for (int c = 0; c < 3; ++c) to[c] += from[3 * r + c];
    if (p.lower.stride == 0) continue;
    to = at(p.lower);
    for (int r = 0; r < 3; ++r, to += p.lower.stride)
      for (int c = 0; c < 3; ++c) to[c] += from[3 * c + r];
  }
  from += 9;
  for (std::size_t k = 0; k < alone_.size(); ++k, from += 9) {
    const Mat3 block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from);
    const auto [a, b, diagonal] = alone_[k];
    add_block(dofs, matrix, a, b, block, values);
    if (!diagonal) add_block(dofs, matrix, b, a, block.transpose(), values);
  }
}

}  // namespace voile::system
