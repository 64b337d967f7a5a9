#pragma once

#include <cstddef>
#include <vector>

#include "perception/ngp/dense_layer.h"

namespace cousin::ngp {

/// The two networks of Instant-NGP [Müller et al. 2022, section 5.4] without biases: encoded point
/// -> 64 -> 16, whose first number is ln(density); these 16 and 16 harmonics of the direction ->
/// 64 -> 64 -> red, green, blue before the logistic function.
inline constexpr int kWidth = 64;
inline constexpr int kGeometry = 16;
inline constexpr int kHarmonics = 16;
inline constexpr int kColors = 3;

struct NetworkShape {
  int encoded = 32;  ///< numbers that describe a point
  std::size_t first() const { return 0; }
  std::size_t second() const { return static_cast<std::size_t>(encoded) * kWidth; }
  std::size_t third() const { return second() + std::size_t{kWidth} * kGeometry; }
  std::size_t fourth() const { return third() + std::size_t{kGeometry + kHarmonics} * kWidth; }
  std::size_t fifth() const { return fourth() + std::size_t{kWidth} * kWidth; }
  std::size_t size() const { return fifth() + std::size_t{kWidth} * kColors; }
};

/// What a batch passes through; all matrices have a row a neuron and `samples` columns.
template <class T>
struct FieldBatch {
  int samples = 0;  ///< a multiple of kBatchStep
  std::vector<T> encoded, hidden;
  std::vector<T> described;  ///< kGeometry rows of the first network, kHarmonics rows given
  std::vector<T> third, fourth, color;

  void resize(const NetworkShape& shape, int count) {
    samples = (count + kBatchStep - 1) / kBatchStep * kBatchStep;
    const auto rows = [&](int n) {
      return static_cast<std::size_t>(n) * static_cast<std::size_t>(samples);
    };
    encoded.resize(rows(shape.encoded));
    hidden.resize(rows(kWidth));
    described.resize(rows(kGeometry + kHarmonics));
    third.resize(rows(kWidth));
    fourth.resize(rows(kWidth));
    color.resize(rows(kColors));
  }
};

template <class T>
void field_density(const NetworkShape& shape, const DenseKernels<T>& kernels, const T* weights,
                   FieldBatch<T>& batch) {
  const int n = batch.samples;
  kernels.forward({shape.encoded, kWidth, weights + shape.first(), n}, batch.encoded.data(),
                  batch.hidden.data(), true);
  kernels.forward({kWidth, kGeometry, weights + shape.second(), n}, batch.hidden.data(),
                  batch.described.data(), false);
}

template <class T>
void field_forward(const NetworkShape& shape, const DenseKernels<T>& kernels, const T* weights,
                   FieldBatch<T>& batch) {
  const int n = batch.samples;
  field_density(shape, kernels, weights, batch);
  kernels.forward({kGeometry + kHarmonics, kWidth, weights + shape.third(), n},
                  batch.described.data(), batch.third.data(), true);
  kernels.forward({kWidth, kWidth, weights + shape.fourth(), n}, batch.third.data(),
                  batch.fourth.data(), true);
  kernels.forward({kWidth, kColors, weights + shape.fifth(), n}, batch.fourth.data(),
                  batch.color.data(), false);
}

/// Derivatives of a loss, given those by the raw outputs: `gradient.color` (3 rows) and
/// `d_log_density` (one row). Adds to `d_weights`; leaves those by the encoded points in
/// `gradient.encoded`.
template <class T>
void field_backward(const NetworkShape& shape, const DenseKernels<T>& kernels, const T* weights,
                    const FieldBatch<T>& batch, const T* d_log_density, FieldBatch<T>& gradient,
                    T* d_weights) {
  const int n = batch.samples;
  const DenseLayer<T> first{shape.encoded, kWidth, weights + shape.first(), n};
  const DenseLayer<T> second{kWidth, kGeometry, weights + shape.second(), n};
  const DenseLayer<T> third{kGeometry + kHarmonics, kWidth, weights + shape.third(), n};
  const DenseLayer<T> fourth{kWidth, kWidth, weights + shape.fourth(), n};
  const DenseLayer<T> fifth{kWidth, kColors, weights + shape.fifth(), n};
  kernels.weights(fifth, batch.fourth.data(), gradient.color.data(), d_weights + shape.fifth());
  kernels.backward(fifth, gradient.color.data(), batch.fourth.data(), gradient.fourth.data(), true);
  kernels.weights(fourth, batch.third.data(), gradient.fourth.data(), d_weights + shape.fourth());
  kernels.backward(fourth, gradient.fourth.data(), batch.third.data(), gradient.third.data(), true);
  kernels.weights(third, batch.described.data(), gradient.third.data(), d_weights + shape.third());
  kernels.backward(third, gradient.third.data(), batch.described.data(), gradient.described.data(),
                   false);
  for (int s = 0; s < n; ++s) gradient.described[static_cast<std::size_t>(s)] += d_log_density[s];
  kernels.weights(second, batch.hidden.data(), gradient.described.data(),
                  d_weights + shape.second());
  kernels.backward(second, gradient.described.data(), batch.hidden.data(), gradient.hidden.data(),
                   true);
  kernels.weights(first, batch.encoded.data(), gradient.hidden.data(), d_weights + shape.first());
  kernels.backward(first, gradient.hidden.data(), batch.encoded.data(), gradient.encoded.data(),
                   false);
}

}  // namespace cousin::ngp
