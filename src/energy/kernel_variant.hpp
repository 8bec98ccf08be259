// The element kernels of one instruction set: included by the source of each variant, which names it.
#pragma once

#include "membrane_tangent_kernel.hpp"

namespace voile::energy::VOILE_KERNELS {

bool usable();
extern const ElementKernels kernels;
const ElementKernels kernels{VOILE_VARIANT,
                             width,
                             usable,
                             {membrane_energy, membrane_strain, membrane_gradient, membrane_tangent}};

}  // namespace voile::energy::VOILE_KERNELS
