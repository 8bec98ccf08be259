// Curves: what of a table is drawn, and where.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "../test_case_kit.hpp"
#include "voile/picture/plot.hpp"

using namespace voile;
using namespace voile::testing;
using namespace voile::picture;
namespace fs = std::filesystem;

namespace {

struct File {
  explicit File(const char* ending)
      : path(fs::temp_directory_path() / fmt::format("voile_plot_{}{}", ::getpid(), ending)) {}
  ~File() { fs::remove(path); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  const fs::path path;
};

Plot line() {
  Plot plot;
  plot.x_label = "x & y";
  plot.curves.push_back({"a", {0, 1, 2, std::nan(""), 4}, {0, 10, 20, 30, 40}, false, 0});
  plot.curves.push_back({"b", {1}, {30}, true, 1});
  return plot;
}

}  // namespace

TEST_CASE("tables have comments, gaps and half a line at the end") {
  const File file(".csv");
  std::ofstream(file.path) << "# Source: x\nstep, load_factor,w\n1,0.5,\n2,1,3\n3,1.5";
  const Table table = read_table(file.path);
  CHECK(table.names == std::vector<std::string>{"step", "load_factor", "w"});
  CHECK(table.column("load_factor") == std::vector<double>{0.5, 1});
  CHECK(std::isnan(table.column("w")[0]));
  CHECK(has(error_of([&] { (void)table.column("load_facto"); }), "did you mean 'load_factor'"));
  std::ofstream(file.path) << "# nothing\n";
  CHECK(has(error_of([&] { (void)read_table(file.path); }), "empty"));
  CHECK(has(error_of([] { (void)read_table("/nonexistent.csv"); }), "no such table"));
}

TEST_CASE("an SVG has a line for each piece of a curve, marks, and escaped texts") {
  const File file(".svg");
  write_plot(file.path, line());
  std::ifstream in(file.path);
  std::stringstream stream;
  stream << in.rdbuf();
  const std::string text = stream.str();
  CHECK(has(text, "x &amp; y"));
  // Three points of a line lie evenly; the fourth is a gap, the fifth stands alone.
  const std::size_t at = text.find("stroke=\"#1f5f8b\"");
  REQUIRE(at != std::string::npos);
  std::array<double, 6> p{};
  REQUIRE(std::sscanf(text.c_str() + text.find("points=\"", at), "points=\"%lf,%lf %lf,%lf %lf,%lf \"", &p[0], &p[1],
                      &p[2], &p[3], &p[4], &p[5]) == 6);
  CHECK(p[2] - p[0] == doctest::Approx(p[4] - p[2]).epsilon(1e-3));
  CHECK(p[1] - p[3] == doctest::Approx(p[3] - p[5]).epsilon(1e-3));
  CHECK(p[2] > p[0]);
  CHECK(p[1] > p[3]);
  CHECK(has(text, "<circle"));
}

TEST_CASE("a PNG of curves has their colours; what cannot be drawn says why") {
  const File file(".png");
  write_plot(file.path, line());
  const Image image = read_png(file.path);
  int blue = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) blue += image.at(x, y)[2] == 139 && image.at(x, y)[0] == 31;
  CHECK(blue > 300);
  CHECK(has(error_of([&] { write_plot(file.path, Plot{}); }), "nothing to draw"));
  CHECK(has(error_of([] { write_plot("x.pdf", line()); }), ".svg or .png"));
}
