// Natural states of the triangles of one rank (energy/natural_state.hpp): initial strain and prestress of the materials, and
// temperatures that change with the load factor and in time. Folds of hinges (hinges.hpp) that change likewise.
#pragma once

#include <utility>
#include <vector>

#include "base/types.hpp"
#include "conditions.hpp"
#include "energy/natural_state.hpp"

namespace voile::energy {
class AngleBendingTerm;
class CurvedBendingTerm;
class JointTerm;
class MembraneTerm;
class Sheet;
struct BendingElement;
}  // namespace voile::energy

namespace voile::system {

class Discretisation;

class NaturalStates {
 public:
  /// Where the states go; `bending`: that of natural curvatures.
  struct Kernels {
    energy::MembraneTerm& membrane;
    energy::CurvedBendingTerm& bending;
    energy::AngleBendingTerm& angles;
    energy::JointTerm* joints;  ///< null: no sheets are joined
  };
  struct Flags {
    bool owned, by_angles;
  };

  /// Whether any triangle has a natural state that is not its rest shape.
  [[nodiscard]] static bool needed(const energy::Sheet& sheet, const NaturalInput& input);
  /// All references must outlive it. Throws UserError for unknown groups, and for materials without an expansion under a temperature.
  NaturalStates(const Discretisation& on, NaturalInput input, Kernels kernels);

  /// After the elements of triangle t have joined the membrane and, by angles, the bending: its natural state joins them.
  /// `local`: the points of `bending`.
  void add(Index t, const energy::BendingElement& bending, const std::vector<Index>& local, Flags flags);
  /// Natural states of this time [s] and load factor. Not collective. Throws UserError for an expression that is not finite.
  void set(double time, double load_factor);
  /// Whether they change with time or load factor.
  [[nodiscard]] bool changes() const { return changes_; }
  /// Whether any hinge has a fold that acts in full at every load factor, on any rank; the fraction of such folds that acts.
  [[nodiscard]] bool has_constant_folds() const;
  void ease_folds(double fraction) {
    eased_ = fraction;
    fresh_ = true;
  }
  [[nodiscard]] bool has_temperatures() const { return !input_.temperatures.empty(); }
  /// By how much the natural curvature of triangle t, of this rank, is that of the rest shape less [1/m].
  [[nodiscard]] Vec3 curvature_change(Index t) const;
  /// Squared size of the nodal forces that hold the rest shape against its natural states, on this rank [N^2].
  [[nodiscard]] double squared_force() const { return squared_force_; }
  /// Largest strain by which they grow on this rank per unit of the load factor, that of bending over a cell.
  [[nodiscard]] double growth() const;
  /// Change and difference of temperature of it [K].
  [[nodiscard]] std::pair<double, double> temperature(Index t) const;

 private:
  struct Item {
    Index triangle, membrane, bending, angles;  ///< no_index: none
    bool owned;
    Vec3 place, rest;                       ///< centroid at the start [m], kappa0 [1/m]
    double change = 0.0, difference = 0.0;  ///< [K]
    Vec3 bent = Vec3::Zero();               ///< kappa' as the operator finds it [1/m]
    Mat3 projector = Mat3::Identity();      ///< of free sides
  };

  /// A joint of this rank on a hinge.
  struct Fold {
    Index joint;
    std::size_t hinge;
    Vec3 place;     ///< middle of the edge at the start [m]
    double height;  ///< of the cells there [m]
  };

  void take(Item& item, double time, double load_factor);
  /// Change and difference of temperature [K].
  [[nodiscard]] std::pair<double, double> temperature_of(const Item& item, double time, double load_factor) const;
  void add_joints();
  void add_hinges();
  /// phi [rad].
  [[nodiscard]] double fold_of(const Fold& fold, double time, double load_factor) const;
  void take_folds(double time, double load_factor);
  void take_joint(const Item& item, double time, double load_factor);
  [[nodiscard]] bool covers(std::size_t temperature, Index t) const;

  const Discretisation* on_;
  NaturalInput input_;
  Kernels kernels_;
  std::vector<std::vector<char>> covered_;  ///< of each temperature, by triangle; empty: all
  std::vector<Item> items_, at_joints_;     ///< triangles at joints once more: those of other ranks, too
  std::vector<Fold> folds_;
  std::vector<Index> item_of_;  ///< by triangle
  bool changes_ = false, fresh_ = true;
  double squared_force_ = 0.0, eased_ = 1.0;
  double time_ = 0.0, load_factor_ = 0.0;  ///< in force
};

}  // namespace voile::system
