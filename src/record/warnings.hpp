// What a run says of its own results on stderr, once each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "energy/chord_error.hpp"
#include "input/case.hpp"
#include "system/model.hpp"
#include "validity.hpp"

namespace voile::record {

/// On rank 0.
class Warnings {
 public:
  /// `linear`: displacements are those of a linear analysis, which turn nothing. `search`: states before the last one only lead
  /// to it.
  Warnings(bool linear, bool search) : linear_(linear), search_(search) {}
  /// The mesh has changed.
  void begin_epoch() { chord_error_.reset(); }
  /// Of strains and turns beyond what the element is made for.
  void say_range(const mesh::SurfaceMesh& mesh, const Validity& v);
  /// Of dimples under pressure (dimples.hpp).
  void say_dimples(const input::Case& c, const energy::Sheet& sheet, const std::vector<double>& displacement,
                   double load_factor);
  /// Of the strains of a linear analysis, E11, E22, 2 E12 per triangle in material axes: that of a state which rotates by much is
  /// none of them.
  void say_linear_range(const energy::Sheet& sheet, const std::vector<double>& strain);
  /// Spurious energy of chords (energy/chord_error.hpp), with `six_node_corrected` and that of second derivatives in the
  /// surface, per triangle [J/m^2]; and the largest fraction of the stored energy that it has had in states that count.
  struct MembraneError {
    std::vector<double> density;
    double fraction = 0.0;
  };
  /// `strain`: below it a state is only round-off.
  [[nodiscard]] MembraneError membrane_error(const energy::Sheet& sheet, const system::TriangleFields& t,
                                             double strain);
  /// What to warn of at the end; empty: nothing.
  [[nodiscard]] std::string membrane_text() const;

 private:
  void say_strain(const mesh::SurfaceMesh& mesh, const Reach& reach, Index triangle);
  bool linear_, search_;
  bool said_strain_ = false, said_turn_ = false, said_locking_ = false, said_dimples_ = false, is_corrected_ = false;
  double largest_error_ = 0.0;
  std::optional<energy::ChordError> chord_error_;  ///< of the epoch
};

}  // namespace voile::record
