// Names with a star, and names of several groups.
#include <doctest/doctest.h>

#include "base/group_list.hpp"
#include "base/wildcard.hpp"

namespace test_wildcard {

using namespace voile;

TEST_CASE("a star stands for the same text everywhere, and for a letter at least") {
  CHECK(star_of("sleeve_*/3", "sleeve_left/3") == "left");
  CHECK(star_of("*/1-front_*/2", "l/1-front_l/2") == "l");
  CHECK_FALSE(star_of("*/1-front_*/2", "l/1-front_r/2"));
  CHECK_FALSE(star_of("sleeve_*", "sleeve_"));
  CHECK_FALSE(star_of("sleeve_*", "slee"));
  CHECK_FALSE(star_of("sleeve", "sleeve"));
  CHECK(star_of("*", "a*b") == "a*b");
  CHECK(with_star("*/1-front_*/2", "a*b") == "a*b/1-front_a*b/2");
}

TEST_CASE("several groups are one name, and come back from it") {
  CHECK(groups_of(group_name({"front/2", "back/2"})) == std::vector<std::string>{"front/2", "back/2"});
  CHECK(groups_of("waist") == std::vector<std::string>{"waist"});
}

}  // namespace test_wildcard
