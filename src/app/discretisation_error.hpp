// How far stress resultants of a recorded state are from smooth ones: two fields, one number, and what to tell of it; private to src/app.
//
// Symbols   e_N, e_M   energy of the differences (energy/recovery_error.hpp) [J/m^2];  W  stored energy [J]
//           eta^2      integral of e_N + e_M over W
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "voile/energy/recovery_error.hpp"
#include "voile/system/model.hpp"
#include "voile/system/recovery.hpp"

namespace voile::app {

/// Energy of a state as its resultants have it [J], with `six_node_corrected` that of second derivatives in the surface, too. `fields`
/// on this rank. Not collective.
[[nodiscard]] double stored_energy(const energy::Sheet& sheet, const system::TriangleFields& fields);

/// Energy of a strain of 1e-9 throughout [J]: a state with less is round-off. Not collective.
[[nodiscard]] double round_off_energy(const energy::Sheet& sheet);

class DiscretisationError {
 public:
  /// `linear`: displacements are of no certain size, however small.
  explicit DiscretisationError(bool linear) : linear_(linear) {}
  /// The mesh or the model has changed.
  void begin_epoch() { recovery_.reset(); }

  struct Densities {
    std::vector<double> membrane, bending;  ///< e_N, e_M of each triangle
  };
  /// Of the model's sheet; `fields` on rank 0. Each rank fits those of its own triangles. Collective; values on rank 0.
  [[nodiscard]] Densities of(const system::Model& model, const system::TriangleFields& fields);
  /// eta^2 of the last state; on rank 0. Not a number if there was none.
  [[nodiscard]] double share() const { return share_; }
  /// What to tell of the last state: cause, place, remedy; empty where eta^2 is below error_limit. On rank 0.
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  void judge(const energy::Sheet& sheet, const system::TriangleFields& fields, const Densities& of);

  bool linear_;
  std::optional<energy::RecoveryError> recovery_;  ///< of the epoch
  double share_ = std::nan("");
  std::string warning_;
};

}  // namespace voile::app
