// Friction inside a fabric: yarns that bend rub, and keep a moment of their own.
//
// Symbols   k       curvature of a triangle in its yarn axes: along warp, along weft, twist (k11, k22, 2 k12)      [1/m]
//           p       slip of a slider, one for each of them                                                        [1/m]
//           D_s     stiffness of the spring before the slider [N m];  HB its limit [N];  A rest area              [m^2]
//           B', K_s, kappa0, n   operator, bend at the start, rest curvature, current normal, all turned to the yarn axes
//   k_r = n.(K_s,r + sum_i B'_ri u_i) - kappa0_r
//   W   = A sum_r min_p [ D_s/2 (k_r - p)^2 + HB |p - p_n| ],   p_n at the end of the step before
// which is Huber's function of k_r - p_n:  with t = D_s (k_r - p_n)
//   |t| <= HB (sticks):  W_r = t^2 / (2 D_s),              m_r = t,          dm_r/dk_r = D_s
//   |t| >  HB (slips):   W_r = HB (|t| - HB/2) / D_s,      m_r = HB sign t,  dm_r/dk_r = 0
// Of W, m^2/(2 D_s) is stored and HB |p - p_n| is lost. Several sliders side by side (Prandtl and Ishlinskii) make a loop round.
// A triangle bends by its slopes even where bending is by angles (angle_bending.hpp); beside folds at rest, where slopes take motion
// in the plane for bending, there is no friction.
// Source: any textbook on plasticity with a spring and a slider (Jenkin's element), e.g. Simo & Hughes, Computational Inelasticity
// (1998), chapter 1; for fabrics Lahey & Heppler, J. Appl. Mech. 71 (2004). Theory: docs/theory/yarn-friction.md.
#pragma once

#include <vector>

#include "batches.hpp"
#include "bending.hpp"
#include "sheet.hpp"
#include "term.hpp"

namespace voile::energy {

class YarnFrictionTerm {
 public:
  static constexpr int directions = 3;

  YarnFrictionTerm() = default;
  /// With as many sliders as the material that has most.
  explicit YarnFrictionTerm(const Sheet& sheet);
  /// Whether a material has any friction.
  [[nodiscard]] static bool is_needed(const Sheet& sheet);
  /// Whether triangle t is to have an element. Not collective.
  [[nodiscard]] static bool acts_on(const Sheet& sheet, Index t);

  /// `local`: the points of `bending`, which is that of triangle t, in local numbering.
  void add(const Sheet& sheet, Index t, const BendingElement& bending, const std::vector<Index>& local, bool owned);

  [[nodiscard]] Index size() const { return batches_.size(); }
  [[nodiscard]] const Index* stencil(Index e) const { return batches_.stencil(e); }
  [[nodiscard]] int stencil_size(Index e) const { return batches_.stencil_size(e); }
  [[nodiscard]] bool owned(Index e) const { return batches_.owned(e); }
  [[nodiscard]] Index triangle(Index e) const { return triangles_[e]; }
  /// places_of(points, count, depends_on) gives the places of the blocks of pairs i <= j; `none` takes what goes nowhere.
  template <class PlacesOf>
  void locate(PlacesOf&& places_of, Index none) {
    for (Index e = 0; e < size(); ++e)
      batches_.set_slots(e, places_of(stencil(e), stencil_size(e), [](int) { return true; }), none);
  }

  /// All elements: forces added to those of the local points [N], energy W of the owned ones [J], blocks added at the slots [N/m].
  double add_gradients(const Configuration& c, Vec3* force) const;
  void add_tangents(const Configuration& c, double* blocks) const;
  /// Another one after the sliders have moved.
  [[nodiscard]] long version() const { return version_; }
  /// The kernels of another instruction set.
  void use(const ElementKernels& kernels) { kernels_ = &kernels; }

  /// Part of W at c that is lost, of the owned elements [J].
  [[nodiscard]] double lost(const Configuration& c) const;
  /// The step ends at c: sliders stay where they have slipped to.
  void end_step(const Configuration& c);

  /// Numbers of the sliders of an element: `directions` for each slider.
  [[nodiscard]] int numbers() const { return directions * sliders_per_direction_; }
  /// Slips of element e; and back [1/m].
  [[nodiscard]] std::vector<double> slips(Index e) const;
  void set_slips(Index e, const double* slips);
  /// k of element e in its yarn axes [1/m], and the moment of all its sliders [N].
  [[nodiscard]] Vec3 curvature(Index e, const Configuration& c) const;
  [[nodiscard]] Vec3 moment(Index e, const Configuration& c) const;

 private:
  enum Number { slip, stiffness, limit, compliance };
  [[nodiscard]] YarnBatch view(std::size_t batch) const;
  [[nodiscard]] std::size_t line_of(Index e, int slider, int direction, Number which) const;
  [[nodiscard]] double& number(Index e, int slider, int direction, Number which);
  [[nodiscard]] double number(Index e, int slider, int direction, Number which) const;

  long version_ = 0;
  int sliders_per_direction_ = 0;
  const ElementKernels* kernels_ = &batch_kernels();
  Batches batches_{yarn_fields::weights, directions};
  std::vector<Line> sliders_;  ///< of each batch
  std::vector<Index> triangles_;
  std::vector<double> area_;
};

}  // namespace voile::energy
