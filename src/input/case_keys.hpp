// Declarations of the keys of the case file. Each key is declared once, bound to the variable it sets; the reader, the
// echo and the reference page all walk the same lists.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/text.hpp"
#include "case.hpp"

namespace voile::input {

/// Interval a number must lie in.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< `low` itself is not allowed
  [[nodiscard]] bool contains(double x) const { return x <= high && (low_open ? x > low : x >= low); }
  [[nodiscard]] std::string text() const;  ///< e.g. "> 0"; empty if there is no limit
};

/// A number written in degrees and kept in radians.
struct Degrees {
  double* radians;
};

/// One of a list of words, kept as its position (usually that of an enumerator).
struct Choice {
  std::vector<std::string> names;
  std::function<int()> get;
  std::function<void(int)> set;
};

/// Some of a list of words.
struct Words {
  std::vector<std::string>* values;
  std::vector<std::string> allowed;  ///< empty: any word
};

/// A group, or several that count as one, kept as one name (base/group_list.hpp).
struct GroupList {
  std::string* name;
};

/// Where a key's value goes; the alternative decides what may be written in the file.
using Slot = std::variant<double*, int*, bool*, std::string*, std::filesystem::path*, Degrees, Choice, Words,
                          std::vector<double>*, std::vector<int>*, std::array<bool, 3>*, Vec3*, std::optional<Vec3>*,
                          PointInput*, std::optional<PointInput>*, Mat3*, std::map<std::string, double>*,
                          std::vector<std::string>*, GroupList>;

struct Key {
  std::string name;
  Slot slot;
  std::string meaning;
  std::string unit{};                ///< "" if the key has none
  Range range{};                     ///< of a number or of each number in a list
  std::vector<std::string> types{};  ///< values of the section's key `type` that this key belongs to; empty: all
  bool required = false;
  std::vector<std::string> required_types{};  ///< as `required`, for these values of `type` only
  std::string absent{};                       ///< what holds if the key is not given, where no value of it says so
};

/// The keys of a section that apply, with the values in force, as TOML.
[[nodiscard]] std::string echo_keys(const std::vector<Key>& keys);
[[nodiscard]] bool applies(const Key& key, const std::string& type);
[[nodiscard]] bool is_required(const Key& key, const std::string& type);

/// A material as it is written in the file.
struct MaterialInput {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  enum class Type { isotropic, orthotropic, matrices, laminate, fabric, neo_hookean, mooney_rivlin, ogden };
  Type type = Type::isotropic;
  std::vector<std::string> groups;
  double young = nan, poisson = 0.0;
  double shear_modulus = nan, c10 = 0.0, c01 = 0.0;  ///< hyperelastic [Pa]
  std::vector<double> mu, alpha;                     ///< Ogden [Pa], [-]
  double young_1 = 0.0, young_2 = 0.0, poisson_12 = 0.0, shear_12 = 0.0;
  double thickness = 0.0, density = 0.0, areal_density = 0.0;
  double expansion = nan, expansion_1 = nan, expansion_2 = nan;  ///< [1/K]; NaN: not given
  std::optional<Vec3> expansion_strain, expansion_curvature;     ///< [1/K], [1/(m K)]
  std::optional<Vec3> coupled_strain, coupled_curvature;
  std::vector<double> initial_strain, prestress;         ///< empty, or along axes 1 and 2, and of shear
  double bending_damping = 0.0, membrane_damping = 0.0;  ///< [s]
  std::vector<double> angles, ply_thicknesses;
  energy::Strength strength{energy::Strength::Criterion::tsai_wu, nan, nan, nan, nan, nan};  ///< moduli: above
  Mat3 membrane = Mat3::Zero(), bending = Mat3::Zero(), coupling = Mat3::Zero();
  std::filesystem::path fabric, interlining;
  double warp_angle = 0.0;
  double interlining_angle = 0.0;     ///< from the warp to that of the interlining [rad]
  double interlining_distance = nan;  ///< of the middles of both layers [m]; NaN: by their thicknesses
  double interlining_bond = 1.0;      ///< 1: glued, 0: the layers slide on each other
  enum class Hysteresis { damping, friction };
  Hysteresis hysteresis = Hysteresis::damping;  ///< what the loop of a fabric file becomes
  std::vector<double> bending_hysteresis;       ///< 2HB along axis 1 and 2, and in twist [N]; empty: none
  double bending_hysteresis_spread = 10.0;      ///< [1/m]
  int bending_sliders = 1;
  std::vector<double> stiffening_warp, stiffening_weft, stiffening_shear;  ///< strain and bend of each knot
  std::vector<double> shear_hysteresis;                                    ///< empty, or H0, h, G_s
  std::optional<Vec3> direction;
  std::vector<double> texture_direction;  ///< empty, or u and v
};

[[nodiscard]] std::vector<Key> keys_of(UnitsSection& section);
[[nodiscard]] std::vector<Key> keys_of(MeshSection& section);
[[nodiscard]] std::vector<Key> keys_of(PanelSection& section);
[[nodiscard]] std::vector<Key> keys_of(SeamSection& section);
[[nodiscard]] std::vector<Key> keys_of(MarkSection& section);
[[nodiscard]] std::vector<Key> keys_of(SewingSection& section);
[[nodiscard]] std::vector<Key> keys_of(energy::ElementOptions& section);
[[nodiscard]] std::vector<Key> keys_of(MaterialInput& section);
/// A support and its motion are one section.
[[nodiscard]] std::vector<Key> keys_of(system::Support& section, MotionInput& motion);
[[nodiscard]] std::vector<Key> keys_of(RigidSection& section);
[[nodiscard]] std::vector<Key> keys_of(PeriodicSection& section);
[[nodiscard]] std::vector<Key> keys_of(system::Load& section);
[[nodiscard]] std::vector<Key> keys_of(system::Temperature& section);
[[nodiscard]] std::vector<Key> keys_of(FormSection& section);
[[nodiscard]] std::vector<Key> keys_of(system::Hinge& section);
[[nodiscard]] std::vector<Key> keys_of(ImperfectionSection& section);
[[nodiscard]] std::vector<Key> keys_of(system::PointMass& section);
[[nodiscard]] std::vector<Key> keys_of(system::Spring& section);
[[nodiscard]] std::vector<Key> keys_of(system::Attachment& section);
[[nodiscard]] std::vector<Key> keys_of(ContactSection& section);
[[nodiscard]] std::vector<Key> keys_of(ObstacleSection& section);
[[nodiscard]] std::vector<Key> keys_of(LandmarkSection& section);
[[nodiscard]] std::vector<Key> keys_of(RuleSection& section);
[[nodiscard]] std::vector<Key> keys_of(solve::StaticOptions& section);
[[nodiscard]] std::vector<Key> keys_of(EigenSection& section);
[[nodiscard]] std::vector<Key> keys_of(HarmonicSection& section);
/// [time], with the kind of mass.
[[nodiscard]] std::vector<Key> keys_of(TimeSection& section, system::Mass& mass);
[[nodiscard]] std::vector<Key> keys_of(InitialVelocity& section);
/// [damping]
[[nodiscard]] std::vector<Key> damping_keys(system::DynamicsOptions& section);
/// [air]
[[nodiscard]] std::vector<Key> keys_of(energy::DragOptions& section);
[[nodiscard]] std::vector<Key> keys_of(solve::DrapeOptions& section);
[[nodiscard]] std::vector<Key> keys_of(RemeshSection& section);
[[nodiscard]] std::vector<Key> keys_of(Probe& section);
[[nodiscard]] std::vector<Key> keys_of(OutputSection& section);
/// [[stage]], besides the tables that stageable_sections() names.
[[nodiscard]] std::vector<Key> keys_of(StageSection& section);
/// Sections that a stage may have of its own: [stage.steps] ...; and those whose items take the key `stages`.
[[nodiscard]] const std::vector<std::string>& stage_tables();
[[nodiscard]] const std::vector<std::string>& staged_items();
/// Keys outside every section.
[[nodiscard]] std::vector<Key> top_keys(Case& c);
[[nodiscard]] std::vector<Key> petsc_keys(Case& c);

/// A section of the file and what it is for.
struct SectionInfo {
  std::string name;
  bool repeated;  ///< written [[name]], any number of times
  std::string meaning;
};
[[nodiscard]] const std::vector<SectionInfo>& sections();

/// A value as it is written in TOML; empty if the slot holds nothing that can be written.
[[nodiscard]] std::string toml_value(const Slot& slot);

}  // namespace voile::input
