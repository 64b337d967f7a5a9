#pragma once

#include <cstddef>

#include "perception/ngp/dense_layer.h"

namespace cousin::ngp {

/// Private to perception/ngp: the passes for vectors `Ops::Vector` of `Ops::kLanes` numbers, which
/// each translation unit defines for itself, so that no two share a name. Blocks of kRows x 2
/// vectors of sums stay in registers.
template <class Ops>
struct DensePasses {
  using T = typename Ops::Number;
  using V = typename Ops::Vector;
  static constexpr int kLanes = Ops::kLanes;
  static constexpr int kRows = 4;

  static V load(const T* at) {
    V v;
    __builtin_memcpy(&v, at, sizeof v);
    return v;
  }
  static void store(T* at, V v) { __builtin_memcpy(at, &v, sizeof v); }
  static std::size_t at(int row, int stride, int column) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(stride) +
           static_cast<std::size_t>(column);
  }

  /// Sums of kRows rows of a matrix product; `weight(r, k)` is the factor of row r and input k.
  template <int rows, class Weight>
  static void product(const Weight& weight, int depth, const T* in, int samples, int column,
                      V (&sum)[rows][2]) {
    for (int r = 0; r < rows; ++r) sum[r][0] = sum[r][1] = V{};
    for (int k = 0; k < depth; ++k) {
      const V low = load(in + at(k, samples, column));
      const V high = load(in + at(k, samples, column + kLanes));
      for (int r = 0; r < rows; ++r) {
        const T w = weight(r, k);
        sum[r][0] += w * low;
        sum[r][1] += w * high;
      }
    }
  }

  template <int rows>
  static void forward_rows(const DenseLayer<T>& layer, const T* in, T* out, bool rectified, int o,
                           int column) {
    V sum[rows][2];
    const T* weights = layer.weights + at(o, layer.inputs, 0);
    product<rows>([&](int r, int k) { return weights[at(r, layer.inputs, k)]; }, layer.inputs, in,
                  layer.samples, column, sum);
    for (int r = 0; r < rows; ++r) {
      for (int h = 0; h < 2; ++h) {
        const V value = rectified ? (sum[r][h] > T{0} ? sum[r][h] : V{}) : sum[r][h];
        store(out + at(o + r, layer.samples, column + h * kLanes), value);
      }
    }
  }

  static void forward(const DenseLayer<T>& layer, const T* in, T* out, bool rectified) {
    for (int column = 0; column < layer.samples; column += 2 * kLanes) {
      int o = 0;
      for (; o + kRows <= layer.outputs; o += kRows)
        forward_rows<kRows>(layer, in, out, rectified, o, column);
      for (; o < layer.outputs; ++o) forward_rows<1>(layer, in, out, rectified, o, column);
    }
  }

  template <int rows>
  static void backward_rows(const DenseLayer<T>& layer, const T* d_out, const T* in, T* d_in,
                            bool rectified, int i, int column) {
    V sum[rows][2];
    const T* weights = layer.weights + i;
    product<rows>([&](int r, int k) { return weights[at(k, layer.inputs, r)]; }, layer.outputs,
                  d_out, layer.samples, column, sum);
    for (int r = 0; r < rows; ++r) {
      for (int h = 0; h < 2; ++h) {
        const std::size_t place = at(i + r, layer.samples, column + h * kLanes);
        const V value = rectified ? (load(in + place) > T{0} ? sum[r][h] : V{}) : sum[r][h];
        store(d_in + place, value);
      }
    }
  }

  static void backward(const DenseLayer<T>& layer, const T* d_out, const T* in, T* d_in,
                       bool rectified) {
    for (int column = 0; column < layer.samples; column += 2 * kLanes) {
      int i = 0;
      for (; i + kRows <= layer.inputs; i += kRows)
        backward_rows<kRows>(layer, d_out, in, d_in, rectified, i, column);
      for (; i < layer.inputs; ++i) backward_rows<1>(layer, d_out, in, d_in, rectified, i, column);
    }
  }

  template <int outs, int ins>
  static void weight_block(const DenseLayer<T>& layer, const T* in, const T* d_out, T* d_weights,
                           int o, int i) {
    V sum[outs][ins];
    for (auto& row : sum)
      for (V& v : row) v = V{};
    for (int column = 0; column < layer.samples; column += kLanes) {
      V value[ins];
      for (int k = 0; k < ins; ++k) value[k] = load(in + at(i + k, layer.samples, column));
      for (int r = 0; r < outs; ++r) {
        const V d = load(d_out + at(o + r, layer.samples, column));
        for (int k = 0; k < ins; ++k) sum[r][k] += d * value[k];
      }
    }
    for (int r = 0; r < outs; ++r) {
      for (int k = 0; k < ins; ++k) {
        T total{0};
        for (int lane = 0; lane < kLanes; ++lane) total += sum[r][k][lane];
        d_weights[at(o + r, layer.inputs, i + k)] += total;
      }
    }
  }

  static void weights(const DenseLayer<T>& layer, const T* in, const T* d_out, T* d_weights) {
    int o = 0;
    for (; o + 3 <= layer.outputs; o += 3) {
      int i = 0;
      for (; i + 4 <= layer.inputs; i += 4) weight_block<3, 4>(layer, in, d_out, d_weights, o, i);
      for (; i < layer.inputs; ++i) weight_block<3, 1>(layer, in, d_out, d_weights, o, i);
    }
    for (; o < layer.outputs; ++o) {
      int i = 0;
      for (; i + 4 <= layer.inputs; i += 4) weight_block<1, 4>(layer, in, d_out, d_weights, o, i);
      for (; i < layer.inputs; ++i) weight_block<1, 1>(layer, in, d_out, d_weights, o, i);
    }
  }
};

}  // namespace cousin::ngp
