#include "batches.hpp"

#include <algorithm>

namespace voile::energy {

namespace {

constexpr int most_points = 64;

int pairs_of(int points) {
  return points * (points + 1) / 2;
}

std::vector<int> in_rows_of_eight(int count, int step) {
  std::vector<int> rows;
  for (int i = 0; i < count; ++i) rows.insert(rows.end(), batch_lanes, step * i);
  return rows;
}

}  // namespace

/// Stencils of 6 and of 12 points are by far the most frequent.
int Batches::rounded(int points) {
  if (points <= 6) return 6;
  return points <= 12 ? 12 : 4 * ((points + 3) / 4);
}

void Batches::reserve(std::size_t count, int points) {
  const std::size_t batches = count / batch_lanes + 1;
  const auto size = static_cast<std::size_t>(rounded(points));
  batches_.reserve(batches);
  fields_.reserve(batches * (static_cast<std::size_t>(fixed_) + static_cast<std::size_t>(per_point_) * size));
  points_.reserve(batches * size);
  stencils_.reserve(count * size);
  places_.reserve(count);
  first_.reserve(count + 1);
}

std::size_t Batches::open(int size) {
  const auto at = static_cast<std::size_t>(size);
  if (open_.size() <= at) open_.resize(at + 1, static_cast<std::size_t>(-1));
  if (open_[at] < batches_.size() && batches_[open_[at]].lanes < batch_lanes) return open_[at];
  batches_.push_back({fields_.size(), points_.size(), slot_count_, size, 0, false, {}});
  fields_.resize(fields_.size() + static_cast<std::size_t>(fixed_ + per_point_ * size));
  points_.resize(points_.size() + at);
  slot_count_ += static_cast<std::size_t>(pairs_of(size));
  return open_[at] = batches_.size() - 1;
}

void Batches::fill(const Batch& b, int lane, const Item& item) {
  const auto l = static_cast<std::size_t>(lane);
  const int fields = fixed_ + per_point_ * b.size;
  for (std::size_t k = 0; k < static_cast<std::size_t>(fields); ++k)
    fields_[b.fields + k].of[l] = k < item.numbers.size() ? item.numbers[k] : 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(b.size); ++i)
    points_[b.points + i][l] = item.stencil[i < item.stencil.size() ? i : 0];
}

Batches::Place Batches::add(const Item& item) {
  const std::size_t batch = open(rounded(static_cast<int>(item.stencil.size())));
  Batch& b = batches_[batch];
  const int lane = b.lanes++;
  // The lanes that follow repeat it until others come.
  for (int l = lane; l < batch_lanes; ++l) fill(b, l, item);
  b.owned[static_cast<std::size_t>(lane)] = item.owned ? 1 : 0;
  b.flag = b.flag || item.flag;
  stencils_.insert(stencils_.end(), item.stencil.begin(), item.stencil.end());
  first_.push_back(stencils_.size());
  places_.push_back({batch, lane});
  return places_.back();
}

void Batches::set_slots(Index e, const std::vector<Index>& slots, Index none) {
  slots_.resize(slot_count_);
  const Batch& b = batch_of(e);
  const int lane = places_[e].lane, n = stencil_size(e);
  std::size_t at = 0;
  for (int l = lane; l < (lane == b.lanes - 1 ? batch_lanes : lane + 1); ++l) {
    at = 0;
    for (int i = 0; i < b.size; ++i)
      for (int j = i; j < b.size; ++j)
        slots_[b.slots + static_cast<std::size_t>(pair_place(i, j, b.size))][static_cast<std::size_t>(l)] =
            numbers_per_block * (j < n && l == lane ? slots[at++] : none);
  }
}

const int* own_positions() {
  static const std::vector<int> rows = in_rows_of_eight(most_points, 1);
  return rows.data();
}

const int* own_pairs() {
  static const std::vector<int> rows = in_rows_of_eight(pairs_of(most_points), numbers_per_block);
  return rows.data();
}

}  // namespace voile::energy
