// Pieces that the readers of meshes share; private to src/io.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::formats {

/// A mesh that grows element by element, with vertices numbered as the file does.
struct GrowingMesh {
  mesh::MeshData data;
  Index split = 0;  ///< polygons that were split

  /// Corners in file order; texture corners or none. Quadrangles are split along the shorter diagonal, larger polygons
  /// from their first corner. `tag`: the file's number for messages. Returns the triangles made.
  std::vector<Index> add_polygon(const std::vector<Index>& corners, std::size_t tag,
                                 const std::vector<Vec2>& texture = {});
  mesh::Group& group(const std::string& name, int dimension);
  /// Adds a note on polygons that were split, if any were.
  void note_split();
};

/// Triangles of each kind of polygon, OBJ.
[[nodiscard]] mesh::MeshData read_obj_mesh(const std::string& file);
[[nodiscard]] mesh::MeshData read_abaqus(const std::string& file);
/// The same of a text; `file` is named in messages.
[[nodiscard]] mesh::MeshData read_abaqus_text(const std::string& file, const std::string& text);
/// Nastran bulk data: shells with their properties as groups "property-N", held grid points as "spc-N".
[[nodiscard]] mesh::MeshData read_nastran(const std::string& file);
[[nodiscard]] mesh::MeshData read_vtk(const std::string& file);

/// Every boundary edge once, as segments in ascending order.
[[nodiscard]] std::vector<mesh::Segment> boundary_edges(const std::vector<mesh::Triangle>& triangles);

/// The text of a file. Throws UserError if it cannot be read or is empty.
[[nodiscard]] std::string file_text(const std::string& file);

/// Throws UserError "file:line: what".
[[noreturn]] void fail_in_line(const std::string& file, std::size_t line, const std::string& what);

/// Reads the whole of `word` as a number; false if it is none.
[[nodiscard]] bool parse_number(const std::string& word, double& number);
[[nodiscard]] bool parse_integer(const std::string& word, long& number);

}  // namespace voile::formats
