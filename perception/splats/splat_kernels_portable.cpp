#include "perception/splats/blend_gradient_kernel.h"
#include "perception/splats/lanes_plain.h"
#include "perception/splats/update_kernel.h"

namespace cousin {

const SplatKernels& portable_splat_kernels() {
  static const SplatKernels kernels = {"portable", project_range<PlainLanes>,
                                       blend_tile<PlainLanes>, blend_gradient_tile<PlainLanes>,
                                       update_range<PlainLanes>};
  return kernels;
}

const SplatKernels& best_splat_kernels() {
  const SplatKernels* avx2 = avx2_splat_kernels();
  return avx2 != nullptr ? *avx2 : portable_splat_kernels();
}

}  // namespace cousin
