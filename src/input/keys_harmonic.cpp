// Keys of the frequency response.
#include "keys_common.hpp"

namespace voile::input {

namespace {

std::vector<Key> excitation_keys(HarmonicSection& s) {
  return {{.name = "method",
           .slot = choice(s.method, {{"superposition", HarmonicSection::Method::superposition},
                                     {"direct", HarmonicSection::Method::direct}}),
           .meaning = "`superposition`: of modes, completed by static corrections. `direct`: the whole system at every "
                      "frequency, without modes and their damping ratios."},
          {.name = "excitation",
           .slot = choice(s.excitation,
                          {{"loads", HarmonicSection::Excitation::loads}, {"base", HarmonicSection::Excitation::base}}),
           .meaning = "`loads`: loads and temperatures that are not `constant` follow a cosine, with their values as "
                      "amplitudes. `base`: all supports, and what springs are fixed to, move along `direction`."},
          {.name = "direction",
           .slot = &s.direction,
           .meaning = "Of the base; its length does not count. Needed for `base`.",
           .absent = "none"},
          {.name = "acceleration",
           .slot = &s.acceleration,
           .meaning = "Amplitude of the acceleration of the base.",
           .unit = "m/s^2",
           .range = positive}};
}

std::vector<Key> frequency_keys(HarmonicSection& s) {
  return {{.name = "from",
           .slot = &s.from,
           .meaning = "Lowest frequency. 0, if this key is not given: the first of `psd_frequencies`.",
           .unit = "Hz",
           .range = not_negative},
          {.name = "to",
           .slot = &s.to,
           .meaning = "Highest frequency. 0, if this key is not given: the last of `psd_frequencies`.",
           .unit = "Hz",
           .range = not_negative},
          {.name = "points",
           .slot = &s.points,
           .meaning = "How many frequencies. `superposition` adds those of the modes, and where their peaks are half "
                      "as high in power.",
           .range = {2}},
          {.name = "spacing",
           .slot = choice(s.spacing, {{"logarithmic", HarmonicSection::Spacing::logarithmic},
                                      {"linear", HarmonicSection::Spacing::linear}}),
           .meaning = "Whether their ratios or their differences are equal."},
          {.name = "frequencies",
           .slot = &s.frequencies,
           .meaning = "The frequencies themselves, ascending, instead of `from`, `to`, `points` and `spacing`.",
           .unit = "Hz",
           .range = positive,
           .absent = "none"},
          {.name = "field_frequencies",
           .slot = &s.field_frequencies,
           .meaning = "Where fields of displacement, stress and reaction are written as amplitudes, ascending "
                      "(docs/reference/results.md).",
           .unit = "Hz",
           .range = positive,
           .absent = "none"},
          {.name = "psd_frequencies",
           .slot = &s.psd_frequencies,
           .meaning = "Random vibration: frequencies of the power spectral density of the excitation, ascending. "
                      "Between them it is straight in double logarithmic scale, outside them 0.",
           .unit = "Hz",
           .range = positive,
           .absent = "none"},
          {.name = "psd_values",
           .slot = &s.psd_values,
           .meaning = "Its values (one-sided): of the acceleration of the base in (m/s^2)^2/Hz, or of the factor on "
                      "the loads in 1/Hz. Root mean squares of the probes are in `summary.json`.",
           .range = positive,
           .absent = "none"}};
}

}  // namespace

std::vector<Key> keys_of(HarmonicSection& s) {
  return joined(excitation_keys(s), frequency_keys(s));
}

}  // namespace voile::input
