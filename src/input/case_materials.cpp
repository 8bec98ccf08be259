#include "case_materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/plain_file.hpp"
#include "base/shipped_files.hpp"
#include "base/text.hpp"
#include "case_rubber.hpp"
#include "fabric.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

/// True for the stiffness of a material that is the same in every direction.
bool is_isotropic(const Mat3& m) {
  const double tolerance = 1e-9 * m.cwiseAbs().maxCoeff();
  const auto zero = [&](double x) { return std::abs(x) <= tolerance; };
  return zero(m(0, 0) - m(1, 1)) && zero(m(0, 2)) && zero(m(1, 2)) && zero(m(2, 2) - 0.5 * (m(0, 0) - m(0, 1)));
}

void check_matrix(const SectionPlace& place, const char* key, const Mat3& m) {
  const double asymmetry = (m - m.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-12 * m.cwiseAbs().maxCoeff())
    place.fail(key, fmt::format("the matrix is not symmetric (difference {:.3g}); make entry (i, j) equal to (j, i)",
                                asymmetry));
  if (!energy::is_positive_definite(m))
    place.fail(key, "the matrix is not positive definite, so some deformation would cost no energy; check its entries");
}

void check_ortho(const SectionPlace& place, const MaterialInput& in) {
  if (in.poisson_12 * in.poisson_12 < in.young_1 / in.young_2) return;
  place.fail("poisson_12", fmt::format("{}: the stiffness is not positive definite; |poisson_12| must be below "
                                       "sqrt(young_1 / young_2) = {:.6g}",
                                       in.poisson_12, std::sqrt(in.young_1 / in.young_2)));
}

void fill_laminate(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  check_ortho(place, in);
  const std::size_t count = in.angles.size(), given = in.ply_thicknesses.size();
  if (given != 1 && given != count)
    place.fail("ply_thicknesses",
               fmt::format("{} thicknesses for {} plies; give one per ply, or one for all", given, count));
  std::vector<energy::Ply> plies;
  for (std::size_t k = 0; k < count; ++k)
    plies.push_back({in.angles[k] * (std::numbers::pi / 180.0), in.ply_thicknesses[given == 1 ? 0 : k]});
  const energy::LaminateStiffness l =
      energy::laminate(energy::orthotropic_membrane(in.young_1, in.young_2, in.poisson_12, in.shear_12, 1.0), plies);
  // What round-off leaves of a symmetric stack is none.
  const double size = l.membrane.cwiseAbs().maxCoeff() * l.thickness;
  if (l.coupling.cwiseAbs().maxCoeff() > 1e-9 * size) m.coupling = l.coupling;
  m.membrane = l.membrane;
  m.bending = l.bending;
  m.layers = l.layers;
  m.areal_density = in.density * l.thickness;
  if (!energy::is_stable(m))
    place.fail("ply_thicknesses", "the stiffness is not positive definite or not finite; check moduli and thicknesses");
}

/// A second fabric. Its curves count by their tangents at zero, its friction not at all.
void fuse_interlining(const SectionPlace& place, const MaterialInput& in, const UnitSystem& units, const Fabric& face,
                      energy::Material& m) {
  constexpr Powers per_width{0, 1, -2}, moment_per_width{2, 1, -2}, per_area{-2, 1, 0}, length{1, 0, 0};
  const Fabric other = read_fabric(in.interlining);
  double distance = in.interlining_distance;
  if (std::isnan(distance)) {
    if (!face.thickness || !other.thickness)
      place.fail("interlining_distance",
                 fmt::format("the key is missing, and {} has no thickness; give the distance of the middles of both "
                             "layers",
                             (face.thickness ? in.interlining : in.fabric).string()));
    distance = units.from_si(0.5 * (*face.thickness + *other.thickness), length);
  }
  const double angle = in.warp_angle + in.interlining_angle;
  energy::fuse(m, {units.from_si(1.0, per_width) * energy::rotated_stiffness(membrane_stiffness(other), angle),
                   units.from_si(1.0, moment_per_width) * energy::rotated_stiffness(bending_stiffness(other), angle),
                   units.from_si(other.areal_density, per_area), distance, in.interlining_bond});
}

/// The file of a fabric states its own mistakes.
void fill_fabric(const SectionPlace& place, const MaterialInput& in, const UnitSystem& units, energy::Material& m) {
  constexpr Powers per_width{0, 1, -2}, moment_per_width{2, 1, -2}, per_area{-2, 1, 0}, duration{0, 0, 1};
  const Fabric fabric = read_fabric(in.fabric);
  const bool friction = in.hysteresis == MaterialInput::Hysteresis::friction;
  const double per_si = units.from_si(1.0, per_width);
  m.membrane = per_si * energy::rotated_stiffness(membrane_stiffness(fabric, friction), in.warp_angle);
  m.yarns = yarn_law(fabric, friction);
  m.yarns.warp_angle = in.warp_angle;
  for (double* figure : {&m.yarns.stiffness, &m.yarns.limit, &m.yarns.rise}) *figure *= per_si;
  for (auto& knots : m.yarns.knots)
    for (energy::YarnLaw::Knot& k : knots) k.bend *= per_si;
  m.bending =
      units.from_si(1.0, moment_per_width) * energy::rotated_stiffness(bending_stiffness(fabric), in.warp_angle);
  m.areal_density = units.from_si(fabric.areal_density, per_area);
  if (!in.interlining.empty()) fuse_interlining(place, in, units, fabric, m);
  // Friction takes the place of damping only where the loop of bending is known.
  if ((!friction || !fabric.bending_hysteresis) && !place.has("bending_damping"))
    m.bending_damping = units.from_si(bending_damping(fabric), duration);
  if (!friction) return;
  constexpr Powers force{1, 1, -2}, per_length{-1, 0, 0};
  m.friction.warp_angle = in.warp_angle;
  try {
    const double spread = fabric.bending_hysteresis_spread.value_or(typical_spread);
    m.friction.sliders = energy::sliders_of(units.from_si(1.0, force) * bending_loop(fabric),
                                            units.from_si(spread, per_length), in.bending_sliders);
  } catch (const UserError& e) {
    place.fail("hysteresis", fmt::format("{}: {}", in.fabric.string(), e.what()));
  }
}

/// Friction of materials that are no fabrics.
void fill_friction(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  const std::vector<double>& loop = in.bending_hysteresis;
  if (loop.empty()) return;
  if (!in.direction && in.texture_direction.empty())
    place.fail("direction", "the key is missing; bending_hysteresis acts along and across material axis 1");
  if (loop.size() != 1 && loop.size() != 3)
    place.fail("bending_hysteresis", fmt::format("{} numbers are given; give one for both material axes, or three, for "
                                                 "axis 1, axis 2 and twist",
                                                 loop.size()));
  m.friction.warp_angle = in.warp_angle;
  const Vec3 all = loop.size() == 3 ? Vec3(loop[0], loop[1], loop[2]) : Vec3(loop[0], loop[0], 0.0);
  m.friction.sliders = energy::sliders_of(all, in.bending_hysteresis_spread, in.bending_sliders);
}

/// Stiffening and friction in the plane of matrices, as echo_case writes them.
void fill_yarns(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  const std::array given{std::pair{"stiffening_warp", &in.stiffening_warp},
                         std::pair{"stiffening_weft", &in.stiffening_weft},
                         std::pair{"stiffening_shear", &in.stiffening_shear}};
  for (std::size_t r = 0; r < 3; ++r) {
    const auto& [key, numbers] = given[r];
    if (numbers->size() % 2 != 0) place.fail(key, "pairs are needed: a strain, and by what the tangent bends there");
    for (std::size_t i = 0; i < numbers->size(); i += 2) {
      if (i > 0 ? (*numbers)[i] <= (*numbers)[i - 2] : (*numbers)[i] < 0.0)
        place.fail(key, fmt::format("strain {:g} is not above the one before; strains rise from 0 on", (*numbers)[i]));
      m.yarns.knots[r].push_back({(*numbers)[i], (*numbers)[i + 1]});
    }
  }
  if (!in.shear_hysteresis.empty()) {
    if (in.shear_hysteresis.size() != 3)
      place.fail("shear_hysteresis", "three numbers are needed: limit, its growth, stiffness of the spring");
    m.yarns.limit = in.shear_hysteresis[0];
    m.yarns.rise = in.shear_hysteresis[1];
    m.yarns.stiffness = in.shear_hysteresis[2];
    if (!(m.yarns.stiffness > 0.0))
      place.fail("shear_hysteresis",
                 "the third number, the stiffness of the spring before the slider, has to be positive");
  }
  if (m.yarns.any() && !m.prestress.isZero(0.0))
    place.fail("prestress",
               "yarns that stiffen or rub have no strain in proportion to it; give initial_strain instead");
  if (in.type != MaterialInput::Type::matrices) return;
  m.yarns.warp_angle = in.warp_angle;
  if (!m.yarns.any()) return;
  if (!in.direction && in.texture_direction.empty())
    place.fail("direction", "the key is missing; stiffening and shear_hysteresis act along the yarns");
  // Into yarn axes: those at -angle to the axes given.
  if (!energy::is_stable(energy::rotated_stiffness(m.membrane, -in.warp_angle), m.yarns))
    place.fail("membrane", "with the stiffening or friction of the yarns some strain would cost no energy; check them");
}

/// The file of a fabric that the case names; only a missing one is a mistake of the case.
std::filesystem::path fabric_file(const SectionPlace& place, const char* key, const std::filesystem::path& name) {
  const std::vector<std::filesystem::path> places = fabric_places(place.file, name);
  std::error_code ignored;
  for (const std::filesystem::path& file : places) {
    require_plain_file(file);
    if (std::filesystem::is_regular_file(file, ignored)) return file;
  }
  std::vector<std::string> looked;
  for (const std::filesystem::path& file : places) looked.push_back(file.string());
  const std::string near = nearest(name.stem().string(), shipped_names("fabrics", ".toml"));
  place.fail(key,
             fmt::format("there is no fabric file {}{}", join(looked, " or "),
                         near.empty() ? "" : fmt::format("; did you mean {} = \"{}\", which is shipped?", key, near)));
}

void fill_matrices(const SectionPlace& place, const MaterialInput& in, const UnitSystem& units, energy::Material& m) {
  m.bending_damping = in.bending_damping;
  m.viscous_time = in.membrane_damping;
  switch (in.type) {
    case MaterialInput::Type::laminate:
      fill_laminate(place, in, m);
      return;
    case MaterialInput::Type::fabric:
      fill_fabric(place, in, units, m);
      return;
    case MaterialInput::Type::isotropic:
      m.membrane = energy::isotropic_membrane(in.young, in.poisson, in.thickness);
      break;
    case MaterialInput::Type::orthotropic:
      check_ortho(place, in);
      m.membrane = energy::orthotropic_membrane(in.young_1, in.young_2, in.poisson_12, in.shear_12, in.thickness);
      break;
    case MaterialInput::Type::neo_hookean:
    case MaterialInput::Type::mooney_rivlin:
    case MaterialInput::Type::ogden:
      fill_rubber(place, in, m);
      break;
    case MaterialInput::Type::matrices:
      check_matrix(place, "membrane", in.membrane);
      check_matrix(place, "bending", in.bending);
      m.membrane = in.membrane;
      m.bending = in.bending;
      m.coupling = in.coupling;
      if ((m.coupling - m.coupling.transpose()).cwiseAbs().maxCoeff() > 1e-12 * m.coupling.cwiseAbs().maxCoeff())
        place.fail("coupling", "the matrix is not symmetric; make entry (i, j) equal to (j, i)");
      if (!energy::is_stable(m))
        place.fail("coupling",
                   "some deformation would cost no energy: [A, -B; -B, D] is not positive definite; check "
                   "the entries");
      m.areal_density = in.areal_density;
      if (!in.direction && in.texture_direction.empty() &&
          !(is_isotropic(m.membrane) && is_isotropic(m.bending) && is_isotropic(m.coupling)))
        place.fail("direction", "the key is missing; these matrices depend on the direction of material axis 1");
      return;
  }
  m.bending = energy::bending_from_membrane(m.membrane, in.thickness);
  m.layers = {{-0.5 * in.thickness, 0.5 * in.thickness, m.membrane / in.thickness}};
  m.areal_density = in.density * in.thickness;
  if (!energy::is_positive_definite(m.membrane) || !energy::is_positive_definite(m.bending))
    place.fail("thickness", "the stiffness is not positive definite or not finite; check moduli and thickness");
}

/// All five strengths or none.
void fill_strength(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  const energy::Strength& s = in.strength;
  const std::array given{std::pair{"tensile_strength_1", s.tensile_1},
                         std::pair{"compressive_strength_1", s.compressive_1},
                         std::pair{"tensile_strength_2", s.tensile_2},
                         std::pair{"compressive_strength_2", s.compressive_2}, std::pair{"shear_strength", s.shear}};
  const bool any = std::any_of(given.begin(), given.end(), [](const auto& g) { return !std::isnan(g.second); });
  if (!any && s.criterion != energy::Strength::Criterion::tsai_wu)
    place.fail("failure",
               "a criterion needs the strengths: give tensile_strength_1, compressive_strength_1, "
               "tensile_strength_2, compressive_strength_2 and shear_strength");
  if (!any) return;
  for (const auto& [key, value] : given)
    if (std::isnan(value)) place.fail(key, "the key is missing; the five strengths go together");
  m.strength = s;
  m.strength->young_1 = in.young_1;
  m.strength->young_2 = in.young_2;
  m.strength->poisson_12 = in.poisson_12;
  m.strength->shear_12 = in.shear_12;
}

/// One of the two expansions of a material with directions.
void require_pair(const SectionPlace& place, const MaterialInput& in) {
  if (std::isnan(in.expansion_1) != std::isnan(in.expansion_2))
    place.fail(std::isnan(in.expansion_1) ? "expansion_1" : "expansion_2",
               "the key is missing; expansion_1 and expansion_2 go together");
}

/// Expansions; the stiffnesses are there already.
void fill_expansion(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  using Type = MaterialInput::Type;
  require_pair(place, in);
  const bool isotropic = in.type == Type::isotropic;
  const double along = isotropic ? in.expansion : in.expansion_1, across = isotropic ? in.expansion : in.expansion_2;
  if (in.type == Type::matrices) {
    m.expands = in.expansion_strain || in.expansion_curvature;
    m.expansion = in.expansion_strain.value_or(Vec3::Zero());
    m.expansion_curvature = in.expansion_curvature.value_or(Vec3::Zero());
    m.coupled_strain = in.coupled_strain.value_or(Vec3::Zero());
    m.coupled_curvature = in.coupled_curvature.value_or(Vec3::Zero());
  } else if (!std::isnan(along)) {
    m.expands = true;
    energy::set_expansion(m, Vec3(along, across, 0.0), in.type == Type::laminate ? in.angles : std::vector<double>{});
  }
}

/// Two numbers, or three with a shear; without a direction the same in all.
Vec3 in_axes(const SectionPlace& place, const char* key, const std::vector<double>& given, bool directed) {
  if (given.empty()) return Vec3::Zero();
  if (given.size() > 3 || given.size() < 2)
    place.fail(
        key, fmt::format("{} number(s); give two, along material axes 1 and 2, or three with the shear", given.size()));
  Vec3 v(given[0], given[1], given.size() == 3 ? given[2] : 0.0);
  if (!directed && (v[0] != v[1] || v[2] != 0.0))
    place.fail(key,
               "the material has no direction; give 'direction' (material axis 1) or 'texture_direction', or two "
               "equal numbers");
  return v;
}

/// The natural state. Axes and stiffnesses are there already.
void fill_natural(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  fill_expansion(place, in, m);
  const bool directed = m.direction || m.texture_direction;
  m.initial_strain = in_axes(place, "initial_strain", in.initial_strain, directed);
  m.prestress = in_axes(place, "prestress", in.prestress, directed);
  if (in.type == MaterialInput::Type::fabric) {
    m.initial_strain = energy::rotated_strain(m.initial_strain, in.warp_angle);
    m.prestress = energy::rotated_force(m.prestress, in.warp_angle);
  }
  constexpr double most = 0.5;
  if (m.initial_strain.cwiseAbs().maxCoeff() > most)
    place.fail("initial_strain", fmt::format("it is a fraction, and {:g} is more than {:g}; 2 % is 0.02",
                                             m.initial_strain.cwiseAbs().maxCoeff(), most));
  const Vec3& e = m.expansion;
  const double round_off = 1e-9 * e.norm();
  if (!directed && (std::abs(e[0] - e[1]) > round_off || std::abs(e[2]) > round_off))
    place.fail("expansion_strain", "the material has no direction; give 'direction' or 'texture_direction'");
}

void fill_direction(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  using Type = MaterialInput::Type;
  const bool textured = !in.texture_direction.empty();
  if (textured && in.direction) place.fail("texture_direction", "there is a 'direction' too; keep one of them");
  if (!textured && !in.direction && in.type != Type::isotropic && in.type != Type::matrices && !is_rubber(in.type))
    place.fail("direction", "the key is missing; give the direction of material axis 1, or texture_direction");
  m.direction = in.direction;
  if (!textured) return;
  if (in.texture_direction.size() != 2 || (in.texture_direction[0] == 0.0 && in.texture_direction[1] == 0.0))
    place.fail("texture_direction", "two numbers [u, v] are needed that are not both zero");
  m.texture_direction = Vec2(in.texture_direction[0], in.texture_direction[1]).normalized();
}

/// Of flat pieces the direction is one of their cloth, which turns with their grain lines as (u, v) do.
void take_as_texture(const SectionPlace& place, energy::Material& m) {
  const Vec3 d = m.direction->normalized();
  if (std::abs(d[2]) > 1e-12)
    place.fail("direction",
               "pieces lie flat: [u, v, 0] in the axes of the pattern is needed, or texture_direction = [u, v]");
  m.texture_direction = d.head<2>().normalized();
  m.direction.reset();
}

}  // namespace

std::filesystem::path beside(const std::filesystem::path& case_file, const std::filesystem::path& path) {
  return (std::filesystem::absolute(case_file).parent_path() / path).lexically_normal();
}

std::vector<std::filesystem::path> fabric_places(const std::filesystem::path& case_file,
                                                 const std::filesystem::path& name) {
  std::vector<std::filesystem::path> places{beside(case_file, name)};
  if (name.has_parent_path() || name.has_extension()) return places;
  const std::string file = name.string() + ".toml";
  places.push_back(beside(case_file, file));
  places.push_back(shipped_folder("fabrics") / file);
  return places;
}

void read_materials(const CaseReader& reader, Case& c) {
  if (reader.count("material") == 0)
    throw UserError(fmt::format("{}: there is no material; add a section [[material]]", c.file.string()));
  std::vector<std::string> covered;
  bool everywhere = false;
  for (std::size_t n = 0; n < reader.count("material"); ++n) {
    MaterialInput in;
    const SectionPlace place = reader.read("material", n, keys_of(in));
    energy::Material m;
    m.groups = in.groups;
    fill_direction(place, in, m);
    const bool flat = !c.panels.empty() || c.mesh.options.rest == formats::RestShape::texture;
    if (flat && m.direction) take_as_texture(place, m);
    if (in.type == MaterialInput::Type::fabric) in.fabric = fabric_file(place, "fabric", in.fabric);
    if (!in.interlining.empty()) in.interlining = fabric_file(place, "interlining", in.interlining);
    for (const char* key : {"interlining_angle", "interlining_distance", "interlining_bond"})
      if (place.has(key) && in.interlining.empty())
        place.fail("interlining", fmt::format("the key is missing; {} is about a second fabric", key));
    fill_matrices(place, in, reader.units(), m);
    fill_strength(place, in, m);
    fill_natural(place, in, m);
    fill_friction(place, in, m);
    fill_yarns(place, in, m);
    if (in.groups.empty() && everywhere)
      place.fail("groups", "the key is missing, and another material has no groups either; name the groups of each");
    everywhere = everywhere || in.groups.empty();
    for (const std::string& group : in.groups) {
      if (std::find(covered.begin(), covered.end(), group) != covered.end())
        place.fail("groups", fmt::format("group '{}' has a material already; remove it from one of them", group));
      covered.push_back(group);
    }
    c.materials.push_back(std::move(m));
    c.written_materials.push_back(in.type == MaterialInput::Type::fabric ? "" : echo_keys(keys_of(in)));
  }
}

}  // namespace voile::input
