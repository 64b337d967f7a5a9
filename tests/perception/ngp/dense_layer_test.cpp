#include "perception/ngp/dense_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/types/rng.h"

namespace cousin::ngp {
namespace {

template <class T>
std::vector<T> random_numbers(std::size_t count, Rng rng) {
  std::vector<T> out(count);
  for (T& x : out) x = static_cast<T>(uniform(rng, -1, 1));
  return out;
}

struct Shape {
  int inputs, outputs, samples;
};
// Widths that fill the kernels' blocks and ones that leave rests.
constexpr Shape kShapes[] = {{32, 64, 48}, {64, 16, 16}, {64, 3, 32}, {5, 7, 16}, {1, 1, 16}};

/// The passes as their definitions, in double.
std::vector<double> product(const Shape& s, const auto& w, const auto& in, bool rectified) {
  std::vector<double> out;
  for (int o = 0; o < s.outputs; ++o) {
    for (int c = 0; c < s.samples; ++c) {
      double sum = 0;
      for (int i = 0; i < s.inputs; ++i)
        sum += static_cast<double>(w[static_cast<std::size_t>(o * s.inputs + i)]) *
               in[static_cast<std::size_t>(i * s.samples + c)];
      out.push_back(rectified ? std::max(sum, 0.0) : sum);
    }
  }
  return out;
}

template <class T>
void expect_passes(const DenseKernels<T>& kernels, double tolerance) {
  for (const Shape& s : kShapes) {
    const auto size = [](int a, int b) { return static_cast<std::size_t>(a * b); };
    const auto w = random_numbers<T>(size(s.outputs, s.inputs), Rng(1));
    const auto in = random_numbers<T>(size(s.inputs, s.samples), Rng(2));
    const auto d_out = random_numbers<T>(size(s.outputs, s.samples), Rng(3));
    const DenseLayer<T> layer{s.inputs, s.outputs, w.data(), s.samples};

    std::vector<T> out(size(s.outputs, s.samples));
    for (const bool rectified : {false, true}) {
      kernels.forward(layer, in.data(), out.data(), rectified);
      const std::vector<double> expected = product(s, w, in, rectified);
      for (std::size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], expected[i], tolerance);
    }

    std::vector<T> d_in(size(s.inputs, s.samples)), d_w(w.size(), T{1});
    kernels.backward(layer, d_out.data(), in.data(), d_in.data(), true);
    kernels.weights(layer, in.data(), d_out.data(), d_w.data());
    for (int i = 0; i < s.inputs; ++i) {
      for (int c = 0; c < s.samples; ++c) {
        const auto at = static_cast<std::size_t>(i * s.samples + c);
        double sum = 0;
        for (int o = 0; o < s.outputs; ++o)
          sum += static_cast<double>(w[static_cast<std::size_t>(o * s.inputs + i)]) *
                 d_out[static_cast<std::size_t>(o * s.samples + c)];
        EXPECT_NEAR(d_in[at], in[at] > 0 ? sum : 0, tolerance);
      }
      for (int o = 0; o < s.outputs; ++o) {
        double sum = 1;
        for (int c = 0; c < s.samples; ++c)
          sum += static_cast<double>(d_out[static_cast<std::size_t>(o * s.samples + c)]) *
                 in[static_cast<std::size_t>(i * s.samples + c)];
        EXPECT_NEAR(d_w[static_cast<std::size_t>(o * s.inputs + i)], sum, tolerance);
      }
    }
  }
}

// Sums of at most 64 products of numbers below 1: 64 * 64 roundings of 6e-8 at the very most, 1e-5
// in practice.
TEST(DenseLayer, PortablePassesAreTheirDefinitions) {
  expect_passes(dense_kernels_portable(), 2e-5);
}
TEST(DenseLayer, WidePassesAreTheirDefinitions) {
  if (!dense_kernels_avx2().forward) GTEST_SKIP() << "this processor or build has no AVX2";
  expect_passes(dense_kernels_avx2(), 2e-5);
}
TEST(DenseLayer, PassesInDoubleAreTheirDefinitions) {
  expect_passes(dense_kernels_double(), 1e-13);
}

}  // namespace
}  // namespace cousin::ngp
