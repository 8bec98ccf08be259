// How far the tension of a sheet in equilibrium is from the prestress with which its form was found.
//
// Symbols   N   membrane force, N0 prestress of the material, as symmetric tensors in the plane of a triangle           [N/m]
//           N1 >= N2  principal values;  error = largest |principal value of N - N0| over the largest N0_1
// The form balances N0 across the surface; within it what cells leave is taken by strain, which costs a stiff sheet much force.
#pragma once

#include <string>

#include "energy/sheet.hpp"
#include "system/recovery.hpp"

namespace voile::record {

/// Of N0 that may change before a user is warned.
inline constexpr double tension_limit = 0.1;

struct TensionChange {
  double least = 0.0, most = 0.0;              ///< smallest N2, largest N1 [N/m]
  double given_least = 0.0, given_most = 0.0;  ///< the same of N0 [N/m]
  double error = 0.0;
  Index at = no_index;  ///< triangle of the error
};

/// Rank 0 only.
[[nodiscard]] TensionChange tension_change(const energy::Sheet& sheet, const system::TriangleFields& fields);

/// In words; `unit` that of forces per length.
[[nodiscard]] std::string text_of(const TensionChange& change, const energy::Sheet& sheet, const std::string& unit);

}  // namespace voile::record
