// Element kernels for two triangles at a time: SSE2 of every x86-64, NEON.
#define VOILE_LANES 2
#define VOILE_KERNELS pairs
#define VOILE_VARIANT "pairs"
#include "kernel_variant.hpp"

namespace voile::energy::VOILE_KERNELS {

bool usable() {
  return true;
}

}  // namespace voile::energy::VOILE_KERNELS
