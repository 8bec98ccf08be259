// Elements side by side in batches of eight: structure of arrays, for the element kernels (element_kernels.hpp).
//
// An element joins the open batch of its size: points of stencils are rounded up to the size of a batch by repeating the first point,
// whose numbers there are zero.
#pragma once

#include <array>
#include <vector>

#include "base/types.hpp"
#include "element_kernels.hpp"

namespace voile::energy {

/// Of points, three numbers each; null on a rank that has none.
[[nodiscard]] inline const double* coordinates(const Vec3* points) {
  return points ? points->data() : nullptr;
}

constexpr int numbers_per_block = 9;
/// A number, or something else, of each triangle of a batch.
template <class T>
using PerLane = std::array<T, batch_lanes>;
struct alignas(64) Line {
  PerLane<double> of{};
};

class Batches {
 public:
  /// Where an element is.
  struct Place {
    std::size_t batch = 0;
    int lane = 0;
  };
  struct Batch {
    std::size_t fields, points, slots;  ///< first of each
    int size, lanes;                    ///< points of each stencil, elements
    bool flag;                          ///< whether it was raised for one of its elements
    PerLane<char> owned;
    /// Over the owned elements.
    [[nodiscard]] double owned_sum(const Line& values) const {
      double sum = 0.0;
      for (std::size_t lane = 0; lane < static_cast<std::size_t>(lanes); ++lane)
        if (owned[lane] != 0) sum += values.of[lane];
      return sum;
    }
  };
  /// What is added: its first `fixed` numbers, `per_point` for each point.
  struct Item {
    const std::vector<Index>& stencil;
    const std::vector<double>& numbers;  ///< fixed + per_point * size of the stencil
    bool owned = true, flag = false;
  };

  Batches() = default;
  Batches(int fixed, int per_point) : fixed_(fixed), per_point_(per_point) {}
  Place add(const Item& item);
  /// Room for so many elements with stencils of so many points.
  void reserve(std::size_t count, int points);

  [[nodiscard]] Index size() const { return static_cast<Index>(places_.size()); }
  [[nodiscard]] const std::vector<Batch>& all() const { return batches_; }
  [[nodiscard]] const Batch& batch_of(Index e) const { return batches_[places_[e].batch]; }
  [[nodiscard]] Place place(Index e) const { return places_[e]; }
  [[nodiscard]] bool owned(Index e) const { return batch_of(e).owned[static_cast<std::size_t>(places_[e].lane)] != 0; }
  [[nodiscard]] const Index* stencil(Index e) const { return stencils_.data() + first_[e]; }
  [[nodiscard]] int stencil_size(Index e) const { return static_cast<int>(first_[e + 1] - first_[e]); }
  [[nodiscard]] double number(Index e, int field) const {
    return fields_[batch_of(e).fields + field].of[places_[e].lane];
  }
  void set_number(Index e, int field, double value) { fields_[batch_of(e).fields + field].of[places_[e].lane] = value; }
  /// Numbers of the blocks that the pairs i <= j of stencil positions go to, row by row; `none` takes what goes nowhere.
  void set_slots(Index e, const std::vector<Index>& slots, Index none);

  [[nodiscard]] const double* fields(const Batch& b) const { return fields_[b.fields].of.data(); }
  [[nodiscard]] const int* points(const Batch& b) const { return points_[b.points].data(); }
  [[nodiscard]] const int* slots(const Batch& b) const { return slots_.empty() ? nullptr : slots_[b.slots].data(); }

 private:
  [[nodiscard]] static int rounded(int points);
  std::size_t open(int size);
  void fill(const Batch& b, int lane, const Item& item);

  int fixed_ = 0, per_point_ = 0;
  std::vector<Batch> batches_;
  std::vector<Line> fields_;
  std::vector<PerLane<int>> points_, slots_;
  std::size_t slot_count_ = 0;
  std::vector<Place> places_;
  std::vector<Index> stencils_;
  std::vector<std::size_t> first_{0};
  std::vector<std::size_t> open_;  ///< batch that is being filled, by size; one beyond: none
};

/// Stencil positions and pairs by themselves, for the numbers of single elements: eight times the same in a row.
[[nodiscard]] const int* own_positions();
[[nodiscard]] const int* own_pairs();
/// Place of the pair i <= j among those of n points.
[[nodiscard]] constexpr int pair_place(int i, int j, int n) {
  return i * n - i * (i - 1) / 2 + j - i;
}

}  // namespace voile::energy
