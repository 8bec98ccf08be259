#include "form_tension.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "validity.hpp"

namespace voile::record {

namespace {

struct Principal {
  double most, least;
};

Principal principal(const Vec3& n) {
  const double mean = 0.5 * (n[0] + n[1]), radius = std::hypot(0.5 * (n[0] - n[1]), n[2]);
  return {mean + radius, mean - radius};
}

std::string range_text(double least, double most) {
  const std::string low = fmt::format("{:.4g}", least), high = fmt::format("{:.4g}", most);
  return low == high ? low : low + " to " + high;
}

}  // namespace

TensionChange tension_change(const energy::Sheet& sheet, const system::TriangleFields& fields) {
  constexpr double none = std::numeric_limits<double>::infinity();
  TensionChange c{none, -none, none, -none};
  double largest = 0.0;
  for (Index t = 0; t < sheet.mesh().triangle_count(); ++t) {
    const Vec3 force = Eigen::Map<const Vec3>(&fields.membrane_force[3 * static_cast<std::size_t>(t)]);
    const Vec3& given = sheet.material(t).prestress;
    const Principal now = principal(force), wanted = principal(given), off = principal(force - given);
    c.least = std::min(c.least, now.least);
    c.most = std::max(c.most, now.most);
    c.given_least = std::min(c.given_least, wanted.least);
    c.given_most = std::max(c.given_most, wanted.most);
    const double change = std::max(std::abs(off.most), std::abs(off.least));
    if (change <= largest) continue;
    largest = change;
    c.at = t;
  }
  if (c.given_most > 0.0) c.error = largest / c.given_most;
  return c;
}

std::string text_of(const TensionChange& c, const energy::Sheet& sheet, const std::string& unit) {
  std::string text = fmt::format("[form]: in equilibrium the sheet pulls with {} {} where the prestress is {}",
                                 range_text(c.least, c.most), unit, range_text(c.given_least, c.given_most));
  if (c.at == no_index) return text;
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const Vec3 place = (mesh.start_corner(c.at, 0) + mesh.start_corner(c.at, 1) + mesh.start_corner(c.at, 2)) / 3.0;
  text += fmt::format("; it is off by {} at ({:.4g}, {:.4g}, {:.4g}) m", percent_text(c.error), place[0], place[1],
                      place[2]);
  if (c.error > tension_limit)
    text += ", since the sheet is stiff for cells of this size; use finer and even cells, or check constant loads";
  return text;
}

}  // namespace voile::record
