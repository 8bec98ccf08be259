// The surface of a figure or form as triangles, and how a figure moves.
//
// Symbols   X   position at rest [m]     w_b(X)   how far X follows joint b, 0 to 1, smooth in X     theta_b(t)   its angle
//   x(X, t) = T(t) prod_b R_b(w_b(X) theta_b(t)) X     R_b: turn about joint b, from the pelvis outwards;  T: of the pelvis
// Motions start at rest: every theta_b has no velocity at t = 0 and a continuous acceleration.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "geometry/primitive_surface.hpp"
#include "shape.hpp"

namespace voile::manikin {

/// Girths that a tape measures [m].
struct Girths {
  double bust, waist, hip;
};

struct Figure {
  Shape shape;
  geometry::TriangleSoup surface;
  Girths girths;  ///< of the surface
};

/// Meshes a shape whose girths come out as asked for. `size`: edges [m]. Not collective.
/// Throws UserError if the size is out of bounds or the measurements give no surface that is closed, in one piece,
/// without handles and without intersections.
[[nodiscard]] Figure make_figure(const Measurements& m, Kind kind, double size);

/// Around the piece of the surface's section at height z that winds around the z axis.
[[nodiscard]] double tape_girth(const geometry::TriangleSoup& surface, double z);

enum class Motion { walk, run, turn, lift, sit };

struct MotionOptions {
  Motion motion = Motion::walk;
  double seconds = 3.0;
  double frames_per_second = 50.0;
  double speed = 1.0;    ///< walk, run: along -y, once under way [m/s]
  double cadence = 1.8;  ///< walk, run: steps per second
  double angle =
      3.14159265;  ///< turn: about the vertical; lift: of the left arm, outwards [rad], in all the time there is
};

/// Speed, cadence and angle of somebody with such legs [m] who says nothing of them.
[[nodiscard]] MotionOptions usual_motion(Motion motion, double inseam = 0.80);

/// Positions in every frame, the first at rest. `moving`: those of a Kind::figure, a form turns as a whole.
/// Throws UserError for options out of bounds.
[[nodiscard]] std::vector<std::vector<Vec3>> frames(const Figure& figure, const MotionOptions& options);

}  // namespace voile::manikin
