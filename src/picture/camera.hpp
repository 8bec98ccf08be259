// Where a picture is taken from.
//
// Symbols   r, u, b   unit vectors to the right, up, and back towards the viewer
//           tan_l, tan_r, tan_t, tan_b   slopes of the sides of the picture to the left, right, top and bottom
// A point p is at ((p - eye).r, (p - eye).u) / -((p - eye).b).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "image.hpp"

namespace voile::picture {

struct Camera {
  Vec3 eye = Vec3::UnitZ(), right = Vec3::UnitX(), up = Vec3::UnitY(), back = Vec3::UnitZ();
  double tan_x = 0.3, tan_y = 0.3;  ///< slopes of the right and upper side; the eye looks at the middle

  /// Column and row (fractions of the picture, from the upper left) and depth in front of the eye [m].
  [[nodiscard]] Vec3 project(const Vec3& point) const;
  /// Direction through a place in the picture; not of unit length.
  [[nodiscard]] Vec3 ray(double column, double row) const;
};

/// Where the camera is asked to be.
struct View {
  std::string name;                 ///< shown where there are several
  Vec3 back = Vec3(1, -2, 1);       ///< from what is looked at towards the viewer
  std::optional<Vec3> eye, target;  ///< a place given [m]; without `target` it looks at the middle
};

/// Part of a picture that is to hold the motion, as fractions of its width and height.
struct Frame {
  double left = 0.0, right = 1.0, top = 0.0, bottom = 1.0;
};

/// "front", "back", "left", "right", "top", "bottom", "three-quarter", or "AZIMUTH,ELEVATION" in degrees: front looks along +y for up = z.
/// Throws UserError with the names there are.
[[nodiscard]] View named_view(const std::string& name, const Vec3& up);

/// The camera from which all points fill the frame as far as possible, whatever their order and number.
/// `aspect`: width over height.
[[nodiscard]] Camera fit_camera(const View& view, const Vec3& up, const std::vector<Vec3>& points, double aspect,
                                const Frame& frame);

}  // namespace voile::picture
