// A model's vibration about an equilibrium in the coordinates of its lowest modes and of what these leave of the response
// to a force.
//
// Symbols   K exact tangent at the equilibrium, M mass, C damping (Dynamics);  Phi modes, M-orthonormal;  f force
//           s       a shift far below the modes, so that free bodies can be factored
//   r_1 = (K + s M)^-1 (f - M Phi Phi^T f),   r_k+1 = (K + s M)^-1 M r_k         k <= 3, M-orthonormal to all before
//   d = (K + s M)^-1 C v   of each r, then of each mode v, and of these d once more, as far as they are new
//   V = [Phi, r_1, r_2, r_3, d ...]:   V^T M V = I,   k = V^T K V,   c = V^T C V,   V^T f
// r_1 makes the response at rest exact; each further one lowers what is missing by (omega/omega_next)^2. Damping in proportion to
// K gives no d, in proportion to M none of the modes; what other damping does through modes that are left out, each round of d lowers
// by about omega tau.
// Source: J.M. Dickens, J.M. Nakagawa & M.J. Wittbrodt, A critique of mode acceleration and modal truncation augmentation
//         methods for modal response analysis, Comput. Struct. 62 (1997) 985-998.
#pragma once

#include <vector>

#include "eigen.hpp"
#include "reduced_response.hpp"

namespace voile::solve {

struct ModalBasis {
  std::vector<petsc::VecHandle> vectors;  ///< columns of V
  ReducedSystem system;                   ///< alike on all ranks, without rows
  std::size_t fewer = 0;  ///< columns without the last correction, whose effect is an estimate of what is still missing
};

/// C at `a`: damping in proportion to mass and bending, of the membrane and of the materials, as in a motion, without
/// drag; none where nothing damps. Collective. [N s/m]
[[nodiscard]] petsc::MatHandle damping_matrix(system::Model& model, Vec a, const system::DynamicsOptions& options,
                                              const MassMatrix& mass);

/// `damping` may be null. Collective. Throws UserError where the system cannot be solved.
[[nodiscard]] ModalBasis modal_basis(system::Model& model, Vec a, const std::vector<Mode>& modes,
                                     const MassMatrix& mass, Mat damping, Vec force);

}  // namespace voile::solve
