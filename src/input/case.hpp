// The case file: what a user asks for, parsed strictly from TOML, in SI units.
//
// Every key is declared once, in case_keys.cpp, with its unit, default and meaning; parsing, the echo of the resolved
// case and docs/reference/case.md all come from that declaration.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis.hpp"
#include "base/types.hpp"
#include "energy/element_options.hpp"
#include "energy/material.hpp"
#include "formats/gmsh.hpp"
#include "solve/drape_options.hpp"
#include "solve/static_options.hpp"
#include "solve/time_options.hpp"
#include "system/conditions.hpp"
#include "system/contact_input.hpp"
#include "system/dynamics_options.hpp"
#include "unit_system.hpp"

namespace voile::input {

struct MeshSection {
  std::filesystem::path file;   ///< resolved relative to the case file
  std::filesystem::path start;  ///< the same mesh in the shape it starts from, resolved alike; empty: that of `file`
  formats::MeshOptions options;
};

/// A point of the scene: its coordinates, or a landmark.
struct PointInput {
  Vec3 at = Vec3::Zero();  ///< [m]
  std::string landmark;    ///< "OBSTACLE.NAME", instead of them; empty: none
};

/// Pieces of a pattern file, and where they begin.
struct PanelSection {
  std::filesystem::path file;  ///< GarmentCode .json, .svg, .dxf, .geo or .obj, resolved relative to the case file
  std::map<std::string, double> parameters;  ///< of a .geo
  std::vector<std::string> pieces;           ///< of the file; empty: all
  std::string nest_size;                     ///< of a DXF that has several; empty: all
  std::string name;                          ///< instead of the only piece's own; empty: that
  double unit = 0.0;                         ///< length of the file's unit [m]; 0: as the file says
  double texture_unit = 0.0;                 ///< of the texture coordinates of an .obj [m]; 0: as its vertices say
  double size = 0.02;                        ///< of cells [m]
  bool mirror = false;                       ///< x -> -x in the piece
  std::string unfold;                        ///< edge across which halves unfold, by number or label; empty: none
  std::vector<double> grain;  ///< direction of the grain line as the file draws the piece; empty: as the file says
  bool stitches = true;       ///< those of the file are taken
  enum class Euler { zyx, xyz };
  Euler euler = Euler::zyx;  ///< order of the file's rotations: R = Rz Ry Rx or Rx Ry Rz
  formats::Placement placement{.up_axis = formats::Placement::UpAxis::y};
  PointInput origin;   ///< where `placement` begins
  std::string anchor;  ///< "PIECE@POINT": the point that comes there instead of the file's origin; empty: that
  /// Of the cylinder or cone they are wrapped on: direction of its axis, or a second point on it; neither: flat.
  std::optional<Vec3> wrap_axis;
  std::optional<PointInput> wrap_end;
  PointInput wrap_point;  ///< a point on it
  enum class Along { as_placed, x, y, minus_x, minus_y };
  Along wrap_along = Along::as_placed;  ///< direction in the piece that is turned into that of the axis
  double wrap_shift = 0.0;              ///< of the pieces along the axis [m]
  double wrap_radius = 0.0;             ///< there [m]; 0: the distance of each piece from the axis
  double wrap_angle = 0.0;              ///< half of the cone's, positive if it widens along the axis [rad]
  std::vector<double> wrap_radii;       ///< at wrap_point and at wrap_end, instead of both [m]; may be empty
  int layer = 0;                        ///< of the clothes, from the body outwards
};

/// Edges sewn to edges. "PANEL/EDGE", points as "PANEL@POINT".
struct SeamSection {
  std::string name;                    ///< empty: made from the edges
  std::vector<std::string> edges, to;  ///< the two sides, each a chain
  std::vector<std::string> meet;       ///< two points, one of each side; empty: what lies nearer
  enum class Gather { automatic, always, never };
  Gather gather = Gather::automatic;  ///< the longer side
  /// Instead of those of [sewing]; NaN: as there
  double bending = std::numeric_limits<double>::quiet_NaN(), allowance = std::numeric_limits<double>::quiet_NaN();
  double zip_speed = 0.0;  ///< at which it closes from the points of `meet` on [m/s]; 0: all of it at once
};

/// A point of a piece with a name.
struct MarkSection {
  std::string name, point, panel;  ///< point: "PANEL@POINT", or empty: panel and at
  std::vector<double> at;          ///< x, y in the plane of the piece [m]
};

/// How seams are closed.
struct SewingSection {
  double stiffness = 1e5;  ///< per rest length of the seam [N/m^2]
  double speed = 0.5;      ///< [m/s]
  double force = 0.0;      ///< with which springs pull at most until they have no length; 0: by the fabric [N/m]
  /// Of the softest material, up to which the force rises then; NaN: 0.3, or not at all where `force` is given
  double strain = std::numeric_limits<double>::quiet_NaN();
  double gap = 1e-4;       ///< largest at which a seam is welded [m]
  double bending = 1.0;    ///< factor across welded seams
  double allowance = 0.0;  ///< width of the strips along both sides of seams [m]
  /// Largest coefficient in stages that sew; NaN: as [contact] says
  double friction = std::numeric_limits<double>::quiet_NaN();
};

/// Named numbers recorded in history.csv after every accepted step.
struct Probe {
  enum class Kind { displacement, reaction, energy, height, ease, stress, contact };
  enum class Face { top, bottom };
  std::string name;  ///< of the columns, before suffixes such as _x _y _z
  Kind kind = Kind::displacement;
  std::string group;  ///< displacement: mean over the group's vertices; reaction: total over them; ease: empty for all
  /// Rest position of the vertex nearest to it, instead of `group`; stress: of the triangle there.
  std::optional<Vec3> point;
  std::vector<int> components;  ///< 0, 1, 2; empty: all three; height: at most one, which points up, 2 if empty
  double ground = 0.0;          ///< height: where it counts from [m]
  Face face = Face::top;        ///< stress: of which surface
  std::string obstacle = {};    ///< contact: its name
};

/// How a support moves: texts as written, turned into system::Support::motion.
struct MotionInput {
  std::vector<std::string> translation;  ///< three expressions of t [m]
  std::optional<Vec3> axis;              ///< of a rotation
  Vec3 centre = Vec3::Zero();            ///< a point on it [m]
  std::string angle;                     ///< expression of t [degree]
  [[nodiscard]] bool any() const { return !translation.empty() || !angle.empty(); }
};

/// A rigid group as written: texts, turned into those of system::RigidGroup.
struct RigidSection {
  std::string name;  ///< of its columns; empty: that of the group
  system::RigidGroup group;
  std::vector<std::string> translation;  ///< "free", or an expression of t [m], each; empty: free
  std::string angle;                     ///< expression of t [degree]; empty: none
};

/// A pair of periodic edges as written: texts, turned into those of system::PeriodicPair.
struct PeriodicSection {
  std::string name;  ///< of its columns; empty: that of `to`
  system::PeriodicPair pair;
  std::vector<std::string> difference;  ///< "free", a number, or an expression of t [m], each; empty: 0
};

/// An obstacle as written; what its files hold is read with the mesh.
struct ObstacleSection {
  enum class Type { mesh, plane, sphere, capsule, cylinder };
  Type type = Type::mesh;
  contact::Obstacle shape;     ///< without what files give; a cylinder gets its triangles with the mesh
  std::filesystem::path file;  ///< mesh
  double scale = 1.0;
  formats::Placement placement;     ///< of mesh and frames
  std::filesystem::path landmarks;  ///< names and coordinates of points of a mesh; empty: none
  std::filesystem::path frames;     ///< point cache of a deforming mesh; empty: none
  double frames_per_second = 25.0;
  double second = 1.0;            ///< in which files count time, in the case's unit
  double frames_start = 0.0;      ///< time of the first frame [s]
  bool frames_loop = false;       ///< from the last frame on to the first
  double frames_smoothing = 0.0;  ///< time over which their mean is taken [s]
  Vec3 point = Vec3::Zero(), end = Vec3::Zero();
  enum class OnPinch { stop, pass };
  OnPinch on_pinch = OnPinch::stop;
  MotionInput motion;
};

/// A point of an obstacle by name; one of the three says where it is.
struct LandmarkSection {
  std::string name, obstacle;
  std::optional<Vec3> point;     ///< [m]
  std::optional<Vec3> near;      ///< the vertex nearest to this [m]
  std::vector<double> vertices;  ///< the mean of these, counted from 1 in the order of the file
};

/// An exception to the rules of contact; NaN: no friction given.
struct RuleSection {
  std::string first, second;
  double friction = std::numeric_limits<double>::quiet_NaN();
  bool ignore = false;
};

struct ContactSection {
  system::ContactInput input;  ///< without obstacles and rules
  bool check = true;           ///< count intersecting triangles after every step
  bool untangle = false;       ///< repair a start that intersects
};

/// Motion in time.
struct TimeSection {
  solve::TimeOptions options;
  std::string load_history;        ///< expression of t for the load factor; empty: 1
  int checkpoint_steps = 0;        ///< a checkpoint every so many steps; 0: none
  double checkpoint_minutes = 10;  ///< and after so many minutes; 0: never
};

/// Velocity at the start of a motion, v + omega x (X - c).
struct InitialVelocity {
  std::string group;                                              ///< empty: everything
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  ///< v [m/s], omega [rad/s]
  Vec3 centre = Vec3::Zero();                                     ///< c [m]
};

/// Modes of vibration and buckling.
struct EigenSection {
  int modes = 6;
  system::Mass mass = system::Mass::consistent;
  double load_factor = 0.0;  ///< of the equilibrium about which they are found
};

/// Vibration by loads or supports that follow a cosine, or are random.
struct HarmonicSection {
  enum class Method { superposition, direct };
  enum class Excitation { loads, base };
  enum class Spacing { logarithmic, linear };
  Method method = Method::superposition;
  Excitation excitation = Excitation::loads;
  std::optional<Vec3> direction;  ///< base: in which all supports move
  double acceleration = 1.0;      ///< base: its amplitude [m/s^2]
  double from = 0.0, to = 0.0;    ///< 0: those of `psd_frequencies` [Hz]
  int points = 200;               ///< between them
  Spacing spacing = Spacing::logarithmic;
  std::vector<double> frequencies;        ///< instead of the four [Hz]
  std::vector<double> field_frequencies;  ///< at which fields are written [Hz]
  /// Power spectral density of the base's acceleration [(m/s^2)^2/Hz], or of the load factor [1/Hz], over the frequency;
  /// empty: nothing is random.
  std::vector<double> psd_frequencies, psd_values;
};

/// Meshes that follow the folds.
struct RemeshSection {
  bool active = false;
  int every = 0;               ///< accepted steps between two looks; 0: 5 in a motion, 1 along a path
  double angle = 0.25;         ///< wanted between neighbouring triangles, per edge [rad]
  double error = 0.0;          ///< fraction of the stored energy that stress resultants may be wrong by; 0: any
  double smallest = 0.0;       ///< edge [m]; 0: 1/200 of the extent, or four contact thicknesses if that is more
  double largest = 0.0;        ///< edge [m]; 0: 1/12 of the extent
  double growth = 0.3;         ///< largest slope of the size over distance
  bool near_contact = true;    ///< smaller where things are in contact
  bool near_obstacles = true;  ///< smaller beside bends of obstacles
  double velocity = 0.0;       ///< largest difference of velocity along an edge [m/s]; 0: any
  std::string size;            ///< expression of x, y, z [m]: an upper bound; empty: none
  std::filesystem::path
      background;                   ///< .pos of Gmsh with upper bounds, resolved relative to the case file; empty: none
  std::vector<std::string> frozen;  ///< surface groups that are left alone
  int relaxation_steps = 2;
  double velocity_change = 0.1;  ///< largest, relative, so that the energy of a motion stays
  double energy_change = 0.1;    ///< largest, relative; a remeshing beyond is refused
  int max_vertices = 0;          ///< 0: no bound
};

struct OutputSection {
  std::vector<std::string> fields;  ///< names of fields to write; empty: all
  int every = 1;                    ///< results every so many accepted steps (the last one always)
  bool energy_balance = true;       ///< of a motion: whether its energy is accounted for
  enum class Stresses { none, surface, plies };
  Stresses stresses = Stresses::none;  ///< which stresses through the thickness are written besides
};

/// By how much the shape without stress differs from the mesh, along its normals or by modes.
struct ImperfectionSection {
  enum class Type { modes, expression, random };
  Type type = Type::modes;
  std::filesystem::path results;   ///< modes: folder of a run, or its modes.vtkhdf, resolved relative to the case file
  std::string stage;               ///< modes: earlier stage of this case that finds them, instead of `results`
  std::vector<double> modes;       ///< numbers, from 1
  std::vector<double> amplitudes;  ///< largest displacement of each, or one for all [m]
  std::string height;              ///< expression of x, y, z [m]
  double amplitude = 0.0;          ///< random: largest displacement [m]
  double length = 0.0;             ///< random: over which heights are alike [m]
  int seed = 1;
};

/// Whether the rest shape is that in which the prestress is in equilibrium (setup/form.hpp).
struct FormSection {
  bool active = false;
  double pressure = 0.0;  ///< along the normals [Pa]
};

/// A stage: an analysis that begins where the one before has ended.
struct StageSection {
  std::string name;  ///< of its folder too
  Analysis analysis = Analysis::statics;
  std::size_t number = 0;  ///< counted from 0
  std::vector<std::size_t> supports{}, loads{}, springs{}, attachments{}, temperatures{}, obstacles{}, rigids{},
      periodics{};                 ///< which of the file's hold in it
  std::vector<std::string> sew{};  ///< seams that it closes; "all": every one
  /// Whether its modes are for the shape of later stages; whether its shape has such modes; the first of those begins without stress.
  bool gives_modes = false, takes_modes = false, begins_anew = false;
  bool moves_obstacles = false;  ///< by its load factor
  /// Whether it goes on from where the stage before has ended.
  [[nodiscard]] bool continues() const { return number > 0 && !begins_anew; }
};

struct Case {
  // Made once: they are long, and many sources hold cases.
  Case();
  Case(const Case&);
  Case(Case&&) noexcept;
  Case& operator=(const Case&);
  Case& operator=(Case&&) noexcept;
  ~Case();

  std::vector<std::string> notes;  ///< what a user should look at

  std::filesystem::path file;
  std::string title;
  Analysis analysis = Analysis::statics;
  UnitsSection units;
  MeshSection mesh;
  std::vector<PanelSection> panels;
  std::vector<SeamSection> seams;
  std::vector<MarkSection> marks;
  SewingSection sewing;
  energy::ElementOptions element;
  std::vector<energy::Material> materials;
  std::vector<std::string> written_materials;  ///< their keys as given, in TOML; empty: of a fabric file
  std::vector<system::Support> supports;
  std::vector<MotionInput> motions;  ///< one per support
  std::vector<RigidSection> rigids;
  std::vector<PeriodicSection> periodics;
  std::vector<system::Load> loads;
  std::vector<system::Temperature> temperatures;
  FormSection form;
  std::vector<system::Hinge> hinges;
  std::vector<ImperfectionSection> imperfections;
  std::vector<system::PointMass> masses;
  std::vector<system::Spring> springs;
  std::vector<system::Attachment> attachments;
  ContactSection contact;
  std::vector<ObstacleSection> obstacles;
  std::vector<LandmarkSection> landmarks;
  std::vector<RuleSection> contact_rules;
  solve::StaticOptions steps;
  EigenSection eigen;
  HarmonicSection harmonic;
  TimeSection time;
  std::vector<InitialVelocity> initial_velocities;
  system::DynamicsOptions dynamics;
  solve::DrapeOptions drape;
  RemeshSection remesh;
  std::vector<Probe> probes;
  OutputSection output;
  std::string petsc_options;  ///< as on PETSc's command line; the real command line wins
  // Stages
  StageSection stage;        ///< that this case is, in `stages`; no name: the only one
  std::vector<Case> stages;  ///< each a case of its own, in the order in which they run; empty: there is one
  std::string staged_text;   ///< the case with its stages as TOML, with absolute paths
  /// Whether it is one of several stages: what moves in another one stands still in it.
  [[nodiscard]] bool is_staged() const { return !stage.name.empty(); }
  /// Whether the load factor moves obstacles, instead of the time.
  [[nodiscard]] bool moves_obstacles_by_load() const {
    return analysis == Analysis::statics && (!is_staged() || stage.moves_obstacles);
  }
  /// Whether it finds modes about an equilibrium instead of following a path; whether those are of vibration.
  /// Whether contact keeps the sheet from passing through itself, in some stage.
  [[nodiscard]] bool touches_itself() const {
    return (contact.input.active && contact.input.self) ||
           std::any_of(stages.begin(), stages.end(), [](const Case& one) { return one.touches_itself(); });
  }
  [[nodiscard]] bool finds_modes() const { return vibrates() || analysis == Analysis::buckling; }
  [[nodiscard]] bool vibrates() const { return analysis == Analysis::modal || analysis == Analysis::harmonic; }
};

/// Parses and checks everything that needs no mesh. Not collective.
/// `settings` are texts "key=value" that win over the file, e.g. "mesh.parameters.n=40" or "load.0.vector=[0, 0, 1]";
/// a value that is no TOML is a text.
/// Throws UserError naming file, line, key and the nearest valid key or value.
[[nodiscard]] Case parse_case(const std::string& text, const std::filesystem::path& file,
                              const std::vector<std::string>& settings = {});

/// The resolved case as TOML: every key with the value in force.
[[nodiscard]] std::string echo_case(const Case& c);

/// docs/reference/case.md, generated from the declarations of the keys.
[[nodiscard]] std::string case_reference_markdown();

}  // namespace voile::input
