#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/ngp/field_network.h"
#include "perception/ngp/hash_grid.h"
#include "perception/ngp/ray_composite.h"
#include "sim/types/rng.h"

namespace cousin::ngp {
namespace {

/// One ray through a small field, in double: table and weights to a loss.
struct Field {
  std::vector<GridLevel> levels = grid_levels({4, 8, 4, 64});
  NetworkShape shape{8};
  DenseKernels<double> kernels = dense_kernels_double();
  std::vector<double> table, weights;
  std::vector<float> x, y, z, length;
  int count = 11;
  std::array<double, 3> background{0.2, 0.5, 0.7}, wanted{0.9, 0.1, 0.4};
  FieldBatch<double> batch;

  Field() {
    Rng draw(5);
    table.resize(table_size(levels));
    for (double& v : table) v = uniform(draw, -1, 1);
    weights.resize(shape.size());
    for (double& v : weights) v = uniform(draw, -0.4, 0.4);
    batch.resize(shape, count);
    const auto n = static_cast<std::size_t>(batch.samples);
    for (auto* row : {&x, &y, &z, &length}) row->assign(n, 0);
    for (std::size_t s = 0; s < static_cast<std::size_t>(count); ++s) {
      const auto t = static_cast<float>(s) / 11;
      x[s] = 0.1F + 0.7F * t;
      y[s] = 0.3F + 0.2F * t;
      z[s] = 0.9F - 0.5F * t;
      length[s] = 0.1F;
    }
    for (std::size_t k = 0; k < kHarmonics; ++k)
      for (std::size_t s = 0; s < n; ++s)
        batch.described[(kGeometry + k) * n + s] = std::sin(1.0 + static_cast<double>(k));
  }

  RaySamples<double> ray() const {
    return {count, batch.described.data(), batch.color.data(), batch.samples, length.data()};
  }
  double loss() {
    encode(levels, table.data(), x.data(), y.data(), z.data(), batch.samples, batch.encoded.data(),
           batch.samples);
    field_forward(shape, kernels, weights.data(), batch);
    const RayColor<double> color = composite(ray(), background);
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += std::pow(color.color[c] - wanted[c], 2);
    return sum;
  }
  void gradient(std::vector<double>& d_table, std::vector<double>& d_weights) {
    loss();
    const RayColor<double> color = composite(ray(), background);
    std::array<double, 3> d_color;
    for (std::size_t c = 0; c < 3; ++c) d_color[c] = 2 * (color.color[c] - wanted[c]);
    FieldBatch<double> back;
    back.resize(shape, count);
    std::fill(back.color.begin(), back.color.end(), 0.0);
    std::vector<double> d_log_density(static_cast<std::size_t>(back.samples), 0);
    composite_backward(ray(), color, d_color, d_log_density.data(), back.color.data());
    d_weights.assign(weights.size(), 0);
    field_backward(shape, kernels, weights.data(), batch, d_log_density.data(), back,
                   d_weights.data());
    d_table.assign(table.size(), 0);
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const double* d = back.encoded.data() + 2 * l * static_cast<std::size_t>(back.samples);
      add_derivatives(levels[l], x.data(), y.data(), z.data(), back.samples, d, d + back.samples,
                      d_table.data());
    }
  }
};

// Central differences of 1e-6 in double err by about 1e-10 here, except where a step crosses the
// kink of a rectifier; none of the numbers below does.
TEST(Field, DerivativesOfTableAndWeightsAreFiniteDifferences) {
  Field field;
  std::vector<double> d_table, d_weights;
  field.gradient(d_table, d_weights);
  Rng draw(9);
  int checked = 0;
  const auto check = [&](std::vector<double>& values, const std::vector<double>& derivative,
                         std::size_t i) {
    const double before = values[i], step = 1e-6;
    values[i] = before + step;
    const double above = field.loss();
    values[i] = before - step;
    const double below = field.loss();
    values[i] = before;
    const double expected = (above - below) / (2 * step);
    EXPECT_NEAR(derivative[i], expected, 1e-4 * std::abs(expected) + 1e-9) << i;
    checked += std::abs(expected) > 1e-6;
  };
  for (int k = 0; k < 300; ++k)
    check(field.weights, d_weights, uniform_index(draw, field.weights.size()));
  for (std::size_t i = 0; i < field.table.size(); ++i)
    if (d_table[i] != 0) check(field.table, d_table, i);
  EXPECT_GT(checked, 300) << "most derivatives were zero: nothing was tested";
}

TEST(Composite, HomogeneousMediumHasItsClosedForm) {
  // Density 2 over a length of 1.5 in 30 steps: transmittance exp(-3).
  const std::vector<double> log_density(30, std::log(2.0)), color(90, 0.3);
  const std::vector<float> length(30, 0.05F);
  const RaySamples<double> samples{30, log_density.data(), color.data(), 30, length.data()};
  const RayColor<double> ray = composite(samples, {1, 0, 0.5});
  const double left = std::exp(-3.0), own = logistic(0.3);
  // Lengths are floats: .05 is off by 7e-10.
  EXPECT_NEAR(ray.transmittance, left, 1e-7);
  EXPECT_NEAR(ray.color[0], (1 - left) * own + left, 1e-7);
  EXPECT_NEAR(ray.color[1], (1 - left) * own, 1e-7);
}

TEST(Composite, SamplesBehindSomethingOpaqueAreNotUsed) {
  const std::vector<float> log_density = {12, 12, 12}, color(9, 0);
  const std::vector<float> length(3, 0.1F);
  const RaySamples<float> samples{3, log_density.data(), color.data(), 3, length.data()};
  EXPECT_EQ(composite(samples, {0, 0, 0}).used, 1);
}

TEST(HashGrid, EncodingIsContinuousAndItsWeightsSumToOne) {
  const std::vector<GridLevel> levels = grid_levels({6, 10, 4, 256});
  for (const GridLevel& level : levels) {
    for (const float x : {0.0F, 0.124F, 0.5F, 0.9999F, 1.0F}) {
      const GridCorners corners = grid_corners(level, x, 1 - x, 0.3F);
      float sum = 0;
      for (std::size_t k = 0; k < 8; ++k) {
        sum += corners.weight[k];
        EXPECT_LT(corners.entry[k], level.entries);
      }
      EXPECT_NEAR(sum, 1, 1e-6);
    }
  }
  EXPECT_FALSE(levels.front().hashed);
  EXPECT_TRUE(levels.back().hashed);
  EXPECT_EQ(levels.front().resolution, 4);
  EXPECT_EQ(levels.back().resolution, 256);
}

}  // namespace
}  // namespace cousin::ngp
