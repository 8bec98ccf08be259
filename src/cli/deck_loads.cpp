#include "deck_loads.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <optional>
#include <utility>

#include "deck_material.hpp"

namespace voile::cli {

namespace {

using formats::Deck;

/// Mass per area; 0 if it is not known.
double mass_of(const Deck& deck, const Deck::Section& s) {
  double mass = s.mass;
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

/// Whether turned axes are those of one of its nodes.
bool is_turned(const Deck& deck, const mesh::MeshData& mesh, const std::vector<char>& at) {
  return std::any_of(deck.turned.begin(), deck.turned.end(), [&](const std::string& set) {
    const mesh::Group* group = group_named(mesh, set, true);
    return group && std::any_of(group->vertices.begin(), group->vertices.end(),
                                [&](Index v) { return at[static_cast<std::size_t>(v)] != 0; });
  });
}

}  // namespace

std::vector<char> vertices_of(const mesh::MeshData& mesh, const std::string& where) {
  std::vector<char> at(mesh.positions.size(), 0);
  if (const mesh::Group* group = group_named(mesh, where, true))
    for (const Index v : group->vertices) at[static_cast<std::size_t>(v)] = 1;
  if (where.empty() || !std::all_of(where.begin(), where.end(), [](unsigned char c) { return std::isdigit(c) != 0; }))
    return at;
  const auto tag =
      std::find(mesh.vertex_tags.begin(), mesh.vertex_tags.end(), std::strtoull(where.c_str(), nullptr, 10));
  if (tag != mesh.vertex_tags.end()) at[static_cast<std::size_t>(tag - mesh.vertex_tags.begin())] = 1;
  return at;
}

void drop_turned(Deck& deck, const mesh::MeshData& mesh, std::vector<std::string>& left) {
  if (deck.turned.empty()) return;
  const auto drop = [&](const std::string& keyword, const std::string& where, const char* section) {
    if (!is_turned(deck, mesh, vertices_of(mesh, where))) return false;
    left.push_back(
        fmt::format("{} {}: its nodes have axes of their own; write that [[{}]] yourself", keyword, where, section));
    return true;
  };
  std::erase_if(deck.supports, [&](const auto& entry) {
    const Deck::Support& s = entry.second;
    const bool any_axes = s.held[0] && s.held[1] && s.held[2] && s.value == std::array<double, 3>{} &&
                          s.held[3] == s.held[4] && s.held[4] == s.held[5];
    return !any_axes && drop(deck.words.support, entry.first, "support");
  });
  std::erase_if(deck.loads, [&](const Deck::Load& l) {
    return l.kind == Deck::Load::Kind::force && drop(deck.words.load, l.where, "load");
  });
}

int mirror_of(const Deck::Support& s, const mesh::MeshData& mesh, const std::vector<char>& at) {
  const auto& h = s.held;
  const int moves = h[0] + h[1] + h[2], turns = h[3] + h[4] + h[5];
  for (int k = 0; k < 3; ++k) {
    if (s.mirror == std::string(1, static_cast<char>('X' + k)) + "SYMM") return k;
    const auto a = static_cast<std::size_t>(3 + (k + 1) % 3), b = static_cast<std::size_t>(3 + (k + 2) % 3);
    if (!h[static_cast<std::size_t>(k)] || !h[a] || !h[b] || (moves == 3 && turns == 3)) continue;
    if (moves == 1 && turns == 2) return k;
    Eigen::AlignedBox<double, 1> along;
    Eigen::AlignedBox3d all;
    for (std::size_t v = 0; v < at.size(); ++v) {
      all.extend(mesh.positions[v]);
      if (at[v] != 0) along.extend(mesh.positions[v].segment<1>(k));
    }
    if (!along.isEmpty() && along.sizes()[0] <= 1e-6 * all.sizes().maxCoeff()) return k;
  }
  return -1;
}

namespace {

Vec3 normal_of(const mesh::MeshData& mesh, const mesh::Triangle& t) {
  const std::vector<Vec3>& x = mesh.positions;
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
}

}  // namespace

bool lies_in_mirror(int mirror, const mesh::MeshData& mesh, const std::vector<char>& at) {
  constexpr double upright = 0.1;  // sine between the sheet and the plane
  const auto beside = [&](const mesh::Triangle& t) { return at[t[0]] != 0 || at[t[1]] != 0 || at[t[2]] != 0; };
  const auto across = [&](const mesh::Triangle& t) {
    return std::abs(normal_of(mesh, t)[mirror]) < 1.0 - 0.5 * upright * upright;
  };
  return std::none_of(mesh.triangles.begin(), mesh.triangles.end(),
                      [&](const mesh::Triangle& t) { return beside(t) && across(t); });
}

bool is_area(const mesh::MeshData& mesh, const std::string& group) {
  return std::any_of(mesh.groups.begin(), mesh.groups.end(),
                     [&](const mesh::Group& g) { return g.name == group && g.dimension == 2; });
}

bool has_edge(const mesh::MeshData& mesh, const std::vector<char>& at) {
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const mesh::Triangle& t) { return at[t[0]] + at[t[1]] + at[t[2]] > 1; });
}

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
