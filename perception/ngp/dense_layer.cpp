#include "perception/ngp/dense_layer.h"

#include "perception/ngp/dense_layer_body.h"

namespace cousin::ngp {
namespace {

struct Portable {
  using Number = float;
  typedef float Vector __attribute__((vector_size(16)));
  static constexpr int kLanes = 4;
};
struct Precise {
  using Number = double;
  typedef double Vector __attribute__((vector_size(16)));
  static constexpr int kLanes = 2;
};

}  // namespace

DenseKernels<float> dense_kernels_portable() {
  using Passes = DensePasses<Portable>;
  return {Passes::forward, Passes::backward, Passes::weights};
}

DenseKernels<double> dense_kernels_double() {
  using Passes = DensePasses<Precise>;
  return {Passes::forward, Passes::backward, Passes::weights};
}

DenseKernels<float> dense_kernels() {
  const DenseKernels<float> fast = dense_kernels_avx2();
  return fast.forward ? fast : dense_kernels_portable();
}

}  // namespace cousin::ngp
