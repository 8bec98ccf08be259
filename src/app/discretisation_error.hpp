// How far stress resultants of a recorded state are from smooth ones: two fields, one number, and what to tell of it; private to src/app.
//
// Symbols   e_N, e_M   energy of the differences (energy/recovery_error.hpp) [J/m^2];  W  stored energy [J]
//           eta^2      integral of e_N + e_M over W
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "validity.hpp"
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

  /// eta^2 of a state, and of bending and stretching each over its own energy; not a number where there is none.
  struct Fractions {
    double whole = std::nan(""), membrane = std::nan(""), bending = std::nan("");
  };
  struct Densities {
    std::vector<double> membrane, bending;  ///< e_N, e_M of each triangle
  };
  /// Of the model's sheet; `fields` on rank 0. Each rank fits those of its own triangles. Collective; values on rank 0.
  [[nodiscard]] Densities of(const system::Model& model, const system::TriangleFields& fields);
  /// The same of a recorded state, which is judged: `place` names it on a path, e.g. "load factor 0.5". Collective.
  [[nodiscard]] Densities judged(const system::Model& model, const system::TriangleFields& fields,
                                 const std::string& place);
  /// Of the last state; on rank 0.
  [[nodiscard]] const Fractions& last() const { return last_; }
  /// eta^2 of the worst state; on rank 0.
  [[nodiscard]] double largest() const { return largest_; }
  /// What to tell of the last state: cause, place, remedy; where its eta^2 is below error_limit and that of one before is
  /// not, of the worst; else empty. On rank 0.
  [[nodiscard]] const std::string& warning() const { return last_.whole > error_limit ? warning_ : worst_warning_; }

 private:
  void judge(const energy::Sheet& sheet, const system::TriangleFields& fields, const Densities& of,
             const std::string& place);

  bool linear_;
  std::optional<energy::RecoveryError> recovery_;  ///< of the epoch
  Fractions last_;
  double largest_ = std::nan("");
  std::string warning_, worst_warning_;
};

}  // namespace voile::app
