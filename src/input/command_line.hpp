// Sharing the command line with PETSc: which words are whose.
//
// A word that starts with a single dash and a letter and is longer than two characters is an option of PETSc; the word
// after it is its value unless that starts with a dash and a letter (or is one of Voile's --words).
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace voile::input {

struct SplitArguments {
  std::vector<std::string> own;    ///< Voile's words, without the program's name
  std::vector<std::string> petsc;  ///< PETSc's words in their order
};

[[nodiscard]] SplitArguments split_arguments(const std::vector<std::string>& arguments);

/// Options and values ("" if none) of a text like "-snes_rtol 1e-10 -ksp_view".
/// Throws UserError if a word is neither an option nor the value of one.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> petsc_pairs(const std::string& text);

}  // namespace voile::input
