// What a run says of its own results on stderr, once each; private to src/app.
#pragma once

#include <optional>
#include <vector>

#include "validity.hpp"
#include "voile/energy/chord_error.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

/// On rank 0.
class Warnings {
 public:
  /// `linear`: strains are those of a linear analysis, whose size means nothing.
  explicit Warnings(bool linear) : linear_(linear) {}
  /// The mesh has changed.
  void begin_epoch() { chord_error_.reset(); }
  /// Of strains and turns beyond what the element is made for.
  void say_range(const mesh::SurfaceMesh& mesh, const Validity& v);
  /// Energy that chords feign (energy/chord_error.hpp), with `six_node_corrected` and that of second derivatives in the surface, per
  /// triangle [J/m^2], and its share of the stored energy; says if that is large.
  struct MembraneError {
    std::vector<double> density;
    double share = 0.0;
  };
  [[nodiscard]] MembraneError membrane_error(const energy::Sheet& sheet, const system::TriangleFields& t);

 private:
  bool linear_;
  bool said_strain_ = false, said_turn_ = false, said_error_ = false, said_locking_ = false;
  std::optional<energy::ChordError> chord_error_;  ///< of the epoch
};

}  // namespace voile::app
