#include "deck_loads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "deck_material.hpp"

namespace voile::cli {

namespace {

using formats::Deck;

/// Mass per area; 0 if it is not known.
double mass_of(const Deck& deck, const Deck::Section& s) {
  double mass = 0.0;
  const auto add = [&](const std::string& material, double thickness) {
    const auto at = deck.materials.find(material);
    mass += at == deck.materials.end() ? 0.0 : thickness * at->second.density;
  };
  if (s.plies.empty()) add(s.material, s.thickness);
  for (const Deck::Ply& p : s.plies) add(p.material, p.thickness);
  return mass;
}

/// Sections whose elements make up the group, or none.
std::vector<const Deck::Section*> sections_of(const Deck& deck, const mesh::MeshData& mesh, const mesh::Group& group) {
  std::vector<const Deck::Section*> found;
  std::vector<Index> covered;
  for (const Deck::Section& s : deck.sections) {
    const mesh::Group* elements = group_named(mesh, s.elements);
    if (!elements || !std::includes(group.triangles.begin(), group.triangles.end(), elements->triangles.begin(),
                                    elements->triangles.end()))
      continue;
    found.push_back(&s);
    covered.insert(covered.end(), elements->triangles.begin(), elements->triangles.end());
  }
  std::sort(covered.begin(), covered.end());
  return covered == group.triangles ? found : std::vector<const Deck::Section*>{};
}

}  // namespace

void divide_gravity(Deck& deck, const mesh::MeshData& mesh, std::vector<std::string>& left) {
  std::vector<Deck::Load> loads;
  for (const Deck::Load& l : deck.loads) {
    const bool apart = l.kind == Deck::Load::Kind::gravity && !l.where.empty();
    const mesh::Group* group = apart ? group_named(mesh, l.where) : nullptr;
    if (!apart || (group && group->triangles.size() == mesh.triangles.size())) {
      loads.push_back(l);
      continue;
    }
    const auto sections = group ? sections_of(deck, mesh, *group) : std::vector<const Deck::Section*>{};
    for (const Deck::Section* s : sections) {
      Deck::Load part = l;
      part.kind = Deck::Load::Kind::area;
      part.where = s->elements;
      for (double& x : part.vector) x *= mass_of(deck, *s);
      loads.push_back(part);
    }
    if (!sections.empty()) continue;
    left.push_back(fmt::format("*DLOAD {}, GRAV: gravity acts on the whole sheet", l.where));
    loads.push_back(l);
  }
  deck.loads = std::move(loads);
}

std::string temperature_of(const Deck& deck, const mesh::MeshData& mesh, std::vector<std::string>& left) {
  double before = 0.0;
  std::optional<double> after;
  for (const Deck::Temperature& t : deck.temperatures) {
    const mesh::Group* group = group_named(mesh, t.where, true);
    if (!group || group->vertices.size() < mesh.positions.size()) {
      left.push_back(fmt::format("{} {}: it is not of all nodes; give a [[temperature]] with a surface as its group",
                                 t.initial ? "*INITIAL CONDITIONS, TYPE=TEMPERATURE" : "*TEMPERATURE", t.where));
      continue;
    }
    if (t.initial)
      before = t.value;
    else
      after = t.value;
  }
  return after ? fmt::format("\n[[temperature]]\nchange = \"{}\"\n", *after - before) : "";
}

}  // namespace voile::cli
