#include "views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "base/bytes.hpp"
#include "base/text.hpp"
#include "session.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

struct Node {
  Vec3 place;
  double value;
};

/// Nodes of each kind of element that a view of scalars may have; the last letter is Gmsh's.
std::size_t nodes_of(char shape) {
  constexpr const char* shapes = "PLTQSHIY";
  constexpr std::array<std::size_t, 8> count{1, 2, 3, 4, 4, 8, 6, 5};
  const char* at = std::find(shapes, shapes + count.size(), shape);
  return at == shapes + count.size() ? 0 : count[static_cast<std::size_t>(at - shapes)];
}

/// The nodes of all elements, with their values.
std::vector<Node> nodes_of_view(const std::string& file, int view) {
  std::vector<std::string> kinds;
  std::vector<int> counts;
  std::vector<std::vector<double>> data;
  gmsh::view::getListData(view, kinds, counts, data);
  std::vector<Node> nodes;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const std::size_t n = kinds[k].size() == 2 && kinds[k][0] == 'S' ? nodes_of(kinds[k][1]) : 0;
    if (n == 0)
      throw UserError(
          fmt::format("{}: its view has elements of the kind {}; sizes are a number at each node of points, lines, "
                      "triangles, quadrangles or solids of first order (SP, SL, ST, SQ, SS, SH, SI, SY)",
                      file, printable(kinds[k])));
    const std::size_t stride = counts[k] > 0 ? data[k].size() / static_cast<std::size_t>(counts[k]) : 0;
    if (stride > 4 * n)
      throw UserError(
          fmt::format("{}: its view has {} time steps; save the one whose sizes are wanted as a view of its own", file,
                      (stride - 3 * n) / n));
    for (std::size_t e = 0; stride >= 4 * n && e < data[k].size(); e += stride)
      for (std::size_t i = 0; i < n; ++i)
        nodes.push_back({{data[k][e + i], data[k][e + n + i], data[k][e + 2 * n + i]}, data[k][e + 3 * n + i]});
  }
  if (nodes.empty()) throw UserError(fmt::format("{}: its view has no elements with values", file));
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.place[0] < b.place[0]; });
  return nodes;
}

/// `nodes` in the order of x: outwards from there until x alone is further away than the nearest found.
double nearest_value(const std::vector<Node>& nodes, const Vec3& x) {
  const auto begin = std::lower_bound(nodes.begin(), nodes.end(), x[0],
                                      [](const Node& node, double at) { return node.place[0] < at; });
  double best = std::numeric_limits<double>::infinity(), value = 0.0;
  const auto look = [&](const Node& node) {
    if (const double d = (node.place - x).norm(); d < best) best = d, value = node.value;
    return std::abs(node.place[0] - x[0]) < best;
  };
  for (auto at = begin; at != nodes.end() && look(*at); ++at) continue;
  for (auto at = begin; at != nodes.begin() && look(*(at - 1)); --at) continue;
  return value;
}

std::vector<double> values_at(const std::string& file, const std::vector<Vec3>& points) {
  gmsh::open(file);
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log)
    if (line.starts_with("Error")) throw UserError(fmt::format("{}: Gmsh: {}", file, printable(line)));
  std::vector<int> views;
  gmsh::view::getTags(views);
  if (views.size() != 1)
    throw UserError(fmt::format("{}: it has {} views; sizes are one view of numbers, as in View \"size\" {{ ... }};",
                                file, views.size()));
  const std::vector<Node> nodes = nodes_of_view(file, views[0]);
  std::vector<double> values, found;
  for (const Vec3& x : points) {
    gmsh::view::probe(views[0], x[0], x[1], x[2], found, 0, 1);
    // In an element without area Gmsh divides by zero.
    values.push_back(found.size() == 1 && std::isfinite(found[0]) ? found[0] : nearest_value(nodes, x));
  }
  return values;
}

}  // namespace

std::string view_at_points(const std::string& message_file) {
  std::ifstream message(message_file, std::ios::binary);
  ByteReader in(std::string(std::istreambuf_iterator<char>(message), {}));
  std::string file;
  std::vector<Vec3> points;
  in.get(file);
  in.get(points);
  try {
    const Session session(Rights::confined);
    ByteWriter out;
    out.put(values_at(file, points));
    return out.take();
  } catch (const std::string& text) {  // what Gmsh throws
    throw UserError(fmt::format("{}: Gmsh: {}", file, printable(text)));
  }
}

}  // namespace voile::formats
