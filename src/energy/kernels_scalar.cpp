// Element kernels for one triangle at a time, on any processor.
#define VOILE_LANES 1
#define VOILE_KERNELS scalar
#define VOILE_VARIANT "scalar"
#include "kernel_variant.hpp"

namespace voile::energy::VOILE_KERNELS {

bool usable() {
  return true;
}

}  // namespace voile::energy::VOILE_KERNELS
