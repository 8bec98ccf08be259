// The shape of a shop-window figure or a tailor's form from a few measurements, as a function that is negative inside.
//
// Axes: z up from the floor, the body looks along -y, its left is +x.
//
// A trunk of elliptic sections, limbs of round ones and a few ellipsoids are joined by the smooth minimum
//   smin(a, b; k) = min(a, b) - k h^2/4,   h = max(0, 1 - |a - b|/k)
// so that the surface has a tangent plane everywhere.
#pragma once

#include <array>
#include <vector>

#include "base/types.hpp"

namespace voile::manikin {

enum class Person { woman, man, child };

/// [m]; the proportions of what they leave open are those of shop-window figures.
struct Measurements {
  double height = 1.74;
  double bust = 0.88, waist = 0.68, hip = 0.94;  ///< girths by a tape, which spans hollows
  double inseam = 0.80;                          ///< from the floor to the crotch
  double arm_angle = 0.44;                       ///< of the arms from the vertical [rad]
  Person person = Person::woman;
};

/// What somebody so tall usually measures; of a child, whose clothes are sized by it, by public size charts. [m]
[[nodiscard]] Measurements usual_measurements(Person person, double height);
/// The height of a figure of which nothing is said. [m]
[[nodiscard]] double usual_height(Person person);

/// Throws UserError that names what is out of bounds, or what does not go together.
void check(const Measurements& m);

enum class Kind { figure, form };  ///< with head, arms and legs, or without, on a stand

/// Heights that follow from the measurements [m].
struct Levels {
  explicit Levels(const Measurements& m);
  double crotch, hip, waist, under_bust, bust, armpit, shoulder, neck, chin, top;
};

/// Positions that limbs turn about, at rest, of the left side; the right is its mirror image in x [m].
struct Joints {
  Vec3 hip, knee, ankle, shoulder, elbow, wrist;
};

/// A chain of round cones.
class Limb {
 public:
  Limb() = default;
  /// `stretch`: how much deeper (y) than wide sections are.
  Limb(std::vector<Vec3> points, std::vector<double> radii, double stretch);
  /// About the distance, negative inside [m].
  [[nodiscard]] double distance(const Vec3& p) const;

 private:
  std::vector<Vec3> points_;
  std::vector<double> radii_;
  double stretch_ = 1.0;
};

class Shape {
 public:
  /// With girths that are about those asked for; tuned() makes them so.
  Shape(const Measurements& m, Kind kind);
  /// About the distance from the surface, negative inside [m].
  [[nodiscard]] double operator()(const Vec3& p) const;
  /// The same without arms and stand.
  [[nodiscard]] double body(const Vec3& p) const;
  /// Of the arm on the side of p.
  [[nodiscard]] double arm(const Vec3& p) const;
  [[nodiscard]] const Joints& joints() const { return joints_; }
  [[nodiscard]] const Levels& levels() const { return levels_; }
  [[nodiscard]] const Measurements& measurements() const { return m_; }
  [[nodiscard]] Kind kind() const { return kind_; }

  /// With trunk sections scaled until the tape measures bust, waist and hip.
  [[nodiscard]] static Shape tuned(const Measurements& m, Kind kind);

 private:
  struct Section {
    double width, depth, centre;  ///< half axes along x and y, y of the middle [m]
  };
  struct Ellipsoid {
    Vec3 centre, axes;
  };
  void build();
  [[nodiscard]] double clear_shoulder(double trunk) const;
  void build_legs();
  void build_arms();
  [[nodiscard]] Section section(double z) const;
  [[nodiscard]] double trunk(const Vec3& p) const;
  [[nodiscard]] double head(const Vec3& p) const;
  [[nodiscard]] double stand(const Vec3& p) const;
  /// How far the body reaches from its axis in a direction, at a height [m].
  [[nodiscard]] double reach(const Vec2& direction, double z) const;
  /// Length of a tape around the section of the body at a height [m].
  [[nodiscard]] double tape(double z) const;

  Measurements m_;
  Kind kind_;
  Levels levels_;
  Joints joints_;
  std::array<double, 3> scale_{1.0, 1.0, 1.0};  ///< of sections at bust, waist, hip
  std::vector<double> heights_;
  std::vector<std::array<double, 3>> sections_;  ///< as Section, at these heights
  Limb leg_, foot_, arm_, hand_;
  Ellipsoid breast_, seat_;
};

/// Perimeter of the convex hull: what a tape measures around points in a plane.
[[nodiscard]] double hull_perimeter(std::vector<Vec2> points);

}  // namespace voile::manikin
