// Supports and loads as the user states them: by group name, in SI units.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::system {

struct Support {
  enum class Kind {
    displacement,  ///< the named components of every vertex of the group follow `value` x load factor
    hinged,        ///< all three components fixed (to `value`), the edge free to rotate
    clamped,       ///< as hinged, and the slope across the group's boundary edges is held
    sliding,       ///< the slope across the group's boundary edges is held, and the named components, if any
    symmetry       ///< no displacement along `normal`, mirrored slope across the group's boundary edges
  };
  std::string
      group;  ///< point, curve or surface group; clamped: curve or surface (all of it held); symmetry, sliding: curve
  Kind kind = Kind::displacement;
  std::array<bool, 3> components{false, false, false};  ///< displacement, sliding: which of x, y, z
  Vec3 value = Vec3::Zero();                            ///< displacement at load factor 1, in the axes below [m]
  /// displacement, sliding: own axes x, y (made square to x) and z = x cross y; or x radial, y circumferential and z along
  /// the axis of a cylinder, at each vertex's place at the start. Absent: the global axes.
  std::optional<Vec3> x_axis, y_axis, cylinder_axis;
  Vec3 cylinder_centre = Vec3::Zero();  ///< a point on that axis [m]
  std::optional<Vec3> normal;           ///< symmetry: normal of the plane; absent: found from the group
  double release = std::numeric_limits<double>::infinity();  ///< time at which it releases [s]
  /// Displacement [m] of the vertex that starts at X at time t [s], added to `value`; empty: none.
  std::function<Vec3(const Vec3& rest, double time)> motion;
  std::string motion_text;  ///< what tells it from other motions; empty: it is like no other
  /// Its displacement is given vertex by vertex (BoundaryConditions::set_displacement) instead of `motion`.
  bool follows = false;
  /// clamped: the rotation within `motion` at time t, with which the slope turns; empty: none.
  std::function<Mat3(double time)> rotation;
};

/// Where a rigid group is as a stage begins: its keys count from there.
struct RigidPlace {
  Vec3 displacement = Vec3::Zero();                 ///< of the reference point since the start of the run [m]
  Eigen::Vector4d turn = Eigen::Vector4d::UnitX();  ///< unit quaternion, q_0 first: tells turns of up to 4 pi apart
  std::optional<double> time;  ///< at which `motion` and `angle` are nothing [s]; absent: they count from the start
};

/// A group whose vertices move as one rigid body (rigid_bodies.hpp), held and loaded at its reference point.
struct RigidGroup {
  enum class Turn {
    free,
    held,   ///< it does not turn
    about,  ///< about `axis` only: freely, or by `angle`
  };
  std::string group;                              ///< physical point, curve or surface with at least three vertices
  std::optional<Vec3> point;                      ///< reference point; absent: the centre of its length or area [m]
  bool slope = true;                              ///< the slope across boundary edges of a curve turns with the body
  std::array<bool, 3> held{false, false, false};  ///< components of the reference point that are prescribed
  std::function<Vec3(double time)> motion;        ///< their displacement [m]; empty: none
  Turn turn = Turn::free;
  std::optional<Vec3> axis;                  ///< through the reference point
  std::function<double(double time)> angle;  ///< prescribed about the axis [rad]; empty: free, or held
  Vec3 force = Vec3::Zero();                 ///< at the reference point, dead, at load factor 1 [N]
  Vec3 moment = Vec3::Zero();                ///< about it, of a fixed direction, at load factor 1 [N m]
  bool constant = false;                     ///< force and moment are these at any load factor
  double mass = 0.0;                         ///< at the reference point [kg]
  RigidPlace place;
};

/// Two boundary curves along which a periodic sheet continues (ties.hpp).
struct PeriodicPair {
  std::string from, to;                        ///< curves
  std::array<bool, 3> held{true, true, true};  ///< components of the difference that are prescribed
  Vec3 difference = Vec3::Zero();              ///< displacement of `to` less that of `from`, at load factor 1 [m]
  std::function<Vec3(double time)> motion;     ///< added to it [m]; empty: none
  Vec3 force = Vec3::Zero();                   ///< on the difference where it is free, dead, at load factor 1 [N]
  bool constant = false;                       ///< force is this at any load factor
};

struct Load {
  enum class Kind {
    point,              ///< force on every vertex of the group [N], dead
    line,               ///< force per rest length along a curve group [N/m], dead
    pressure,           ///< dead surface traction per rest area along the normal at the start [Pa], surface group
    follower_pressure,  ///< pressure along the current normal [Pa], positive along the triangle's normal, surface group
    area,               ///< dead force per rest area [N/m^2], surface group
    gravity,            ///< acceleration [m/s^2] acting on the areal density, whole model or surface group
    follower_moment,    ///< moment per rest length about the boundary edge [N], curve group, turns with the shell
    gas                 ///< pressure of a gas that the surface group encloses [Pa], see gas.hpp
  };
  Kind kind = Kind::point;
  std::string group;           ///< empty: the whole surface (gravity, area, pressure kinds)
  Vec3 vector = Vec3::Zero();  ///< point, line, area, gravity, at load factor 1
  double magnitude = 0.0;      ///< pressure, follower_pressure, follower_moment, gas, at load factor 1
  bool constant = false;       ///< true: acts in full at every load factor (e.g. dead weight)
  /// Factor at time t [s] instead of the load factor; empty: none. The text it was written as, for the echo of a case.
  std::function<double(double time)> history;
  std::string history_text;
  /// Factor at a place at the start, for what is spread over a curve or surface; empty: 1. And its text.
  std::function<double(const Vec3& start)> distribution;
  std::string distribution_text;
  // gas
  double ambient = 101325.0;  ///< pressure outside, absolute [Pa]
  double exponent = 1.0;      ///< n of p V^n
  double added_volume = 0.0;  ///< of the gas, besides what the surface encloses [m^3]
  double leak_area = 0.0;     ///< of an orifice, discharge coefficient included [m^2]
  double density = 1.2;       ///< of the gas at ambient pressure [kg/m^3]
  std::optional<Vec3> apex;   ///< of the caps over holes; absent: the mean of each rim [m]
};

/// Of place [m] and time [s], or the load factor in its place.
struct Field {
  std::string text;  ///< as it was written; empty: none
  std::function<double(const Vec3& start, double time)> value;
  bool in_time = false;  ///< it is an expression of the time
  bool resumes = false;  ///< it is held at a time, and goes on with the next motion
};

/// Change of the temperature from that at which the sheet has its rest shape [K].
struct Temperature {
  std::string group;      ///< surface; empty: the whole surface
  Field change;           ///< mean over the thickness
  Field difference;       ///< top, where the normal points to, less bottom
  bool constant = false;  ///< true: acts in full at every load factor
};
/// A line along which the sheet folds like a hinge with a spring.
struct Hinge {
  std::string group;       ///< curve
  double stiffness = 0.0;  ///< moment per length of the line and angle, k [N m / (m rad)]
  Field angle;             ///< by how much the fold without moment changes [degree]; closes where normals point to
  bool constant = false;   ///< true: acts in full at every load factor
};

/// What gives the sheet another shape without stress than that at rest. Where groups overlap changes add up.
struct NaturalInput {
  std::vector<Temperature> temperatures;
  std::vector<Hinge> hinges;
  bool by_load = false;      ///< the load factor is taken for the time
  bool first_order = false;  ///< natural states are linear in temperature and strain
};

/// Mass at vertices, besides that of the sheet. It has weight where gravity acts on the whole model or on its group.
struct PointMass {
  std::string group;
  double mass = 0.0;  ///< of each vertex of the group [kg]
};

/// Linear springs from vertices to where they start, or between two vertices.
struct Spring {
  enum class Kind {
    point,  ///< on every vertex of the group [N/m]
    line,   ///< per rest length of a curve group [N/m^2]
    area,   ///< per rest area, an elastic foundation [N/m^3]
    pair,   ///< between every vertex of the group and the nearest one of `to` [N/m]
    band    ///< along the edges of a curve group, only pulls [N]: force per strain
  };
  Kind kind = Kind::point;
  std::string group;  ///< empty: the whole surface (area)
  double stiffness = 0.0;
  std::optional<Vec3> direction;  ///< acts along this direction only; absent: in all; none for pair
  std::string to = {};            ///< pair: the other group
  /// Without force [m]. pair: NaN: the distance at the start; band: of the whole curve, NaN: its length at rest.
  double length = std::numeric_limits<double>::quiet_NaN();
  double force = std::numeric_limits<double>::quiet_NaN();  ///< band: at its length at rest [N]; NaN: `length` gives it
  /// band: time in which it gets from its length at rest to `length` [s]; NaN: 0.1 where it first acts after sewing, else 0.
  double rise = std::numeric_limits<double>::quiet_NaN();
  double start = -std::numeric_limits<double>::infinity();  ///< band: from then on [s]
};

/// Vertices held to an obstacle's surface by springs or exactly, see attachments.hpp.
struct Attachment {
  int number = 0;                                               ///< unique among those of a case
  std::vector<std::string> groups;                              ///< points, curves or surfaces
  std::string obstacle;                                         ///< that has triangles
  double stiffness = std::numeric_limits<double>::quiet_NaN();  ///< NaN: `usual`
  /// At vertices of points [N/m], per rest length of curves [N/m^2], area of surfaces [N/m^3].
  std::array<double, 3> usual{1e4, 1e4, 1e4};
  bool hard = false;  ///< they are where the surface takes them, as supports hold, instead of springs
  double gap = std::numeric_limits<double>::quiet_NaN();     ///< to the surface [m]; NaN: what it is at the start
  double release = std::numeric_limits<double>::infinity();  ///< time at which it releases [s]
};

/// Seams that are pulled together: each pair of vertices by a spring that only pulls and gets shorter in time,
///   L(t) = max(0, |X_b - X_a| - speed (t - start))
struct Sewing {
  std::vector<std::string> seams;  ///< names, or "all"; empty: none
  double stiffness = 1e5;          ///< per rest length of the seam [N/m^2]
  double speed = 0.5;              ///< at which the springs get shorter [m/s]
  double force = 1e3;              ///< largest until no spring has a length any more, per rest length of the seam [N/m]
  double start = 0.0;              ///< [s]
  double most_force = 0.0;         ///< to which it rises from then on, if that is more [N/m]
  /// Seams that close from their beginning on, as by a zipper's slider.
  struct Zip {
    std::string seam;    ///< name; a `*` of it stands for any text
    double speed = 0.0;  ///< of the slider along the seam [m/s]
  };
  std::vector<Zip> zips{};
};

}  // namespace voile::system
