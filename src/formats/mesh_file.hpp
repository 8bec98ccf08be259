// Meshes of the sheet from files of every kind.
//
// Format   Groups                                                            Polygons of more than three corners
// .msh     Gmsh's physical groups (gmsh.hpp)                                 quadrangles split
// .geo     the same
// .obj     'g', 'o' and 'usemtl': surfaces; 'l' within a 'g': curves         split
// .inp     Abaqus: *ELSET surfaces; *NSET curves if the mesh has boundary    quadrangles split
//          edges between its nodes, else points
// .bdf .nas .dat   Nastran: properties "property-N" are surfaces, SPC and    quadrangles split
//          SPC1 "spc-N" curves or points as *NSET
// .vtk     legacy VTK, ASCII and binary: values of an integer cell array     split
//          (named 'group', 'physical', 'CellEntityIds' or the first): "name-value", surfaces and curves
// .stl .ply .off   none                                                      split
// All but the first two get the curve group 'boundary' (every boundary edge) and, if that is several loops,
// 'boundary-1', 'boundary-2', ... from the longest to the shortest. A quadrangle is split along its shorter diagonal.
#pragma once

#include <filesystem>
#include <string>

#include "gmsh.hpp"

namespace voile::formats {

/// Finds 'boundary', 'boundary-1', ... anew where they are whatever boundary edges there are: after vertices have been merged.
void renew_boundary(mesh::MeshData& data);

/// Reads the sheet's mesh; the extension decides. Vertices without a triangle are dropped where the format is not
/// Gmsh's. Not collective: call on one rank. Throws UserError that names the file, and where it can the line, for what
/// cannot be read, other elements than triangles and quadrangles, coordinates that are not finite or absurd.
[[nodiscard]] mesh::MeshData read_mesh(const std::string& file, const MeshOptions& options);

/// Whether the extension is that of Nastran bulk data.
[[nodiscard]] bool is_nastran(const std::filesystem::path& file);
/// The sheet of such a file as an Abaqus input file, and elements that are no shells by their numbers. Not collective. Throws
/// UserError.
[[nodiscard]] std::string nastran_as_abaqus(const std::string& file);

/// Throws UserError if a coordinate is not finite or so large or small (beyond 1e100 m or less than 1e-100 m in extent)
/// that its powers are not numbers. `what`: the file, for the message.
void check_coordinates(const std::string& what, const std::vector<Vec3>& positions);

}  // namespace voile::formats
