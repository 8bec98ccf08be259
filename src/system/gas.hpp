// A gas in a closed volume: pressure that falls as the volume grows.
//
// Symbols   V, V_0   volume now and at the start: under the sheet, caps over its holes, and rigid space besides it   [m^3]
//           p_a      ambient pressure, absolute;  P  excess at load factor 1 if the volume is V_0                     [Pa]
//           s        the load's factor;  n  exponent: 1 at constant temperature, 1.4 without exchange of heat (air)
//           m        fraction of the gas that is left, 1 unless it leaks (gas_leak.hpp); not changed by u within a step
//   p(V) = (p_a + s P) (m V_0/V)^n,     E(V) = -integral from V_0 to V of (p - p_a) dV
//   dE/da = -(p - p_a) g,  g = dV/da;    d2E/da2 = -(p - p_a) d2V/da2 + (n p/V) g g^T
// The last part couples all vertices: it is kept apart (low_rank.hpp). A hole is closed by triangles from the mean c of its
// rim's m vertices to its edges (a, b); with A = sum of a x b its volume is c.A/6, which couples them too:
//   d2(c.A)/da2 = (part at constant c) + sum over the axes of (dc_k dA_k^T + dA_k dc_k^T)
// Source: T. Rumpel & K. Schweizerhof, Int. J. Numer. Methods Eng. 56 (2003) 211-238.
#pragma once

#include <memory>
#include <vector>

#include "block_matrix.hpp"
#include "discretisation.hpp"
#include "energy/term.hpp"
#include "gas_leak.hpp"
#include "low_rank.hpp"

namespace voile::energy {
class VolumeTerm;
}  // namespace voile::energy

namespace voile::system {

template <class Kernel>
class ElementTerm;

/// Volume, excess pressure p - p_a and energy of a gas.
struct GasState {
  double volume = 0.0;    ///< [m^3]
  double pressure = 0.0;  ///< [Pa]
  double energy = 0.0;    ///< [J]
};

/// How much of a gas is left, and what its leak has taken of the work that it could do.
struct GasContent {
  double fraction = 1.0;
  double loss = 0.0;  ///< [J]
};

class Gas {
 public:
  /// Of a load of kind gas; `on` must outlive it. Throws UserError. Not collective.
  Gas(const Discretisation& on, const Load& load);
  ~Gas();
  Gas(Gas&&) noexcept;
  Gas& operator=(Gas&&) noexcept;

  /// s of all later evaluations.
  void set_factor(double factor) { factor_ = factor; }
  [[nodiscard]] bool leaks() const { return leak_area_ > 0.0; }
  /// In the last accepted state.
  [[nodiscard]] const GasContent& content() const { return content_; }
  void restore(const GasContent& content);
  /// From this time on it leaks, beginning with this configuration. Collective.
  void begin_leak(const energy::Configuration& c, double time);
  /// Time of all later evaluations: by then some of the gas has leaked from the volume of the accepted state. Not collective.
  void set_time(double time);
  /// This configuration is accepted, at this time. Collective.
  void end_step(const energy::Configuration& c, double time);
  /// Collective.
  [[nodiscard]] GasState at(const energy::Configuration& c) const;
  /// Adds -(p - p_a) dV/dx to the gradient at local points. Collective. [N]
  void add_forces(const energy::Configuration& c, std::vector<Vec3>& points) const;
  /// Adds (p - p_a) g to f; `scratch` has one entry per local point. Collective. [N]
  void add_force(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const;
  /// Adds dp/ds g to f. Collective. [N]
  void add_direction(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const;
  /// Adds the sparse part of the tangent to its open values, and the rest to `change`. Collective.
  void add_blocks(const energy::Configuration& c, const BlockMatrix& tangent, int pattern,
                  const BlockMatrix::Values& values, std::vector<Vec3>& scratch, LowRankChange& change) const;

 private:
  struct Rim {
    std::vector<Index> owned;   ///< local vertices
    std::vector<Index> points;  ///< those and the others that add to rows of this rank, as parts of rigid bodies
    double count = 0.0;         ///< m
    bool held = true;           ///< no vertex of it moves
    Vec3 centre = Vec3::Zero(), area = Vec3::Zero();
  };
  [[nodiscard]] double volume(const energy::Configuration& c) const;
  /// p_a + s P.
  [[nodiscard]] double filled() const { return ambient_ + factor_ * excess_; }
  /// Of what is left, in V_0.
  [[nodiscard]] double reference() const;
  [[nodiscard]] LeakyGas leaky() const { return {ambient_, filled(), exponent_, start_, leak_area_, density_}; }
  /// (V_0/V)^n.
  [[nodiscard]] double compression(double volume) const;
  void add_gradient(double scale, const energy::Configuration& c, std::vector<Vec3>& points) const;
  void add_gradient(double scale, const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const;
  void find_centres(const energy::Configuration& c) const;
  void add_rim_columns(const Rim& rim, int number, const energy::Configuration& c, double weight,
                       std::vector<Vec3>& scratch, LowRankChange& change) const;

  const Discretisation* on_;
  double ambient_, excess_, exponent_, added_, start_ = 0.0, factor_ = 0.0;
  double leak_area_, density_, now_ = 1.0;  ///< fraction at the time in force
  GasContent content_;                      ///< and in the accepted state, of which these are time and volume
  double accepted_time_ = 0.0, accepted_volume_ = 0.0;
  bool leaking_ = false;
  Vec3 origin_;
  std::unique_ptr<ElementTerm<energy::VolumeTerm>> term_;
  mutable std::vector<Rim> rims_;
};

}  // namespace voile::system
