// The seam of seams.csv that was open widest.
#include "picture/worst_seam.hpp"

#include "../test_results_kit.hpp"

namespace test_worst_seam {

using namespace voile;
using namespace voile::testing;

TEST_CASE("the seam that was open widest is found by the column of its gap, in any order") {
  const Folder folder;
  fs::create_directories(folder.path);
  const fs::path file = folder.path / "seams.csv";
  const auto found = [&](const std::string& text) {
    std::ofstream(file) << text;
    return picture::worst_seam(file);
  };
  CHECK_FALSE(picture::worst_seam(folder.path / "none.csv").has_value());
  CHECK_FALSE(found("seam,length_1,gap\n").has_value());
  const auto worst = found("seam,length_1,gap,edge_1\na,9,1e-4,p/0\nb,1,3e-4,p/1\nc,5,2e-4,p/2\n");
  REQUIRE(worst.has_value());
  CHECK(worst->name == "b");
  CHECK(worst->gap == doctest::Approx(3e-4));
  for (const char* text : {"seam,gap\na,wide\n", "seam,length_1\na,1\n", "seam,length_1,gap\na,1\n"})
    CHECK(has(error_of([&] { (void)found(text); }), "this is no table of seams"));
}

}  // namespace test_worst_seam
