#include "threads.hpp"

#include <dlfcn.h>

#include <array>
#include <cstdlib>

namespace voile {

void use_one_thread() {
  constexpr std::array names{"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"};
  for (const char* name : names)
    if (std::getenv(name)) return;
  setenv("OMP_NUM_THREADS", "1", 0);
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  // OpenBLAS has read its environment when it was loaded; another BLAS does not have this function.
  if (void* set = dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(set)(1);
}

}  // namespace voile
