#include "deck_material.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

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
  if (at != deck.materials.end() && at->second.young > 0.0) return name;
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

}  // namespace

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
  }
  return of;
}

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
  made.text = fmt::format("\n[[material]]               # {}\n", printable(name));
  const bool layered = m.orthotropic && (!s.plies.empty() || axes.angle != 0.0);
  if (m.orthotropic)
    made.text += fmt::format(
        "type = \"{}\"\nyoung_1 = {}\nyoung_2 = {}\npoisson_12 = {}\nshear_12 = {}\ndirection = [{}, {}, {}]\n",
        layered ? "laminate" : "orthotropic", m.young, m.young_2, m.poisson, m.shear, axes.direction[0],
        axes.direction[1], axes.direction[2]);
  else
    made.text += fmt::format("type = \"isotropic\"\nyoung = {}\npoisson = {}\n", m.young, m.poisson);
  double thickness = s.thickness;
  for (const Deck::Ply& p : s.plies) thickness += p.thickness;
  if (layered)
    made.text += plies_of(s.plies.empty() ? std::vector{Deck::Ply{thickness, name, 0.0}} : s.plies, axes.angle);
  else
    made.text += fmt::format("thickness = {}\n", thickness);
  if (m.density > 0.0) made.text += fmt::format("density = {}\n", m.density);
  return made;
}

}  // namespace voile::cli
