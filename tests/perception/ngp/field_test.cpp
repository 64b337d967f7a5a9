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
    for (std::size_t l = 0; l < levels.size(); ++l) {
      double* row = batch.encoded.data() + 2 * l * static_cast<std::size_t>(batch.samples);
      encode_level(levels[l], table.data(), x.data(), y.data(), z.data(), batch.samples, row,
                   row + batch.samples);
    }
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

TEST(HashGrid, CornersAreThoseOfTheCubeAboutAPointAndWeightsSumToOne) {
  const std::vector<GridLevel> levels = grid_levels({6, 10, 4, 256});
  const std::vector<float> x = {0.0F, 0.124F, 0.5F, 0.9999F, 1.0F, -3.0F, 7.0F, std::nanf("")};
  const std::vector<float> y(8, 0.7F), z(8, 0.3F);
  for (const GridLevel& level : levels) {
    for (const int count : {8, 5}) {
      CornerBlock block;
      find_corners(level, x.data(), y.data(), z.data(), count, block);
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const auto cell = [&](float at) {
          const double inside = at > 0 ? std::min(1.0, static_cast<double>(at)) : 0;
          return static_cast<std::uint32_t>(inside * level.resolution + 0.5);
        };
        float sum = 0;
        for (unsigned k = 0; k < 8; ++k) {
          const std::uint32_t cx = cell(x[i]) + (k & 1U), cy = cell(y[i]) + (k >> 1U & 1U),
                              cz = cell(z[i]) + (k >> 2U);
          const std::uint32_t entry =
              level.hashed ? (cx ^ (cy * 2654435761U) ^ (cz * 805459861U)) & (level.entries - 1)
                           : cx + level.side * (cy + level.side * cz);
          EXPECT_EQ(block.entry[k][i], entry) << level.resolution << " " << x[i] << " " << k;
          EXPECT_LT(block.entry[k][i], level.entries);
          EXPECT_GE(block.weight[k][i], 0);
          sum += block.weight[k][i];
        }
        EXPECT_NEAR(sum, 1, 1e-6);
      }
    }
  }
  EXPECT_FALSE(levels.front().hashed);
  EXPECT_TRUE(levels.back().hashed);
  EXPECT_EQ(levels.front().resolution, 4);
  EXPECT_EQ(levels.back().resolution, 256);
}

TEST(HashGrid, ALinearFieldIsEncodedAsItIsForAnyNumberOfPoints) {
  GridLevel level = grid_levels({1, 17, 16, 16}).front();
  ASSERT_FALSE(level.hashed);
  std::vector<float> table(std::size_t{kFeatures} * level.entries);
  for (std::uint32_t entry = 0; entry < level.entries; ++entry) {
    const std::uint32_t cx = entry % level.side, cy = entry / level.side % level.side,
                        cz = entry / level.side / level.side;
    table[2 * entry] = static_cast<float>(cx) + 10 * static_cast<float>(cy);
    table[2 * entry + 1] = static_cast<float>(cz);
  }
  Rng draw(3);
  for (const int count : {0, 1, 7, 8, 9, 16, 21}) {
    std::vector<float> x, y, z, first(static_cast<std::size_t>(count) + 1, -1), second = first;
    for (int i = 0; i < count; ++i) {
      for (auto* row : {&x, &y, &z}) row->push_back(static_cast<float>(uniform(draw)));
    }
    encode_level(level, table.data(), x.data(), y.data(), z.data(), count, first.data(),
                 second.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      EXPECT_NEAR(first[i], 16 * (x[i] + 10 * y[i]) + 5.5F, 1e-3);
      EXPECT_NEAR(second[i], 16 * z[i] + 0.5F, 1e-4);
    }
    EXPECT_EQ(first.back(), -1) << "wrote beyond its points";
    EXPECT_EQ(second.back(), -1);
  }
}

}  // namespace
}  // namespace cousin::ngp
