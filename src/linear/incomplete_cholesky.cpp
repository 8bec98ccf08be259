#include "incomplete_cholesky.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace voile::linear {

namespace {

constexpr double shift_growth = 4.0, largest_shift = 16.0;
/// Pivots below this fraction of the matrix's own block are as good as indefinite.
constexpr double least_pivot = 1e-8;
/// Blocks of the matrix, which lie all over the memory in the order of elimination, are fetched so many before their turn.
constexpr int ahead = 16;

using Block3 = Eigen::Matrix3d;
/// A block in compressed rows.
using Entries = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>, 0, Eigen::OuterStride<>>;

/// D^-1 of a block that is symmetric but for round-off; false unless it is well enough positive.
bool invert(const Block3& d, double scale, Block3& inverse) {
  const double least = least_pivot * scale;
  const double a = d(0, 0);
  if (!(a > least)) return false;
  const double l1 = d(1, 0) / a, l2 = d(2, 0) / a;
  const double b = d(1, 1) - l1 * d(1, 0);
  if (!(b > least)) return false;
  const double m = (d(2, 1) - l2 * d(1, 0)) / b;
  const double c = d(2, 2) - l2 * d(2, 0) - m * m * b;
  if (!(c > least) || !std::isfinite(a + b + c)) return false;
  // Rows of the inverse of the unit triangle: (1), (-l1, 1), (l1 m - l2, -m, 1).
  const double n = l1 * m - l2;
  inverse(2, 2) = 1.0 / c;
  inverse(2, 1) = inverse(1, 2) = -m / c;
  inverse(2, 0) = inverse(0, 2) = n / c;
  inverse(1, 1) = 1.0 / b + m * m / c;
  inverse(1, 0) = inverse(0, 1) = -l1 / b - m * n / c;
  inverse(0, 0) = 1.0 / a + l1 * l1 / b + n * n / c;
  return true;
}

Rows read_rows(const double* first, int stride) {
  Rows t;
  for (int r = 0; r < 3; ++r, first += stride) t.col(r) << first[0], first[1], first[2], 0.0;
  return t;
}

/// Rows of the product of a block, by rows, and a symmetric one.
Rows times_rows(const double* left, const float* right) {
  Rows product;
  for (int r = 0; r < 3; ++r) product.col(r) = combined(Eigen::Map<const Lanes>(left + 4 * r), right);
  return product;
}

}  // namespace

bool IncompleteCholesky::read_pattern(const BlockPattern& pattern, std::vector<int> order) {
  if (!pattern.full) return false;
  order_ = std::move(order);
  position_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) position_[order_[i]] = static_cast<int>(i);
  row_starts_.assign(1, 0);
  columns_.clear();
  places_.clear();
  diagonals_.clear();
  for (const int row : order_)
    if (!read_row(pattern, row)) return false;
  find_matches();
  w_.assign(9 * columns_.size() + 1, 0.0F);  // one more, since lanes are read by fours
  inverse_.assign(9 * diagonals_.size() + 1, 0.0F);
  x_.assign(4 * diagonals_.size(), 0.0);
  int longest = 0;
  for (int i = 0; i < block_rows(); ++i) longest = std::max(longest, row_starts_[i + 1] - row_starts_[i]);
  row_.assign(Rows::SizeAtCompileTime * static_cast<std::size_t>(longest), 0.0);
  return true;
}

bool IncompleteCholesky::read_row(const BlockPattern& pattern, int row) {
  std::vector<std::pair<int, int>> lower;  // column and number of each block that is eliminated before
  bool has_diagonal = false;
  for (int at = pattern.starts[row]; at < pattern.starts[row + 1]; ++at) {
    const int column = pattern.columns[at];
    if (column == row) {
      diagonals_.push_back(pattern.places[at]);
      has_diagonal = true;
    } else if (position_[column] < position_[row]) {
      lower.emplace_back(position_[column], at);
    }
  }
  std::sort(lower.begin(), lower.end());
  for (const auto& [column, at] : lower) {
    columns_.push_back(column);
    places_.push_back(pattern.places[at]);
  }
  row_starts_.push_back(static_cast<int>(columns_.size()));
  return has_diagonal;
}

void IncompleteCholesky::find_matches() {
  std::vector<int> place(diagonals_.size(), -1);  // of a column in the row at work, counted from its start
  match_starts_.assign(1, 0);
  matches_.clear();
  for (int i = 0; i < block_rows(); ++i) {
    const int begin = row_starts_[i], end = row_starts_[i + 1];
    for (int at = begin; at < end; ++at) place[columns_[at]] = at - begin;
    for (int at = begin; at < end; ++at) {
      const int k = columns_[at];
      for (int other = row_starts_[k]; other < row_starts_[k + 1]; ++other)
        if (place[columns_[other]] >= 0) matches_.push_back({place[columns_[other]], other});
      match_starts_.push_back(static_cast<int>(matches_.size()));
    }
    for (int at = begin; at < end; ++at) place[columns_[at]] = -1;
  }
}

bool IncompleteCholesky::factor_shifted(const BlockPattern::Values& values, double shift) {
  const auto first_of = [&](const BlockPattern::Place& place) {
    return values[static_cast<std::size_t>(place.source)] + place.first;
  };
  const auto fetch = [&](const BlockPattern::Place& place) {
    for (int r = 0; r < 3; ++r) __builtin_prefetch(first_of(place) + r * place.stride);
  };
  for (int i = 0; i < block_rows(); ++i) {
    const int begin = row_starts_[i], end = row_starts_[i + 1];
    const Block3 own = Entries(first_of(diagonals_[i]), Eigen::OuterStride<>(diagonals_[i].stride));
    const double scale = own.diagonal().cwiseAbs().maxCoeff();
    Block3 pivot = (1.0 + shift) * own;
    for (int at = begin; at < end; ++at) {
      if (at + ahead < static_cast<int>(places_.size())) fetch(places_[at + ahead]);
      double* row = row_.data() + Rows::SizeAtCompileTime * (at - begin);
      const Rows t = eliminated(at, read_rows(first_of(places_[at]), places_[at].stride));
      Eigen::Map<Rows>{row} = t;
      const Rows w = times_rows(row, inverse_.data() + 9 * columns_[at]);
      Eigen::Map<Eigen::Matrix3f>(w_.data() + 9 * static_cast<std::size_t>(at)) =
          w.topRows<3>().transpose().cast<float>();
      pivot -= t.topRows<3>().transpose().lazyProduct(w.topRows<3>());
    }
    Block3 inverse;
    if (!invert(pivot, scale, inverse)) {
      hopeless_ = !invert(own, scale, inverse);  // a block of the diagonal is indefinite itself, and with any shift
      return false;
    }
    Eigen::Map<Eigen::Matrix3f>(inverse_.data() + 9 * i) = inverse.cast<float>();
  }
  for (std::size_t at = 0; at < columns_.size(); ++at)
    Eigen::Map<Eigen::Matrix3f>(w_.data() + 9 * at).transposeInPlace();
  return true;
}

/// Takes off T what the matches of its block say: the products of blocks of the row at work and blocks of W by columns.
Rows IncompleteCholesky::eliminated(int at, const Rows& own) const {
  Rows t = own;
  for (int m = match_starts_[at]; m < match_starts_[at + 1]; ++m) {
    const double* left = row_.data() + Rows::SizeAtCompileTime * matches_[m].in_row;
    const float* right = w_.data() + 9 * static_cast<std::size_t>(matches_[m].other);
    for (int k = 0; k < 3; ++k) {
      const Lanes column = lanes(right + 3 * k);
      for (int r = 0; r < 3; ++r) t.col(r) -= left[4 * r + k] * column;
    }
  }
  return t;
}

bool IncompleteCholesky::factor(const BlockPattern::Values& values, double shift, double first_shift) {
  hopeless_ = false;
  for (attempts_ = 1; shift <= largest_shift; ++attempts_) {
    shift_ = shift;
    if (factor_shifted(values, shift)) return true;
    if (hopeless_) return false;
    shift = std::max(shift_growth * shift, first_shift);
  }
  return false;
}

void IncompleteCholesky::solve(const double* b, double* x) {
  const int n = block_rows();
  for (int i = 0; i < n; ++i) {
    Lanes sum[3] = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};
    for (int at = row_starts_[i]; at < row_starts_[i + 1]; ++at) {
      const Lanes y = part(columns_[at]);
      const float* w = w_.data() + 9 * static_cast<std::size_t>(at);
      for (int r = 0; r < 3; ++r) sum[r] += lanes(w + 3 * r).cwiseProduct(y);
    }
    const double* own = b + 3 * order_[i];
    part(i) << own[0] - total(sum[0]), own[1] - total(sum[1]), own[2] - total(sum[2]), 0.0;
  }
  for (int i = 0; i < n; ++i) part(i) = combined(part(i), inverse_.data() + 9 * i);
  for (int i = n - 1; i >= 0; --i) {
    const Lanes y = part(i);
    for (int at = row_starts_[i]; at < row_starts_[i + 1]; ++at)
      part(columns_[at]) -= combined(y, w_.data() + 9 * static_cast<std::size_t>(at));
    Eigen::Map<Eigen::Vector3d>(x + 3 * order_[i]) = y.head<3>();
  }
}

}  // namespace voile::linear
