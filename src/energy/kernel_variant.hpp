// The element kernels of one instruction set: included by the source of each variant, which names it.
#pragma once

#include "angle_kernel.hpp"
#include "curved_kernel.hpp"
#include "edge_kernel.hpp"
#include "membrane_tangent_kernel.hpp"
#include "yarn_kernel.hpp"

namespace voile::energy::VOILE_KERNELS {

bool usable();
extern const ElementKernels kernels;
const ElementKernels kernels{VOILE_VARIANT,
                             width,
                             usable,
                             {membrane_strain, membrane_gradient, membrane_tangent},
                             {edge_angles, edge_slopes, edge_gradient, edge_tangent},
                             {angle_gradient, angle_tangent},
                             {curved_gradient, curved_tangent},
                             {yarn_gradient, yarn_tangent}};

}  // namespace voile::energy::VOILE_KERNELS
