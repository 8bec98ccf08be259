// Yarns that stiffen and rub in the plane (yarn_law.hpp), of all triangles of a membrane beside its batches: numbers of the element
// kernels, and slips.
#pragma once

#include <vector>

#include "batches.hpp"
#include "material.hpp"

namespace voile::energy {

/// Laws of all triangles of a membrane beside its batches.
class YarnLaws {
 public:
  YarnLaws() = default;
  /// `factor`: of the strain that rubs in the energy; friction is that of the whole triangle.
  YarnLaws(const std::vector<Material>& materials, double factor);
  [[nodiscard]] bool any() const { return any_; }
  [[nodiscard]] bool rub() const { return rub_; }
  /// The triangle that has come to this place, and to the lanes behind, which repeat it until others come.
  void add(const Batches::Place& place, double area, const YarnLaw& law);
  [[nodiscard]] const double* batch(std::size_t number) const {
    return any_ ? lines_[number * lines_per_batch()].of.data() : nullptr;
  }
  [[nodiscard]] int knots() const { return knots_; }

  [[nodiscard]] double slip(const Batches::Place& place) const { return number(place, yarn_law_fields::slip); }
  void set_slip(const Batches::Place& place, double slip);
  /// Where the slider goes at a strain in material axes.
  [[nodiscard]] double slip_at(const Batches::Place& place, const Vec3& strain) const;
  /// What it takes on the way [J].
  [[nodiscard]] double lost_at(const Batches::Place& place, const Vec3& strain) const;

 private:
  [[nodiscard]] std::size_t lines_per_batch() const {
    return static_cast<std::size_t>(yarn_law_fields::knots) + 6 * static_cast<std::size_t>(knots_);
  }
  [[nodiscard]] double number(const Batches::Place& p, int field) const {
    return lines_[p.batch * lines_per_batch() + static_cast<std::size_t>(field)].of[static_cast<std::size_t>(p.lane)];
  }

  bool any_ = false, rub_ = false;
  int knots_ = 0;
  double factor_ = 1.0;
  std::vector<Line> lines_;
};

}  // namespace voile::energy
