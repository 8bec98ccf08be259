// Element kernels for eight triangles at a time: AVX-512 (x86-64-v4).
#define VOILE_LANES 8
#define VOILE_KERNELS avx512
#define VOILE_VARIANT "AVX-512"
#include "kernel_variant.hpp"

namespace voile::energy::VOILE_KERNELS {

bool usable() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd");
}

}  // namespace voile::energy::VOILE_KERNELS
