// A package has the program twice: for every x86-64 processor, and as voile-x86-64-v3 for those with AVX2, where it takes 5 to
// 10 % less time. The element kernels choose by themselves (energy/element_kernels.hpp); this is for all other loops.
#pragma once

namespace voile::cli {

/// Goes on as the faster program beside this one, if there is one and the processor can run it: does not return then.
/// Before MPI begins.
void use_faster_program(char** argv);

}  // namespace voile::cli
