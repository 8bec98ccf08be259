// Fields of contact for results.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "results/results.hpp"
#include "system/model.hpp"

namespace voile::record {

/// contact_force, friction_force, contact_pressure (of the face that is pressed more), and where they have a meaning passing
/// and ease, at state a: those that are wanted. None without contact. Values on rank 0. Collective: `wants` must answer alike on every rank.
[[nodiscard]] std::vector<results::Field> contact_fields(system::Model& model, Vec a,
                                                         const std::function<bool(const std::string&)>& wants);

}  // namespace voile::record
