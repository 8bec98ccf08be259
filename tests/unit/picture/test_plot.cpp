// Curves: what of a table is drawn, and where.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "../test_case_kit.hpp"
#include "picture/plot.hpp"

namespace test_plot {

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
  [[nodiscard]] std::string text() const {
    std::ifstream in(path);
    std::stringstream stream;
    stream << in.rdbuf();
    return stream.str();
  }
  const fs::path path;
};

/// Points of all lines of a colour, one line after the other.
std::vector<std::vector<Vec2>> lines_of(const std::string& svg, const std::string& colour) {
  std::vector<std::vector<Vec2>> lines;
  for (std::size_t at = 0;
       (at = svg.find("stroke=\"" + colour + "\" stroke-width=\"2.2\"", at)) != std::string::npos;) {
    at = svg.find("points=\"", at) + 8;
    std::istringstream in(svg.substr(at, svg.find('"', at) - at));
    std::vector<Vec2>& line = lines.emplace_back();
    char comma = ',';
    for (Vec2 p; in >> p[0] >> comma >> p[1];) line.push_back(p);
  }
  return lines;
}

const std::string blue = "#1f5f8b", red = "#c8553d";

Plot one_curve(const std::vector<double>& x, const std::vector<double>& y) {
  Plot plot;
  plot.curves.push_back({"a", x, y});
  return plot;
}

Plot line() {
  Plot plot;
  plot.x.label = "x & y";
  plot.curves.push_back({"a", {0, 1, 2, std::nan(""), 4}, {0, 10, 20, 30, 40}, Stroke::line, 0});
  plot.curves.push_back({"b", {1}, {30}, Stroke::points, 1});
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
  CHECK(has(error_of([] { (void)read_table("/proc/version/x.csv"); }), "no such table"));
}

TEST_CASE("an SVG has a line for each piece of a curve, marks, and escaped texts") {
  const File file(".svg");
  write_plot(file.path, line());
  const std::string text = file.text();
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

TEST_CASE("a decade is as long as the next one on a logarithmic scale, which leaves out what is not positive") {
  const File file(".svg");
  Plot plot = one_curve({1, 2, 3, 4, 5}, {1e-6, 0, 1e-2, 1e-1, 1});
  plot.y.logarithmic = true;
  write_plot(file.path, plot);
  const std::string text = file.text();
  const std::vector<std::vector<Vec2>> lines = lines_of(text, blue);
  REQUIRE(lines.size() == 1);  // the first point stands alone
  REQUIRE(lines[0].size() == 3);
  CHECK(lines[0][0][1] - lines[0][1][1] == doctest::Approx(lines[0][1][1] - lines[0][2][1]).epsilon(1e-3));
  CHECK(has(text, "<circle"));
  CHECK(has(text, ">10⁻⁶<"));
  CHECK(has(text, ">1<"));
  plot.y.range = {1e-2, 1};
  write_plot(file.path, plot);
  CHECK(has(file.text(), ">0.02<") == false);
  CHECK(has(file.text(), ">0.1<"));
  Plot flat = one_curve({1, 2}, {3, 3 + 1e-15});
  write_plot(file.path, flat);
  CHECK(lines_of(file.text(), blue).size() == 1);
  flat.curves[0].y = {-1e308, 1e308};
  CHECK(has(error_of([&] { write_plot(file.path, flat); }), "too large"));
  plot.curves[0].y.assign(5, -1.0);
  CHECK(has(error_of([&] { write_plot(file.path, plot); }), "positive numbers"));
}

TEST_CASE("a range cuts curves off at its ends, and leaves marks out") {
  const File file(".svg");
  Plot plot = one_curve({0, 10}, {0, 10});
  plot.curves.push_back({"b", {1, 20}, {1, 1}, Stroke::points, 1});
  plot.x.range = {0, 10};
  plot.y.range = {2, 4};
  plot.legend = Legend::none;
  write_plot(file.path, plot);
  const std::vector<std::vector<Vec2>> lines = lines_of(file.text(), blue);
  REQUIRE(lines.size() == 1);
  REQUIRE(lines[0].size() == 2);
  // From 20 to 40 % of the width, over the whole height.
  Plot whole = plot;
  whole.y.range = {0, 10};
  write_plot(file.path, whole);
  const std::vector<std::vector<Vec2>> all = lines_of(file.text(), blue);
  const double width = all[0][1][0] - all[0][0][0], height = all[0][0][1] - all[0][1][1];
  CHECK(lines[0][1][0] - lines[0][0][0] == doctest::Approx(0.2 * width).epsilon(0.02));
  CHECK(lines[0][0][1] - lines[0][1][1] == doctest::Approx(height).epsilon(0.001));
  for (const double low : {9.999999999999999, -1e308}) {
    plot.x.range = {low, low < 0 ? 1e308 : 10.0};
    CHECK(has(error_of([&] { write_plot(file.path, plot); }), "double precision"));
  }
  plot.x.range = {0, 10};
  plot.curves.erase(plot.curves.begin());
  write_plot(file.path, plot);
  CHECK(!has(file.text(), "<circle"));
}

TEST_CASE("dashes run evenly along a curve, whatever the distance of its points") {
  const File file(".svg");
  Plot plot;
  std::vector<double> x;
  for (int i = 0; i <= 1000; ++i) x.push_back(i);
  plot.curves.push_back({"a", x, std::vector<double>(x.size(), 1.0), Stroke::dashed});
  plot.curves.push_back({"b", {0, 1000}, {2, 2}, Stroke::dashed, 1});
  plot.legend = Legend::none;
  write_plot(file.path, plot);
  const std::string text = file.text();
  const std::vector<std::vector<Vec2>> fine = lines_of(text, blue), coarse = lines_of(text, red);
  CHECK(fine.size() > 50);
  REQUIRE(fine.size() == coarse.size());
  for (std::size_t i = 0; i < fine.size(); ++i) {
    CHECK(fine[i].front()[0] == doctest::Approx(coarse[i].front()[0]).epsilon(1e-4));
    CHECK(fine[i].back()[0] == doctest::Approx(coarse[i].back()[0]).epsilon(1e-4));
  }
}

TEST_CASE("equal axes make a circle round; the legend is where it is asked for") {
  const File file(".svg");
  std::vector<double> x, y;
  for (int i = 0; i <= 360; ++i) {
    x.push_back(5.0 + std::cos(i * 0.0174532925));
    y.push_back(std::sin(i * 0.0174532925));
  }
  Plot plot = one_curve(x, y);
  plot.equal = true;
  write_plot(file.path, plot);
  Vec2 low = Vec2::Constant(1e9), high = -low;
  const std::vector<std::vector<Vec2>> lines = lines_of(file.text(), blue);
  REQUIRE(lines.size() == 1);
  for (const Vec2& p : lines[0]) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  CHECK(high[0] - low[0] == doctest::Approx(high[1] - low[1]).epsilon(1e-3));
  plot.curves.push_back({"", {5}, {0}, Stroke::points, 1});
  plot.curves.push_back({"second", {5}, {0}, Stroke::line, 2});
  std::array<double, 2> left{};
  for (const auto& [legend, at] : {std::pair{Legend::top_left, 0U}, std::pair{Legend::top_right, 1U}}) {
    plot.legend = legend;
    write_plot(file.path, plot);
    const std::string text = file.text();
    const std::size_t label = text.rfind("<text", text.find(">second<"));
    REQUIRE(std::sscanf(text.c_str() + label, "<text x=\"%lf\"", &left[at]) == 1);
  }
  CHECK(left[0] < 200.0);
  CHECK(left[1] > 600.0);
  plot.legend = Legend::none;
  write_plot(file.path, plot);
  CHECK(!has(file.text(), "second"));
}

}  // namespace test_plot
