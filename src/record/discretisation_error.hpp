// How far stress resultants of a recorded state are from smooth ones: two fields, one number, and what to tell of it.
//
// Symbols   e_N, e_M   energy of the differences (energy/recovery_error.hpp) [J/m^2]
//           W          stored energy, or that of the strains from rest where heat and initial strains store more [J]
//           eta^2      integral of e_N + e_M over W
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "energy/recovery_error.hpp"
#include "system/model.hpp"
#include "system/recovery.hpp"
#include "validity.hpp"

namespace voile::record {

/// What fields are of: a state, or a small change of one, as a mode is.
enum class FieldsOf { state, change };

/// Energy of a state as its resultants have it [J], with `six_node_corrected` that of second derivatives in the surface, too; of a
/// change half the work of the changes. `fields` on this rank. Not collective.
[[nodiscard]] double stored_energy(const energy::Sheet& sheet, const system::TriangleFields& fields,
                                   FieldsOf what = FieldsOf::state);

/// What errors of a state are compared with [J]: W, and that of bending in it. Of a sheet that is heated it is that of the strains
/// from rest: held, most of the stored energy is of stresses that any mesh has right; free, there is none.
/// Likewise.
struct JudgedEnergy {
  double whole = 0.0, bending = 0.0;
};
[[nodiscard]] JudgedEnergy judged_energy(const energy::Sheet& sheet, const system::TriangleFields& fields);

/// Strains below which a nonlinear state is only round-off, such as that of a sheet that has only moved.
inline constexpr double no_strain = 1e-9;

/// Energy of such a strain throughout [J]: a state with less is round-off. Not collective.
[[nodiscard]] double round_off_energy(const energy::Sheet& sheet, double strain = no_strain);

class DiscretisationError {
 public:
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
  [[nodiscard]] Densities of(const system::Model& model, const system::TriangleFields& fields,
                             FieldsOf what = FieldsOf::state);
  struct Judged {
    std::string place{};        ///< of the state on a path, e.g. "load factor 0.5"
    double strain = no_strain;  ///< below which it is only round-off
  };
  /// The same of a recorded state, which is judged. Collective.
  [[nodiscard]] Densities judged(const system::Model& model, const system::TriangleFields& fields, const Judged& state);
  /// Of the last state; on rank 0.
  [[nodiscard]] const Fractions& last() const { return last_; }
  /// eta^2 of the worst state; on rank 0.
  [[nodiscard]] double largest() const { return largest_; }
  /// What to tell of the last state: cause, place, remedy; where its eta^2 is below error_limit and that of one before is
  /// not, of the worst; else empty. On rank 0.
  [[nodiscard]] const std::string& warning() const { return last_.whole > error_limit ? warning_ : worst_warning_; }

 private:
  void judge(const energy::Sheet& sheet, const system::TriangleFields& fields, const Densities& of,
             const Judged& state);

  std::optional<energy::RecoveryError> recovery_;  ///< of the epoch
  Fractions last_;
  double largest_ = std::nan("");
  std::string warning_, worst_warning_;
};

}  // namespace voile::record
