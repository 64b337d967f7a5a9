#include "perception/splats/splat_kernels.h"

namespace cousin {

const SplatKernels* avx2_splat_kernels() { return nullptr; }

}  // namespace cousin
