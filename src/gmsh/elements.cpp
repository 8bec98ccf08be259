#include "elements.hpp"

#include <fmt/format.h>
#include <gmsh.h>

#include <algorithm>
#include <array>

#include "formats/element_parts.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

/// Corners and nodes of an element type of Gmsh.
struct Shape {
  std::size_t corners = 0, nodes = 0;
};

Shape shape_of(int type) {
  switch (type) {
    case 15:
      return {1, 1};
    case 1:
      return {2, 2};
    case 8:
      return {2, 3};
    case 2:
      return {3, 3};
    case 9:
      return {3, 6};
    case 3:
      return {4, 4};
    case 16:
      return {4, 8};
    case 10:
      return {4, 9};
    default:
      return {};
  }
}

[[noreturn]] void refuse(const std::string& file, int type, const std::vector<std::size_t>& tags) {
  std::string name;
  int dimension = 0, order = 0, node_count = 0, primary = 0;
  std::vector<double> local;
  gmsh::model::mesh::getElementProperties(type, name, dimension, order, node_count, local, primary);
  throw UserError(fmt::format("{}: {} element(s) of type '{}' ({} nodes), the first is element {}; {}", file,
                              tags.size(), name, node_count, *std::min_element(tags.begin(), tags.end()),
                              dimension == 3 ? "delete the volume mesh: a shell needs its surface only"
                                             : "use elements of the first or second order (Mesh.ElementOrder = 1)"));
}

bool is_ghost(int dimension, int tag) {
  std::string type;
  gmsh::model::getType(dimension, tag, type);
  return type.starts_with("Ghost");
}

}  // namespace

ElementReader::ElementReader(std::string file) : file_(std::move(file)) {
  std::vector<std::size_t> tags;
  std::vector<double> x, parametric;
  gmsh::model::mesh::getNodes(tags, x, parametric);
  for (std::size_t k = 0; k < tags.size(); ++k) nodes_[tags[k]] = Vec3(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
}

void ElementReader::add(int type, const std::vector<std::size_t>& tags, const std::vector<std::size_t>& nodes,
                        Elements& to) const {
  const Shape shape = shape_of(type);
  const auto parts = first_order_parts(shape.corners, shape.nodes);
  if (parts.empty()) refuse(file_, type, tags);
  const auto place = [&](std::size_t node) {
    const auto at = nodes_.find(node);
    return at == nodes_.end() ? Vec3(Vec3::Zero()) : at->second;
  };
  for (std::size_t e = 0; e < tags.size(); ++e)
    for (const std::vector<std::size_t>& part : parts) {
      std::vector<std::size_t> n;
      for (const std::size_t i : part) n.push_back(nodes[e * shape.nodes + i]);
      if (n.size() == 4) {
        // From the corner on where the shorter diagonal begins.
        if (second_diagonal_is_better(place(n[0]), place(n[1]), place(n[2]), place(n[3])))
          std::rotate(n.begin(), n.begin() + 1, n.end());
        n = {n[0], n[1], n[2], n[0], n[2], n[3]};
      }
      const std::size_t each = std::min<std::size_t>(shape.corners, 3);
      for (std::size_t k = 0; k < n.size(); k += each) to.tags.push_back(tags[e]);
      to.nodes.insert(to.nodes.end(), n.begin(), n.end());
    }
}

Elements ElementReader::of(int dimension, int tag) const {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> tags, nodes;
  gmsh::model::mesh::getElements(types, tags, nodes, dimension, tag);
  Elements result;
  for (std::size_t k = 0; k < types.size(); ++k)
    if (!tags[k].empty()) add(types[k], tags[k], nodes[k], result);
  return result;
}

Elements ElementReader::all(int dimension) const {
  Elements result;
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities, dimension);
  for (const auto& [d, tag] : entities) {
    if (is_ghost(d, tag)) continue;
    const Elements own = of(d, tag);
    result.tags.insert(result.tags.end(), own.tags.begin(), own.tags.end());
    result.nodes.insert(result.nodes.end(), own.nodes.begin(), own.nodes.end());
  }
  return result;
}

std::string split_note(const std::string& file) {
  std::size_t quadrangles = 0, second = 0;
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities, 2);
  for (const auto& [d, tag] : entities) {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> tags, nodes;
    gmsh::model::mesh::getElements(types, tags, nodes, d, tag);
    for (std::size_t k = 0; k < types.size() && !is_ghost(d, tag); ++k) {
      const Shape shape = shape_of(types[k]);
      quadrangles += shape.corners == 4 && shape.nodes == 4 ? tags[k].size() : 0;
      second += shape.nodes > shape.corners ? tags[k].size() : 0;
    }
  }
  std::string text;
  if (quadrangles > 0)
    text = fmt::format("{} quadrangles were split into triangles along their shorter diagonals", quadrangles);
  if (second > 0)
    text += fmt::format("{}{} elements of second order were split into triangles between their nodes",
                        text.empty() ? "" : ", and ", second);
  return text.empty() ? "" : fmt::format("{}: {}", file, text);
}

}  // namespace voile::formats
