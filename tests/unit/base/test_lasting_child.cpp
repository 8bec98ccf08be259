#include <doctest/doctest.h>

#include <csignal>
#include <cstdlib>
#include <string>

#include "base/child_process.hpp"
#include "voile/errors.hpp"

namespace test_lasting_child {

using namespace voile;

TEST_CASE("a child that stays answers one request after the other, and another takes its place when it dies") {
  if (std::getenv("VOILE_READ_HERE")) return;  // its work is done in this process
  int asked = 0;                               // in the child
  LastingChild child("some.file", [&asked](const std::string& request) {
    if (request == "wrong") throw UserError("some.file: it is wrong");
    if (request == "dies") (void)std::raise(SIGKILL);
    return std::string(request == "long" ? 300000 : 1, 'x') + std::to_string(++asked);
  });
  CHECK(child.ask("") == "x1");
  CHECK(child.ask("long") == std::string(300000, 'x') + "2");
  CHECK_THROWS_WITH_AS(child.ask("wrong"), "some.file: it is wrong", UserError);
  CHECK(child.ask("") == "x3");
  LastingChild other("other.file",
                     [](const std::string& request) { return request; });  // has the first one's socket, too
  CHECK(other.ask("a") == "a");
  CHECK_THROWS_WITH_AS(child.ask("dies"), doctest::Contains("some.file: reading it failed (Killed)"), UserError);
  CHECK(child.ask("") == "x1");
  CHECK(asked == 0);
}

}  // namespace test_lasting_child
