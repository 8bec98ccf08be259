// How cloth looks: its weave, sheen along the threads, and a print of a given size that shows how it is stretched.
//
// Symbols   a, l   flat coordinates of the sheet before it is deformed: across the warp and along it [m]
#pragma once

#include <optional>
#include <string>

#include "weave.hpp"

namespace voile::picture {

enum class Print { none, stripes, checks };

/// What is asked for.
struct ClothChoice {
  std::optional<Weave> weave;
  double spacing = 0.0;  ///< of neighbouring threads or wales [m]
  Print print = Print::none;
  double width = 0.0;  ///< of a stripe, or the side of a check [m]
  [[nodiscard]] bool any() const { return weave || print != Print::none; }
  /// With lengths in a unit of so many metres.
  [[nodiscard]] ClothChoice in_unit(double metres) const { return {weave, spacing / metres, print, width / metres}; }
};

/// `cloth`: "plain", "twill" or "knit", with ":SPACING" if it is not usual; `print`: "stripes:WIDTH", "checks:WIDTH". Lengths
/// have a unit, mm, cm or m, e.g. 10mm. Empty texts ask for nothing. Throws UserError with what is right.
[[nodiscard]] ClothChoice parse_cloth(const std::string& cloth, const std::string& print);

/// Fraction of a pixel that the second colour of a print covers: stripes run along the warp, the one that begins at a = 0 has
/// the second colour; checks have it where just one of two crossing sets of stripes has. `u`, `v`: the pixel's sides. [m]
[[nodiscard]] float second_colour(Print print, double width, const Vec2f& place, const Vec2f& u, const Vec2f& v);

/// Where a ray meets cloth.
struct ClothHit {
  bool is_front = true;
  Vec2f place, u, v;  ///< flat coordinates, and those of the pixel's sides [m]
  /// Unit vectors: across the warp and along it, the normal on the viewer's side, to the viewer and to the lamp. No threads:
  /// across is zero.
  Vec3f across{0, 0, 0}, along{0, 0, 0}, normal, to_eye, to_lamp;
};

/// What is printed and woven. Immutable; may be asked by several threads at once.
class Cloth {
 public:
  explicit Cloth(const ClothChoice& choice);
  /// Colour of the cloth there, of a smooth white light; `front`, `back`: the colours of its sides.
  [[nodiscard]] Rgb colour(const ClothHit& hit, const Rgb& front, const Rgb& back) const;
  [[nodiscard]] const ClothChoice& choice() const { return choice_; }

 private:
  [[nodiscard]] Rgb woven(const ClothHit& hit, const Rgb& colour) const;

  ClothChoice choice_;
  std::optional<WeaveTile> front_, back_;
  Vec2f repeat_{1.0F, 1.0F};  ///< of the weave [m]
};

/// Second colour of prints.
[[nodiscard]] Rgb print_colour();

}  // namespace voile::picture
