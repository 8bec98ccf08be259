// Sheets from Nastran bulk data: translated into an Abaqus input file of one flat part, in the basic coordinate system.
#include <fmt/format.h>

#include <array>
#include <map>
#include <set>
#include <utility>

#include "mesh_file.hpp"
#include "mesh_text.hpp"
#include "nastran_cards.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

/// What Abaqus calls an element, the first field of its nodes, and how many it has.
struct CardShape {
  const char* type = nullptr;
  std::size_t corners = 0, nodes = 0;
};

CardShape card_shape(const std::string& name) {
  static const std::map<std::string, CardShape> shapes{
      {"CTRIA3", {"S3", 3, 3}}, {"CTRIAR", {"S3", 3, 3}},  {"CTRIA6", {"STRI65", 3, 6}}, {"CQUAD4", {"S4", 4, 4}},
      {"CQUADR", {"S4", 4, 4}}, {"CQUAD8", {"S8R", 4, 8}}, {"CQUAD", {"S9R5", 4, 9}}};
  const auto at = shapes.find(name);
  return at == shapes.end() ? CardShape{} : at->second;
}

/// Nodes of an element; only the corners if it has no others.
std::vector<long> nodes_of(const NastranCard& card, CardShape& shape) {
  std::vector<long> nodes;
  for (std::size_t k = 0; k < shape.nodes; ++k) {
    const long node = card.whole(3 + k, 0L);
    if (node != 0) nodes.push_back(node);
    if (node == 0 && k < shape.corners) card.fail(fmt::format("corner {} is missing", k + 1));
  }
  if (nodes.size() == shape.corners) shape = {shape.corners == 3 ? "S3" : "S4", shape.corners, shape.corners};
  if (nodes.size() != shape.nodes)
    card.fail(fmt::format("{} of {} nodes are given; give all nodes on the sides, or none", nodes.size(), shape.nodes));
  return nodes;
}

bool is_other_element(const std::string& name) {
  return (name.starts_with("C") && !name.starts_with("CORD") && name != "CLOAD" && name != "CSUPER" &&
          name.size() > 3) ||
         name.starts_with("RBE") || name == "RBAR" || name == "PLOTEL";
}

void add_nodes(std::string& out, const std::vector<long>& nodes) {
  for (const long n : nodes) out += fmt::format("{},\n", n);
}

}  // namespace

std::string nastran_as_abaqus(const std::string& file) {
  const NastranFile deck = read_nastran_file(file);
  const std::map<long, Vec3> points = NastranSystems(deck.cards).points();
  std::map<std::pair<std::string, long>, std::string> elements;  // by type and property
  std::map<long, std::string> held;
  std::set<long> grids;
  for (const auto& entry : points) grids.insert(entry.first);
  std::map<long, const NastranCard*> seen;
  std::string nodes = "*NODE\n", other;
  for (const auto& [id, x] : points) nodes += fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", id, x[0], x[1], x[2]);
  for (const NastranCard& card : deck.cards) {
    if (CardShape shape = card_shape(card.name); shape.type) {
      const long id = card.whole(1);
      const auto [at, fresh] = seen.emplace(id, &card);
      if (!fresh) card.fail(fmt::format("element {} is there twice, first in line {}", id, at->second->line));
      const std::vector<long> of = nodes_of(card, shape);
      for (const long n : of)
        if (!points.count(n)) card.fail(fmt::format("there is no grid point {}", n));
      elements[{shape.type, card.whole(2, id)}] += fmt::format("{}, {}\n", id, fmt::join(of, ", "));
    } else if (card.name == "SPC1") {
      add_nodes(held[card.whole(1)], card.list(3, grids));
    } else if (card.name == "SPC") {
      for (const std::size_t k : {2, 5})
        if (!card.field(k).empty()) add_nodes(held[card.whole(1)], {card.whole(k)});
    } else if (is_other_element(card.name)) {
      other += fmt::format("*ELEMENT, TYPE={}\n{}\n", card.name, card.field(1).empty() ? "0" : card.field(1));
    }
  }
  std::string text = nodes;
  for (const auto& [key, lines] : elements)
    text += fmt::format("*ELEMENT, TYPE={}, ELSET=property-{}\n{}", key.first, key.second, lines);
  for (const auto& [id, lines] : held) text += fmt::format("*NSET, NSET=spc-{}\n{}", id, lines);
  return text + other;
}

mesh::MeshData read_nastran(const std::string& file) {
  return read_abaqus_text(file, nastran_as_abaqus(file));
}

}  // namespace voile::formats
