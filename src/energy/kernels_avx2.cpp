// Element kernels for four triangles at a time: AVX2 (x86-64-v3).
#define VOILE_LANES 4
#define VOILE_KERNELS avx2
#define VOILE_VARIANT "AVX2"
#include "kernel_variant.hpp"

namespace voile::energy::VOILE_KERNELS {

bool usable() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

}  // namespace voile::energy::VOILE_KERNELS
