// Temperatures, hinges, imperfections, and what depends on place or time; private to src/input.
#pragma once

#include <functional>
#include <string>

#include "case_read.hpp"
#include "expression.hpp"

namespace voile::input {

/// An expression of place, and of time if `time` says so. What it throws, now and later, names the key.
[[nodiscard]] PlaceExpression place_function(const SectionPlace& place, const char* key, const std::string& text,
                                             bool time);
/// Completes a temperature; the materials of `c` are there already. Throws UserError.
void read_temperature(const SectionPlace& place, const Case& c, system::Temperature& t);
/// Form finding of case `c`, which has its materials, supports and springs. Throws UserError.
void check_form(const SectionPlace& place, Case& c);
/// Reads the hinges. Throws UserError.
void read_hinges(CaseReader& reader, Case& c);
/// Throws UserError where a fold that is a number is more than 180 degrees.
void check_folds(const Case& c);
/// Completes an imperfection of case `c`. Throws UserError.
void check_imperfection(const SectionPlace& place, const Case& c, ImperfectionSection& s);
/// Where imperfections take modes of stages of the case: the stages up to the last of these keep the perfect shape, the
/// one after it begins anew. Throws UserError.
void assign_mode_stages(std::vector<Case>& stages);

}  // namespace voile::input
