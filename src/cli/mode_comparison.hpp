// Which modes of two runs are the same.
//
// Symbols   a, b     modes of the first and the second run, M mass;  <a, b> = a.M b, or a.b without it
//   MAC(a, b)  = <a, b>^2 / (<a, a> <b, b>)                    with masses  (a.Mb)(Ma.b) / ((a.Ma)(b.Mb))
//   span(a, S) = c.G^-1 c / <a, a>,   c_j = <a, b_j>,  G_jk = <b_j, b_k>,  j and k in S
// S has the modes b whose value is within `near` of that of the best partner: of a pair with one frequency each run finds some
// basis of the same plane, so that no MAC is 1 but the span is. Where meshes differ, the modes of the finer one are taken, linearly
// in its triangles, at the places where the vertices of the coarser one start, without masses.
// Source: R.J. Allemang, Sound Vib. 37 (2003) 14-23; of subspaces A. Bjorck & G.H. Golub, Math. Comput. 27 (1973) 579-594.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::cli {

struct ModeSet {
  std::filesystem::path file;
  mesh::MeshData mesh;
  std::string length;           ///< unit of positions
  std::string quantity;         ///< what the values are: frequency_hz, critical_load_factor
  std::vector<double> values;   ///< of each mode
  Eigen::MatrixXd shapes;       ///< a column each, three rows per vertex
  Eigen::MatrixXd mass_shapes;  ///< times the mass; empty: not known
};

/// `folder`: of a run or one of its stages. Throws UserError.
[[nodiscard]] ModeSet read_modes(const std::filesystem::path& folder);

struct Partner {
  std::size_t best = 0;             ///< of the second run, from 0
  std::vector<std::size_t> around;  ///< S
  double span = 0.0;
};

struct ModeComparison {
  bool same_mesh = false, by_mass = false;
  Eigen::MatrixXd mac;            ///< rows: first run, columns: second
  std::vector<Partner> partners;  ///< of each mode of the first run
};

/// Throws UserError where the shapes of the two meshes differ.
[[nodiscard]] ModeComparison compare(const ModeSet& first, const ModeSet& second, double near);

}  // namespace voile::cli
