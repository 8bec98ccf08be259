#include "deck_material.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace voile::cli {

namespace {

using formats::Deck;

std::string printable(std::string text) {
  std::erase_if(text, [](unsigned char c) { return c < 32; });
  return text;
}

/// The material of all plies, or what is wrong.
std::string name_of(const Deck& deck, const Deck::Section& s, std::vector<std::string>& left) {
  std::string name = s.plies.empty() ? s.material : s.plies.front().material;
  const auto other = [&](const Deck::Ply& p) { return p.material != name; };
  if (std::any_of(s.plies.begin(), s.plies.end(), other)) {
    left.push_back(
        fmt::format("{} of {}: its plies are of several materials; give their A, B and D as type \"matrices\"",
                    deck.words.section, s.elements));
    return "";
  }
  const auto at = deck.materials.find(name);
  if (at != deck.materials.end() && (at->second.young > 0.0 || !at->second.rubber.empty())) return name;
  left.push_back(fmt::format("{} of {}: material {} has no elastic constants that are known", deck.words.section,
                             s.elements, name));
  return "";
}

std::string plies_of(const std::vector<Deck::Ply>& plies, double turn) {
  std::vector<double> angles, thicknesses;
  for (const Deck::Ply& p : plies) {
    angles.push_back(p.angle + turn);
    thicknesses.push_back(p.thickness);
  }
  return fmt::format("angles = [{}]\nply_thicknesses = [{}]\n", fmt::join(angles, ", "), fmt::join(thicknesses, ", "));
}

/// Ogden's law of Abaqus has 2 mu / alpha^2 where Voile has mu / alpha.
std::string rubber_of(const Deck::Material& m) {
  if (!m.ogden && m.rubber.size() == 1)
    return fmt::format("type = \"neo_hookean\"\nshear_modulus = {}\n", 2.0 * m.rubber[0]);
  if (!m.ogden) return fmt::format("type = \"mooney_rivlin\"\nc10 = {}\nc01 = {}\n", m.rubber[0], m.rubber[1]);
  std::vector<double> mu, alpha;
  for (std::size_t k = 0; k + 1 < m.rubber.size(); k += 2) {
    mu.push_back(2.0 * m.rubber[k] / m.rubber[k + 1]);
    alpha.push_back(m.rubber[k + 1]);
  }
  return fmt::format("type = \"ogden\"\nmu = [{}]\nalpha = [{}]\n", fmt::join(mu, ", "), fmt::join(alpha, ", "));
}

}  // namespace

const mesh::Group* group_named(const mesh::MeshData& mesh, const std::string& name, bool nodes) {
  const mesh::Group* found = nullptr;
  for (const mesh::Group& g : mesh.groups)
    if (same_name(g.name, name) && (!found || nodes == (g.dimension < found->dimension))) found = &g;
  return found;
}

bool same_name(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

SquareToX square_to_x(const mesh::MeshData& mesh, const mesh::Group* group) {
  constexpr double alike = 1.0 - 1.5e-6;  // cosine of 0.1 degrees
  SquareToX of;
  if (!group) return of;
  of.triangles = group->triangles.size();
  for (const Index k : group->triangles) {
    const mesh::Triangle& t = mesh.triangles[static_cast<std::size_t>(k)];
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    of.square += std::abs(normal[0]) >= alike ? 1 : 0;
    of.normals.push_back(normal);
  }
  return of;
}

namespace {

/// Of an isotropic material: those that its results are in.
void add_axes(const Deck& deck, const Deck::Section& s, const Deck::Orientation& axes, DeckMaterial& made) {
  made.text += fmt::format("direction = [{}, {}, {}]\n", axes.direction[0], axes.direction[1], axes.direction[2]);
  if (axes.angle != 0.0)
    made.left.push_back(fmt::format("{} of {}: its orientation is that of its axes without the angle of {:g} degrees",
                                    deck.words.section, s.elements, axes.angle));
}

}  // namespace

DeckMaterial deck_material(const Deck& deck, const Deck::Section& s, const SquareToX& place) {
  DeckMaterial made;
  const std::string name = name_of(deck, s, made.left);
  if (name.empty()) return made;
  const Deck::Material& m = deck.materials.at(name);
  const bool along_z = place.square > 0 && place.square == place.triangles;
  Deck::Orientation axes{{along_z ? 0.0 : 1.0, 0.0, along_z ? 1.0 : 0.0}, 0.0};
  if (const auto at = deck.orientations.find(s.orientation); at != deck.orientations.end())
    axes = at->second;
  else if (!s.orientation.empty())
    made.left.push_back(fmt::format(
        "{} of {}: there is no orientation {} that is known; material axis 1 is [{:g}, {:g}, {:g}]", deck.words.section,
        s.elements, s.orientation, axes.direction[0], axes.direction[1], axes.direction[2]));
  else if (m.orthotropic && place.square > 0 && !along_z)
    made.left.push_back(fmt::format(
        "{} of {}: on {} of its {} triangles, square to x, material axis 1 is along z; give them a set and a "
        "section of their own",
        deck.words.section, s.elements, place.square, place.triangles));
  const Eigen::Map<const Vec3> about(axes.about.data());
  const auto against = static_cast<std::size_t>(
      std::count_if(place.normals.begin(), place.normals.end(), [&](const Vec3& n) { return n.dot(about) < 0.0; }));
  if (axes.angle != 0.0 && against > 0 && against < place.normals.size())
    made.left.push_back(fmt::format(
        "{} of {}: its orientation turns by {:g} degrees against the normals of {} of its {} triangles, with those of "
        "the others; all are turned alike; give them a section of their own",
        deck.words.section, s.elements, axes.angle, against, place.normals.size()));
  if (2 * against > place.normals.size()) axes.angle = -axes.angle;
  made.text = fmt::format("\n[[material]]               # {}\n", printable(name));
  double thickness = s.thickness;
  for (const Deck::Ply& p : s.plies) thickness += p.thickness;
  const double density = m.density + (thickness > 0.0 ? s.mass / thickness : 0.0);
  if (!m.rubber.empty()) {
    made.text += rubber_of(m) + fmt::format("thickness = {}\n", s.thickness);
    if (density > 0.0) made.text += fmt::format("density = {}\n", density);
    if (m.expansion[0] != 0.0) made.left.push_back(fmt::format("*EXPANSION of {}, which is rubber", name));
    return made;
  }
  const bool layered = m.orthotropic && (!s.plies.empty() || axes.angle != 0.0);
  if (m.orthotropic)
    made.text += fmt::format(
        "type = \"{}\"\nyoung_1 = {}\nyoung_2 = {}\npoisson_12 = {}\nshear_12 = {}\ndirection = [{}, {}, {}]\n",
        layered ? "laminate" : "orthotropic", m.young, m.young_2, m.poisson, m.shear, axes.direction[0],
        axes.direction[1], axes.direction[2]);
  else
    made.text += fmt::format("type = \"isotropic\"\nyoung = {}\npoisson = {}\n", m.young, m.poisson);
  if (!m.orthotropic && deck.orientations.contains(s.orientation)) add_axes(deck, s, axes, made);
  if (m.expansion[0] != 0.0 || m.expansion[1] != 0.0)
    made.text += m.orthotropic ? fmt::format("expansion_1 = {}\nexpansion_2 = {}\n", m.expansion[0], m.expansion[1])
                               : fmt::format("expansion = {}\n", m.expansion[0]);
  if (!m.orthotropic && m.expansion[0] != m.expansion[1])
    made.left.push_back(fmt::format("*EXPANSION, TYPE=ORTHO of {}, which is isotropic: the first is taken", name));
  if (layered)
    made.text += plies_of(s.plies.empty() ? std::vector{Deck::Ply{thickness, name, 0.0}} : s.plies, axes.angle);
  else
    made.text += fmt::format("thickness = {}\n", thickness);
  if (density > 0.0) made.text += fmt::format("density = {}\n", density);
  return made;
}

}  // namespace voile::cli
