#include "element_kernels.hpp"

namespace voile::energy {

namespace scalar {
extern const ElementKernels kernels;
}
namespace pairs {
extern const ElementKernels kernels;
}
#ifdef VOILE_X86_KERNELS
namespace avx2 {
extern const ElementKernels kernels;
}
namespace avx512 {
extern const ElementKernels kernels;
}
#endif

KernelVariants kernel_variants() {
  static const ElementKernels* const all[] = {
      &scalar::kernels,
      &pairs::kernels,
#ifdef VOILE_X86_KERNELS
      &avx2::kernels,
      &avx512::kernels,
#endif
  };
  return {all, static_cast<int>(sizeof(all) / sizeof(all[0]))};
}

const ElementKernels& scalar_kernels() {
  return scalar::kernels;
}

const ElementKernels& batch_kernels() {
  static const ElementKernels& widest = [&]() -> const ElementKernels& {
    const KernelVariants of = kernel_variants();
    for (int i = of.count - 1; i > 0; --i)
      if (of.variants[i]->usable()) return *of.variants[i];
    return scalar::kernels;
  }();
  return widest;
}

}  // namespace voile::energy
