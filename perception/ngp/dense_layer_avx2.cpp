#include "perception/ngp/dense_layer_body.h"

namespace cousin::ngp {
namespace {

struct Avx2 {
  using Number = float;
  typedef float Vector __attribute__((vector_size(32)));
  static constexpr int kLanes = 8;
};

}  // namespace

DenseKernels<float> dense_kernels_avx2() {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return {};
  using Passes = DensePasses<Avx2>;
  return {Passes::forward, Passes::backward, Passes::weights};
}

}  // namespace cousin::ngp
