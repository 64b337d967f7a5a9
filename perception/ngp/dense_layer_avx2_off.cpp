#include "perception/ngp/dense_layer.h"

namespace cousin::ngp {

DenseKernels<float> dense_kernels_avx2() { return {}; }

}  // namespace cousin::ngp
