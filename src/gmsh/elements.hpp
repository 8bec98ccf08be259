// Elements of the model that Gmsh has read as points, straight lines and triangles; in the program voile-gmsh.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

/// Points, lines or triangles; those of one element have its tag.
struct Elements {
  std::vector<std::size_t> tags;
  std::vector<std::size_t> nodes;  ///< node tags, element by element
};

/// Quadrangles are split along their shorter diagonals, lines, triangles and quadrangles of second order between their
/// nodes.
class ElementReader {
 public:
  /// `file`: for messages.
  explicit ElementReader(std::string file);

  /// Those of an entity. Throws UserError if some are of a higher order, or solids.
  [[nodiscard]] Elements of(int dimension, int tag) const;
  /// Those of all entities but of ghosts, which repeat elements of other partitions.
  [[nodiscard]] Elements all(int dimension) const;
  /// Nodes by their tags, in ascending order, and where they are.
  [[nodiscard]] const std::map<std::size_t, Vec3>& nodes() const { return nodes_; }

 private:
  void add(int type, const std::vector<std::size_t>& tags, const std::vector<std::size_t>& nodes, Elements& to) const;

  std::string file_;
  std::map<std::size_t, Vec3> nodes_;
};

/// What was split among surface elements, as a note; empty if nothing was.
[[nodiscard]] std::string split_note(const std::string& file);

}  // namespace voile::formats
