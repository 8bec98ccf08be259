// What a case file may ask of PETSc. A case may come from a stranger: its options choose and tune solvers and print to
// the screen. Whatever writes files, loads libraries, starts programs or opens windows and ports belongs to the command
// line, which only the user writes.
#pragma once

#include <string>

namespace voile::input {

/// Why an option of a case file is refused, or "" if it is allowed. `name` with its dash, `value` "" if there is none.
[[nodiscard]] std::string refusal_of_petsc_option(const std::string& name, const std::string& value);

}  // namespace voile::input
