#include "case_harmonic.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "case_loads.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

constexpr const char* name = "harmonic";

void check_ascending(const SectionPlace& place, const char* key, const std::vector<double>& values) {
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[i] <= values[i - 1])
      place.fail(key, fmt::format("{:g} follows {:g}: list the frequencies in ascending order, each once", values[i],
                                  values[i - 1]));
}

void check_range(const SectionPlace& place, HarmonicSection& s) {
  check_ascending(place, "field_frequencies", s.field_frequencies);
  check_ascending(place, "frequencies", s.frequencies);
  if (!s.frequencies.empty() && s.from + s.to > 0.0)
    place.fail(s.from > 0.0 ? "from" : "to", "the frequencies are listed in `frequencies`; remove one of the two");
  if (!s.frequencies.empty()) return;
  if (s.from == 0.0 && !s.psd_frequencies.empty()) s.from = s.psd_frequencies.front();
  if (s.to == 0.0 && !s.psd_frequencies.empty()) s.to = s.psd_frequencies.back();
  if (s.from == 0.0 && s.spacing == HarmonicSection::Spacing::logarithmic)
    place.fail("from", "the key is missing or 0; give the lowest frequency in Hz, above 0 with logarithmic spacing");
  if (s.to <= s.from)
    place.fail("to", fmt::format("{:g} Hz: must be above from = {:g} Hz; give the highest frequency", s.to, s.from));
}

void check_psd(const SectionPlace& place, const HarmonicSection& s) {
  const std::vector<double>&f = s.psd_frequencies, &values = s.psd_values;
  check_ascending(place, "psd_frequencies", f);
  if (f.size() != values.size())
    place.fail(f.size() > values.size() ? "psd_values" : "psd_frequencies",
               fmt::format("{} frequencies and {} values; give one value per frequency", f.size(), values.size()));
  if (f.size() == 1) place.fail("psd_frequencies", "one frequency has no band; give two or more");
  if (!f.empty() && s.method == HarmonicSection::Method::direct)
    place.fail("method", "random vibration needs \"superposition\", which resolves every peak; remove the key");
}

bool varies(const Case& c) {
  return std::any_of(c.loads.begin(), c.loads.end(), [](const auto& f) { return !f.constant && !f.history; }) ||
         std::any_of(c.temperatures.begin(), c.temperatures.end(), [](const auto& t) { return !t.constant; }) ||
         std::any_of(c.hinges.begin(), c.hinges.end(), [](const auto& f) { return f.angle.value && !f.constant; }) ||
         std::any_of(
             c.rigids.begin(), c.rigids.end(),
             [](const RigidSection& r) { return r.group.force.squaredNorm() + r.group.moment.squaredNorm() > 0.0; }) ||
         std::any_of(c.periodics.begin(), c.periodics.end(),
                     [](const PeriodicSection& s) { return !s.pair.force.isZero(0.0); });
}

void check_excitation(const SectionPlace& place, const Case& c) {
  const HarmonicSection& s = c.harmonic;
  if (s.excitation == HarmonicSection::Excitation::base) {
    if (!s.direction) place.fail("direction", "the key is missing; excitation = \"base\" moves along one");
    return;
  }
  if (s.direction) place.fail("direction", "it is that of a moving base; add excitation = \"base\", or remove the key");
  if (!varies(c))
    place.fail("excitation", "no load varies; give a [[load]] that is not constant, or excitation = \"base\"");
}

bool damps(const Case& c) {
  const system::DynamicsOptions& d = c.dynamics;
  const auto own = [](const energy::Material& m) { return m.bending_damping > 0.0 || m.viscous_time > 0.0; };
  return std::any_of(d.ratios.begin(), d.ratios.end(), [](double x) { return x > 0.0; }) || d.mass_damping > 0.0 ||
         d.bending_damping > 0.0 || d.viscous_time > 0.0 ||
         (d.material_damping && std::any_of(c.materials.begin(), c.materials.end(), own));
}

void check_damping(const SectionPlace& place, const Case& c) {
  if (c.dynamics.ratios.empty()) return;
  if (c.analysis == Analysis::dynamic && !c.is_staged())
    place.fail("ratio", "only the modes of analysis = \"harmonic\" have one; use `bending` and `mass`");
  if (c.analysis == Analysis::harmonic && c.harmonic.method == HarmonicSection::Method::direct)
    place.fail("ratio",
               "harmonic.method = \"direct\" has no modes; use `bending` and `mass`, or method = \"superposition\"");
}

}  // namespace

void read_harmonic(const CaseReader& reader, Case& c) {
  const SectionPlace eigen = reader.read("eigen", 0, keys_of(c.eigen));
  const SectionPlace place = reader.read(name, 0, keys_of(c.harmonic));
  const SectionPlace damping = reader.read("damping", 0, damping_keys(c.dynamics));
  check_damping(damping, c);
  if (c.analysis != Analysis::harmonic) {
    if (c.eigen.modes == 0 && c.finds_modes()) eigen.fail("modes", "0: give a number of modes");
    return;
  }
  if (!eigen.has("modes")) c.eigen.modes = 0;
  check_psd(place, c.harmonic);
  check_range(place, c.harmonic);
  check_excitation(place, c);
  const double lowest = c.harmonic.frequencies.empty() ? c.harmonic.from : c.harmonic.frequencies.front();
  if (c.harmonic.excitation == HarmonicSection::Excitation::base && c.dynamics.mass_damping > 0.0 && lowest == 0.0)
    damping.fail("mass",
                 "at 0 Hz a base that accelerates goes on for ever, and so does this drag; begin above 0 Hz, "
                 "or give `ratio` or `bending`");
  if (!c.harmonic.psd_values.empty() && !damps(c))
    damping.fail("ratio", "the key is missing; without damping, random vibration grows without bound");
}

void check_harmonic(const Case& c) {
  if (c.analysis != Analysis::harmonic) return;
  const auto refuse = [&](const std::string& key, const char* why) {
    throw UserError(fmt::format("{}: {}: with analysis = \"harmonic\" {}", c.file.string(), key, why));
  };
  if (!c.panels.empty()) refuse("[[panel]]", "there are no panels; give a [mesh]");
  if (c.dynamics.drag.active() && !c.is_staged())
    refuse("[air]", "air does not drag; remove the section, and give [damping] ratio");
  using Kind = system::Load::Kind;
  for (const system::Load& load : c.loads)
    if (load.kind == Kind::follower_pressure || load.kind == Kind::follower_moment)
      refuse("load.type",
             "loads keep their direction; use pressure instead of follower_pressure, forces instead of "
             "follower_moment");
  const auto observes = [](const Probe& p) {
    return p.kind == Probe::Kind::displacement || p.kind == Probe::Kind::reaction || p.kind == Probe::Kind::stress;
  };
  if (std::none_of(c.probes.begin(), c.probes.end(), observes))
    refuse("[[probe]]", "the response is recorded at probes; add one of type \"displacement\"");
  for (const Probe& probe : c.probes)
    if (!observes(probe) && !c.is_staged())
      refuse("probe.type",
             ("'" + probe.name + "' must be a displacement, a reaction or a stress; change it, or remove the probe")
                 .c_str());
}

}  // namespace voile::input
