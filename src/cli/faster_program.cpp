#include "faster_program.hpp"

#include <unistd.h>

#include "base/shipped_files.hpp"

namespace voile::cli {

void use_faster_program([[maybe_unused]] char** argv) {
#if defined(__x86_64__) && !defined(__AVX2__)
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi") ||
      !__builtin_cpu_supports("bmi2"))
    return;
  execv(program_of_ours("voile-x86-64-v3").c_str(), argv);  // returns if there is none
#endif
}

}  // namespace voile::cli
