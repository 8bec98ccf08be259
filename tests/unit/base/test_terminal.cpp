// Words in colour.
#include <doctest/doctest.h>

#include "base/terminal.hpp"

namespace voile::test_terminal {

TEST_CASE("words in colour begin a line or follow the program's name there") {
  CHECK(coloured("", true).empty());
  CHECK(coloured("voile: error: a\n", true) == "voile: \033[1;31merror:\033[0m a\n");
  CHECK(coloured("a\nwarning: b\nc", true) == "a\n\033[1;35mwarning:\033[0m b\nc");
  for (const char* plain : {"a warning: b", "voile: a", "no error: b\n", "errors: c", "voile: ", "\n\n"})
    CHECK(coloured(plain, true) == plain);
  CHECK(coloured("error: a", false) == "error: a");
  CHECK(coloured("x\nerror: a", false) == "x\n\033[1;31merror:\033[0m a");
}

TEST_CASE("a program that has not asked for streams of its own rewrites nothing") {
  CHECK_FALSE(rewrites_progress());
  show_progress("not shown");
}

}  // namespace voile::test_terminal
