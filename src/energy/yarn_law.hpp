// Yarns of a fabric in its plane: tension that stiffens, shear that stiffens and rubs.
//
// Symbols   E       Green strain in yarn axes: along warp, along weft, shear (E11, E22, 2 E12 = cos of the angle between them)
//           A       membrane stiffness where the strain is zero                                                [N/m]
//           e_j, c_j  strain of a knot; from there on the tangent grows by c_j per strain                       [N/m]
//           p       slip of the shear slider;  G_s stiffness of its spring [N/m];  H(p) = H0 + h|p| its limit   [N/m]
//   w(E) = E.A E/2 + sum_r sum_j c_rj/6 <|E_r| - e_rj>^3       (of warp and weft E_r itself: compression stays linear)
// so that forces are piecewise quadratic with continuous tangents. Friction adds the increment
//   min_p [ G_s/2 (E_12 - p)^2 + |Phi(p) - Phi(p_n)| ],  Phi(p) = H0 p + h p|p|/2,  p_n at the end of the step before,
// with t = G_s (E_12 - p_n), s = sign t:
//   |t| <= H(p_n) (sticks):  force t,            tangent G_s
//   else (slips):  p = (G_s E_12 - s H0)/(G_s + s q h), q the sign of its numerator;
//                  force G_s (E_12 - p) = s H(p),  tangent G_s s q h/(G_s + s q h)
// The last is negative where the slip goes back to zero; G_s > h makes p unique, and the shear stiffness has to carry it.
// Theory and figures of KES: docs/theory/yarn-friction.md.
#pragma once

#include <array>
#include <vector>

#include "base/types.hpp"

namespace voile::energy {

struct YarnLaw {
  struct Knot {
    double strain = 0.0, bend = 0.0;  ///< e_j, c_j [N/m]
  };
  double warp_angle = 0.0;                   ///< from material axis 1 to the warp [rad]
  std::array<std::vector<Knot>, 3> knots{};  ///< along warp, along weft, in shear, by ascending strain
  double stiffness = 0.0;                    ///< G_s [N/m]; 0: no friction
  double limit = 0.0, rise = 0.0;            ///< H0, h [N/m]
  /// T, which takes strains from the rest shape to those from the natural state, both in material axes, and the area of that over the
  /// area of the rest shape: natural_state.hpp.
  Mat3 natural = Mat3::Identity();
  double area = 1.0;

  [[nodiscard]] bool rubs() const { return stiffness > 0.0; }
  [[nodiscard]] bool any() const { return rubs() || !knots[0].empty() || !knots[1].empty() || !knots[2].empty(); }
};

/// A point of a measured curve: strain, and the force per width that is its energy's derivative by it.
struct YarnPoint {
  double strain, force;
};
/// A curve with its tangent where it begins.
struct YarnCurve {
  double tangent = 0.0;  ///< [N/m]
  std::vector<YarnLaw::Knot> knots{};
};
/// Through zero and all points, both ascending: Schumaker's quadratic spline, which keeps what rises rising. Beyond the last point it is
/// straight. Source: L. Schumaker, SIAM J. Numer. Anal. 20 (1983) 853-864; tangents at points are harmonic means of the slopes.
[[nodiscard]] YarnCurve yarn_curve(std::vector<YarnPoint> points);
/// Through zero and `end` with this area below it, which is less than that of the triangle: a tangent that is constant, grows in
/// proportion to the strain, and is constant again. Without a tangent at zero (0) it is that of force = b (exp(a strain) - 1).
/// `tangent` has to lie in tangents_of().
[[nodiscard]] YarnCurve yarn_curve(const YarnPoint& end, double area, double tangent);
struct Interval {
  double least, most;
};
/// Tangents at zero that such a curve can have [N/m].
[[nodiscard]] Interval tangents_of(const YarnPoint& end, double area);
/// Force of a curve [N/m].
[[nodiscard]] double force_of(const YarnCurve& curve, double strain);
/// Whether every strain costs energy: `membrane` A in yarn axes.
[[nodiscard]] bool is_stable(const Mat3& membrane, const YarnLaw& law);

/// Takes strains in material axes, from the rest shape, to those of the yarns.
[[nodiscard]] Mat3 yarn_axes(const YarnLaw& law);
/// What the knots add to A E, in material axes [N/m]; friction is left out.
[[nodiscard]] Vec3 added_force(const YarnLaw& law, const Vec3& strain);
/// What they add to A, likewise.
[[nodiscard]] Mat3 added_tangent(const YarnLaw& law, const Vec3& strain);

}  // namespace voile::energy
