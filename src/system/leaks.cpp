// What is left of the gases among the loads of a model.
#include <fmt/format.h>

#include <algorithm>

#include "boundary_conditions.hpp"
#include "gas.hpp"
#include "voile/errors.hpp"

namespace voile::system {

void BoundaryConditions::begin_leaks(const energy::Configuration& c, double time) {
  for (Gas& gas : gases_) gas.begin_leak(c, time);
}

void BoundaryConditions::end_leaks(const energy::Configuration& c, double time) {
  for (Gas& gas : gases_) gas.end_step(c, time);
}

std::vector<double> BoundaryConditions::leaks() const {
  std::vector<double> contents;
  if (std::none_of(gases_.begin(), gases_.end(), [](const Gas& gas) { return gas.leaks(); })) return contents;
  for (const Gas& gas : gases_) contents.insert(contents.end(), {gas.content().fraction, gas.content().loss});
  return contents;
}

void BoundaryConditions::restore_leaks(const std::vector<double>& contents) {
  if (contents.empty()) return;
  if (contents.size() != 2 * gases_.size())
    throw UserError(fmt::format(
        "[[load]] type 'gas': the state to continue from has {} gases, and here are {}; let all of them act "
        "in all stages that follow the first",
        contents.size() / 2, gases_.size()));
  for (std::size_t k = 0; k < gases_.size(); ++k) gases_[k].restore({contents[2 * k], contents[2 * k + 1]});
}

}  // namespace voile::system
