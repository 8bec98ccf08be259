#include "hyperelastic_laws.hpp"

#include <algorithm>

namespace voile::energy {

HyperelasticLaws::HyperelasticLaws(const std::vector<Material>& materials) {
  for (const Material& m : materials) {
    any_ = any_ || m.rubber.any();
    terms_ = std::max(terms_, static_cast<int>(m.rubber.terms.size()));
  }
}

void HyperelasticLaws::add(const Batches::Place& place, double area, const Hyperelastic& law) {
  std::vector<double> numbers(lines_per_batch(), 0.0);
  area *= law.area;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < 3; ++k)
      numbers[rubber_fields::natural + 3 * r + k] =
          law.natural(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(k));
  numbers[rubber_fields::is] = law.any() ? 1.0 : 0.0;
  numbers[rubber_fields::c10] = area * law.c10;
  numbers[rubber_fields::c01] = area * law.c01;
  numbers[rubber_fields::shear_modulus] = area * law.shear_modulus();
  for (std::size_t t = 0; t < law.terms.size(); ++t) {
    numbers[rubber_fields::terms + 2 * t] = area * law.terms[t].modulus;
    numbers[rubber_fields::terms + 2 * t + 1] = law.terms[t].exponent;
  }
  const std::size_t first = place.batch * lines_per_batch();
  lines_.resize(std::max(lines_.size(), first + lines_per_batch()));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    for (auto lane = static_cast<std::size_t>(place.lane); lane < batch_lanes; ++lane)
      lines_[first + i].of[lane] = numbers[i];
}

}  // namespace voile::energy
