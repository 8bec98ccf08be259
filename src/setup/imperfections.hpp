// By how much the shape without stress differs from the mesh of the case.
//
// Symbols   X, N     place and normal of a vertex (mean of its triangles, weighted by area);  w what is added to X    [m]
// modes        w = amplitude / max |v| v,  v the mode
// expression   w = height(X) N
// random       w = amplitude / max |h| h(X) N,   h(X) = sum_j cos(k_j . X + phi_j),   k_j normal with deviation 1/length in each axis:
//              the correlation at distance r is exp(-r^2 / (2 length^2)) (Shinozuka & Deodatis, Appl. Mech. Rev. 44 (1991) 191-204)
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/mpi.hpp"
#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// Shapes of modes by the name of the stage that has found them: vertices x 3 in global axes and the order of the mesh, of any scale;
/// on rank 0.
using StageModes = std::map<std::string, std::vector<std::vector<double>>>;

/// The perfect mesh with all imperfections of the case, free of stress. Modes of stages that are not `known` come from the folder of
/// their results. Collective. Throws UserError on every rank.
[[nodiscard]] mesh::SurfaceMesh with_imperfections(MPI_Comm comm, const input::Case& c, mesh::SurfaceMesh perfect,
                                                   const StageModes& known = {});

}  // namespace voile::setup
