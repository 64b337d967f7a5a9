// Compiled for AVX2 and FMA. It holds kernels only: an inline function that other units use too
// must not get its one copy from here.
#include "perception/splats/blend_gradient_kernel.h"
#include "perception/splats/lanes_avx2.h"
#include "perception/splats/update_kernel.h"

namespace cousin {

const SplatKernels* avx2_splat_kernels() {
  static const SplatKernels kernels = {"avx2", project_range<Avx2Lanes>, blend_tile<Avx2Lanes>,
                                       blend_gradient_tile<Avx2Lanes>, update_range<Avx2Lanes>};
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &kernels : nullptr;
}

}  // namespace cousin
