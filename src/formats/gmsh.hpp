// Reading meshes with the Gmsh library: .msh (2.2 and 4.1, ASCII and binary) and .geo (meshed on the fly).
#pragma once

#include <map>
#include <string>

#include "mesh/surface_mesh.hpp"
#include "placement.hpp"

namespace voile::formats {

/// What a sheet is without strain.
enum class RestShape {
  positions,  ///< as the file's vertices lie
  texture     ///< the flat panels of its texture coordinates (mesh/panels.hpp)
};

/// How a .geo file is meshed, and what becomes of the coordinates of any file.
struct MeshOptions {
  std::map<std::string, double> parameters;  ///< named numbers of the .geo (DefineConstant) set before meshing
  double size = 0.0;                         ///< uniform target edge length [m in file units]; 0: as the .geo says
  int algorithm = 0;                         ///< Gmsh's 2-D algorithm number; 0: as the .geo says
  double scale = 1.0;                        ///< file coordinates are multiplied by this to become metres
  Placement placement = {};                  ///< then put in place by read_mesh(); read_gmsh() does not
  bool merge = false;                        ///< make one mesh of parts that touch; taken by the caller of read_mesh()
  bool join_crossing = true;                 ///< also where they pass through each other
  bool allow_system_call = false;            ///< let a .geo run programs and write files (geo_safety.hpp)
  double merge_tolerance = 0.0;              ///< how close they must lie [m]; 0: mesh::default_merge_tolerance()
  RestShape rest = RestShape::positions;     ///< taken by the caller of read_mesh()
  double texture_unit = 1.0;                 ///< of texture coordinates [m], for RestShape::texture
};

/// Reads (or generates) a triangle mesh. Not collective: call on one rank. The surface is every triangle of the file;
/// points and lines enter only through their physical groups.
/// Throws UserError for a missing or unreadable file, elements other than first-order triangles on the surface, a group
/// without a name or a .geo parameter that the file does not define.
[[nodiscard]] mesh::MeshData read_gmsh(const std::string& file, const MeshOptions& options);

/// Version of the Gmsh library in use.
[[nodiscard]] std::string gmsh_version();

}  // namespace voile::formats
