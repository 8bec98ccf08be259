// Numbers of hyperelastic laws (hyperelastic.hpp) of all triangles of a membrane beside its batches, for the element kernels.
#pragma once

#include <vector>

#include "batches.hpp"
#include "material.hpp"

namespace voile::energy {

class HyperelasticLaws {
 public:
  HyperelasticLaws() = default;
  explicit HyperelasticLaws(const std::vector<Material>& materials);
  [[nodiscard]] bool any() const { return any_; }
  /// Ogden's, of the law that has most.
  [[nodiscard]] int terms() const { return terms_; }
  /// As YarnLaws::add.
  void add(const Batches::Place& place, double area, const Hyperelastic& law);
  [[nodiscard]] const double* batch(std::size_t number) const {
    return any_ ? lines_[number * lines_per_batch()].of.data() : nullptr;
  }

 private:
  [[nodiscard]] std::size_t lines_per_batch() const {
    return static_cast<std::size_t>(rubber_fields::terms) + 2 * static_cast<std::size_t>(terms_);
  }

  bool any_ = false;
  int terms_ = 0;
  std::vector<Line> lines_;
};

}  // namespace voile::energy
