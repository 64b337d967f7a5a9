#pragma once

namespace cousin::ngp {

/// One layer of a small network without biases, over a batch: matrices hold one row a neuron and
/// one column a sample, `samples` columns apart; `samples` is a multiple of kBatchStep. `weights`
/// is outputs x inputs, row-major.
template <class T>
struct DenseLayer {
  int inputs = 0;
  int outputs = 0;
  const T* weights = nullptr;
  int samples = 0;
};
inline constexpr int kBatchStep = 16;

/// The three passes of a layer. All sums run in one order, whatever the threads.
template <class T>
struct DenseKernels {
  /// out = weights * in; rectified (max with 0) if asked.
  void (*forward)(const DenseLayer<T>&, const T* in, T* out, bool rectified);
  /// d_in = weights' * d_out, zero where `in` is not above 0 if `in` was rectified.
  void (*backward)(const DenseLayer<T>&, const T* d_out, const T* in, T* d_in, bool rectified);
  /// d_weights += d_out * in'.
  void (*weights)(const DenseLayer<T>&, const T* in, const T* d_out, T* d_weights);
};

DenseKernels<float> dense_kernels_portable();
/// In double precision, for tests of derivatives.
DenseKernels<double> dense_kernels_double();
/// With AVX2 and FMA; null functions where they are not built in or the processor lacks them.
DenseKernels<float> dense_kernels_avx2();
/// The fastest that this processor runs.
DenseKernels<float> dense_kernels();

}  // namespace cousin::ngp
