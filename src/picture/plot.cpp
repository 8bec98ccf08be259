#include "plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "axis.hpp"
#include "canvas.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

namespace {

constexpr std::array<Bytes3, 6> colours{
    {{31, 95, 139}, {200, 85, 61}, {63, 125, 78}, {138, 90, 156}, {184, 134, 11}, {68, 68, 68}}};
const Bytes3 grid{228, 230, 233}, frame{120, 124, 130};
constexpr double letters = 19.0, key = 28.0, dash = 7.0, gap = 5.0, line_width = 2.2, ring = 4.5;  // [pixels]

const Bytes3& colour_of(const Curve& c) {
  return colours[c.colour % colours.size()];
}

/// Numbers on an axis, as many as have room.
int tick_count(const Axis& axis, double room, int most) {
  return std::clamp(static_cast<int>(axis.pixels() / room), 2, most);
}

void draw_axes(Canvas& canvas, const Plot& plot, const Axis& x, const Axis& y) {
  for (const auto& [place, text] : x.numbers(tick_count(x, 3.5 * letters, 7))) {
    canvas.line({{place, y.begin}, {place, y.end}}, grid, 1.0);
    canvas.text({place, y.begin + 1.25 * letters}, text, 0.9 * letters, ink, Align::centre);
  }
  for (const auto& [place, text] : y.numbers(tick_count(y, 2.5 * letters, 6))) {
    canvas.line({{x.begin, place}, {x.end, place}}, grid, 1.0);
    canvas.text({x.begin - 0.5 * letters, place + 0.3 * letters}, text, 0.9 * letters, ink, Align::right);
  }
  canvas.line({{x.begin, y.end}, {x.begin, y.begin}, {x.end, y.begin}}, frame, 1.3);
  canvas.text({x.end, y.begin + 2.7 * letters}, plot.x.label, letters, ink, Align::right);
  // Beside the axis' end, where it can be read without turning the head.
  canvas.text({x.begin, y.end - 0.7 * letters}, plot.y.label, letters, ink, Align::left);
  if (!plot.title.empty())
    canvas.text({0.5 * plot.width, 1.5 * letters}, plot.title, 1.15 * letters, ink, Align::centre);
}

/// The part of a piece of line that is between the axes; false if there is none (Liang and Barsky).
bool clip(const Axis& x, const Axis& y, Vec2& a, Vec2& b) {
  double from = 0.0, to = 1.0;
  const Vec2 along = b - a;
  for (const int k : {0, 1}) {
    const Axis& axis = k == 0 ? x : y;
    const double low = std::min(axis.begin, axis.end), high = std::max(axis.begin, axis.end);
    if (along[k] == 0.0) {
      if (a[k] < low || a[k] > high) return false;
      continue;
    }
    const double s = (low - a[k]) / along[k], t = (high - a[k]) / along[k];
    from = std::max(from, std::min(s, t));
    to = std::min(to, std::max(s, t));
  }
  if (from > to) return false;
  const Vec2 start = a;
  a = start + from * along;
  b = start + to * along;
  return true;
}

/// Strokes and gaps along a line take turns.
void draw_dashes(Canvas& canvas, const std::vector<Vec2>& points, const Bytes3& colour) {
  double place = 0.0;  // in the pattern
  std::vector<Vec2> stroke{points.front()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double length = (points[i] - points[i - 1]).norm();
    for (double done = 0.0; done < length;) {
      const double step = std::min(length - done, (place < dash ? dash : dash + gap) - place);
      done += step;
      const Vec2 at = points[i - 1] + done / length * (points[i] - points[i - 1]);
      if (place < dash) stroke.push_back(at);
      place += step;
      if (place < dash - 1e-9) continue;
      if (stroke.size() > 1) canvas.line(stroke, colour, line_width);
      if (place >= dash + gap - 1e-9) place = 0.0;
      stroke = {at};
    }
  }
  if (stroke.size() > 1) canvas.line(stroke, colour, line_width);
}

void draw_stroke(Canvas& canvas, const std::vector<Vec2>& points, Stroke stroke, const Bytes3& colour) {
  if (points.size() < 2) return;
  if (stroke == Stroke::dashed)
    draw_dashes(canvas, points, colour);
  else
    canvas.line(points, colour, line_width);
}

/// A run of points without a gap.
void draw_run(Canvas& canvas, const Curve& c, const std::vector<Vec2>& points, const Axis& x, const Axis& y) {
  if (c.stroke == Stroke::points || points.size() == 1) {
    for (Vec2 p : points)
      if (Vec2 same = p; clip(x, y, p, same)) canvas.mark(p, colour_of(c), ring);
    return;
  }
  std::vector<Vec2> inside;
  for (std::size_t i = 1; i < points.size(); ++i) {
    Vec2 a = points[i - 1], b = points[i];
    const bool seen = clip(x, y, a, b);
    if (!seen || inside.empty() || inside.back() != a) {
      draw_stroke(canvas, inside, c.stroke, colour_of(c));
      inside.clear();
      if (seen) inside.push_back(a);
    }
    if (seen) inside.push_back(b);
  }
  draw_stroke(canvas, inside, c.stroke, colour_of(c));
}

void draw_curve(Canvas& canvas, const Curve& c, const Axis& x, const Axis& y) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i <= c.x.size(); ++i) {
    const bool there = i < c.x.size() && x.can_show(c.x[i]) && y.can_show(c.y[i]);
    if (there) points.emplace_back(x.place(c.x[i]), y.place(c.y[i]));
    if (there || points.empty()) continue;
    draw_run(canvas, c, points, x, y);
    points.clear();
  }
}

struct LegendSize {
  double width = 0.0, height = 0.0;
};

/// Nothing of a single curve, which the axes name.
LegendSize legend_size(const Plot& plot) {
  LegendSize size;
  if (plot.curves.size() < 2 || plot.legend == Legend::none) return size;
  for (const Curve& c : plot.curves) {
    if (c.label.empty()) continue;
    size.width = std::max(size.width, text_width(c.label, 0.9 * letters) + key + 10.0);
    size.height += 1.25 * letters;
  }
  return size;
}

void draw_legend(Canvas& canvas, const Plot& plot, double left, double top) {
  for (const Curve& c : plot.curves) {
    if (c.label.empty()) continue;
    const double middle = top - 0.3 * letters;
    if (c.stroke == Stroke::points)
      canvas.mark({left + 0.5 * key, middle}, colour_of(c), ring);
    else
      draw_stroke(canvas, {{left, middle}, {left + key, middle}}, c.stroke, colour_of(c));
    canvas.text({left + key + 10.0, top}, c.label, 0.9 * letters, ink, Align::left);
    top += 1.25 * letters;
  }
}

void place_legend(Canvas& canvas, const Plot& plot, const LegendSize& size, const Axis& x, const Axis& y) {
  if (size.height == 0.0) return;
  const bool left = plot.legend == Legend::top_left || plot.legend == Legend::bottom_left;
  const bool bottom = plot.legend == Legend::bottom_left || plot.legend == Legend::bottom_right;
  if (plot.legend == Legend::beside) {
    draw_legend(canvas, plot, x.end + letters, y.end + letters);
    return;
  }
  const double at = left ? x.begin + 0.8 * letters : x.end - size.width - 4.0;
  const double top = bottom ? y.begin - size.height + 0.5 * letters : y.end + letters;
  // Readable where curves run behind it.
  canvas.box({at - 4.0, top - 0.9 * letters}, {at + size.width + 4.0, top - 0.9 * letters + size.height},
             {255, 255, 255}, 0.8);
  draw_legend(canvas, plot, at, top);
}

/// Makes a unit as long across as upwards, by showing more of one axis.
void equalise(Axis& x, Axis& y) {
  const double unit = std::max(x.width() / x.pixels(), y.width() / y.pixels());
  x.widen_to(unit * x.pixels());
  y.widen_to(unit * y.pixels());
}

}  // namespace

void write_plot(const fs::path& file, const Plot& plot) {
  const std::string ending = file.extension().string();
  if (ending != ".svg" && ending != ".png")
    throw UserError(fmt::format("--output {}: the name must end in .svg or .png", file.string()));
  Axis x(plot.x), y(plot.y);
  for (const Curve& c : plot.curves)
    for (std::size_t i = 0; i < c.x.size(); ++i)
      if (x.can_show(c.x[i]) && y.can_show(c.y[i])) {
        x.add(c.x[i]);
        y.add(c.y[i]);
      }
  if (x.empty())
    throw UserError(fmt::format("{}: there is nothing to draw: no row has {}numbers in both columns", file.string(),
                                plot.x.logarithmic || plot.y.logarithmic ? "positive " : ""));
  x.finish();
  y.finish();
  const std::unique_ptr<Canvas> canvas =
      ending == ".svg" ? svg_canvas(plot.width, plot.height) : pixel_canvas(plot.width, plot.height);
  double label = 0.0;
  const LegendSize legend = legend_size(plot);
  y.begin = plot.height - 3.4 * letters;
  y.end = (plot.title.empty() ? 0.8 : 2.5) * letters + (plot.y.label.empty() ? 0.0 : 1.4 * letters);
  for (const auto& [place, text] : y.numbers(tick_count(y, 2.5 * letters, 6)))
    label = std::max(label, text_width(text, 0.9 * letters));
  x.begin = label + 1.6 * letters;
  x.end = plot.width - 1.5 * letters -
          (legend.height > 0.0 && plot.legend == Legend::beside ? legend.width + letters : 0.0);
  if (x.end - x.begin < 3.0 * letters || y.begin - y.end < 2.0 * letters)
    throw UserError(fmt::format("--size {}x{}: that is too small for the numbers and the legend of the diagram",
                                plot.width, plot.height));
  if (plot.equal) equalise(x, y);
  draw_axes(*canvas, plot, x, y);
  for (const Curve& c : plot.curves) draw_curve(*canvas, c, x, y);
  place_legend(*canvas, plot, legend, x, y);
  canvas->write(file);
}

}  // namespace voile::picture
