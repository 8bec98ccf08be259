// Messages of the errors that tests expect, and case files with one thing changed.
#pragma once

#include <doctest/doctest.h>

#include <concepts>
#include <string>

#include "input/case.hpp"
#include "test_text.hpp"
#include "voile/errors.hpp"

namespace voile::testing {

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// What a user would read of the mistake that an action finds.
template <std::invocable Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const UserError& e) {
    return e.what();
  }
  return "no error";
}

/// The same of the text of a case file.
inline std::string error_of(const std::string& text) {
  return error_of([&] { (void)input::parse_case(text, "case.toml"); });
}

}  // namespace voile::testing
