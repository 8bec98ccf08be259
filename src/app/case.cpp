#include "voile/app/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "voile/app/case_read.hpp"
#include "voile/app/command_line.hpp"
#include "voile/base/error.hpp"

namespace voile::app {

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

void fill_matrices(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  switch (in.type) {
    case MaterialInput::Type::isotropic:
      m.membrane = energy::isotropic_membrane(in.young, in.poisson, in.thickness);
      break;
    case MaterialInput::Type::orthotropic:
      if (in.poisson_12 * in.poisson_12 >= in.young_1 / in.young_2)
        place.fail("poisson_12", fmt::format("{}: the stiffness is not positive definite; |poisson_12| must be below "
                                             "sqrt(young_1 / young_2) = {:.6g}",
                                             in.poisson_12, std::sqrt(in.young_1 / in.young_2)));
      m.membrane = energy::orthotropic_membrane(in.young_1, in.young_2, in.poisson_12, in.shear_12, in.thickness);
      break;
    case MaterialInput::Type::matrices:
      check_matrix(place, "membrane", in.membrane);
      check_matrix(place, "bending", in.bending);
      m.membrane = in.membrane;
      m.bending = in.bending;
      m.areal_density = in.areal_density;
      if (!in.direction && !(is_isotropic(m.membrane) && is_isotropic(m.bending)))
        place.fail("direction", "the key is missing; these matrices depend on the direction of material axis 1");
      return;
  }
  m.bending = energy::bending_from_membrane(m.membrane, in.thickness);
  m.areal_density = in.density * in.thickness;
  if (!energy::is_positive_definite(m.membrane) || !energy::is_positive_definite(m.bending))
    place.fail("thickness", "the stiffness is not positive definite or not finite; check moduli and thickness");
}

void read_materials(const CaseReader& reader, const std::string& file, Case& c) {
  if (reader.count("material") == 0)
    throw UserError(fmt::format("{}: there is no material; add a section [[material]]", file));
  std::vector<std::string> covered;
  bool everywhere = false;
  for (std::size_t n = 0; n < reader.count("material"); ++n) {
    MaterialInput in;
    const SectionPlace place = reader.read("material", n, keys_of(in));
    energy::Material m;
    m.groups = in.groups;
    m.direction = in.direction;
    fill_matrices(place, in, m);
    if (in.groups.empty() && everywhere)
      place.fail("groups", "the key is missing, and another material has no groups either; say where each applies");
    everywhere = everywhere || in.groups.empty();
    for (const std::string& group : in.groups) {
      if (std::find(covered.begin(), covered.end(), group) != covered.end())
        place.fail("groups", fmt::format("group '{}' has a material already; remove it from one of them", group));
      covered.push_back(group);
    }
    c.materials.push_back(std::move(m));
  }
}

void check_steps(const SectionPlace& place, solve::StaticOptions& s) {
  if (!place.has("initial_step")) s.initial_step = std::min(s.initial_step, s.max_step);
  if (!place.has("min_step")) s.min_step = std::min(s.min_step, s.initial_step);
  if (s.initial_step > s.max_step)
    place.fail("initial_step", fmt::format("{}: must not be larger than max_step = {}", s.initial_step, s.max_step));
  if (s.min_step > s.initial_step)
    place.fail("min_step", fmt::format("{}: must not be larger than initial_step = {}", s.min_step, s.initial_step));
  for (std::size_t k = 1; k < s.stops.size(); ++k)
    if (s.stops[k] <= s.stops[k - 1])
      place.fail("stops", fmt::format("{} follows {}: list the stops in ascending order, each once", s.stops[k],
                                      s.stops[k - 1]));
  if (!s.stops.empty() && s.stops.back() > s.final_load_factor)
    place.fail("stops", fmt::format("{} lies beyond final_load_factor = {}: remove it or raise the final load factor",
                                    s.stops.back(), s.final_load_factor));
}

void check_probe(const SectionPlace& place, const Probe& probe, const std::vector<Probe>& others) {
  for (const char c : probe.name)
    if (c == ',' || c == '"' || static_cast<unsigned char>(c) < 32)
      place.fail("name", fmt::format("'{}': a column name must not contain commas, quotes or line breaks", probe.name));
  for (const Probe& other : others)
    if (other.name == probe.name) place.fail("name", fmt::format("'{}': another probe has this name", probe.name));
  if (probe.kind != Probe::Kind::displacement) return;
  if (place.has("group") == place.has("point"))
    place.fail(place.has("point") ? "point" : "group", "a displacement probe needs either 'group' or 'point'");
}

template <class Section, class Check>
void read_all(const CaseReader& reader, const char* name, std::vector<Section>& items, const Check& check) {
  for (std::size_t n = 0; n < reader.count(name); ++n) {
    Section item;
    const SectionPlace place = reader.read(name, n, keys_of(item));
    check(place, item);
    items.push_back(std::move(item));
  }
}

void check_petsc(const SectionPlace& place, const std::string& options) {
  try {
    (void)petsc_pairs(options);
  } catch (const UserError& e) {
    place.fail("options", e.what());
  }
}

}  // namespace

Case parse_case(const std::string& text, const std::filesystem::path& file) {
  Case c;
  c.file = file;
  const CaseReader reader(text, file, top_keys(c));
  reader.read_top(top_keys(c));
  reader.read("mesh", 0, keys_of(c.mesh));
  // Absolute, so that the echo of the case works from any folder.
  c.mesh.file = (std::filesystem::absolute(file).parent_path() / c.mesh.file).lexically_normal();
  reader.read("element", 0, keys_of(c.element));
  read_materials(reader, file.string(), c);
  const auto unchecked = [](const SectionPlace&, const auto&) {};
  read_all(reader, "support", c.supports, unchecked);
  read_all(reader, "load", c.loads, unchecked);
  check_steps(reader.read("steps", 0, keys_of(c.steps)), c.steps);
  read_all(reader, "probe", c.probes,
           [&](const SectionPlace& place, const Probe& probe) { check_probe(place, probe, c.probes); });
  reader.read("output", 0, keys_of(c.output));
  check_petsc(reader.read("petsc", 0, petsc_keys(c)), c.petsc_options);
  return c;
}

}  // namespace voile::app
