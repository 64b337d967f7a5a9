#include "benchmarks/suites/splats/ngp_kernel_rows.h"

#include <string>

#include "benchmarks/suites/splats/core_time.h"
#include "perception/ngp/field_network.h"
#include "perception/ngp/hash_grid.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using namespace ngp;

constexpr int kOfRay = 16;
constexpr int kBatch = 256;       ///< samples that pass the networks together
constexpr float kStep = 0.0034F;  ///< of a ray, in cubes

/// Samples of rays that cross the cube.
struct Samples {
  std::vector<float> x, y, z;
};
Samples samples_on_rays(int count, Rng rng) {
  Samples samples;
  for (int ray = 0; ray < count / kOfRay; ++ray) {
    float at[3], step[3];
    for (int k = 0; k < 3; ++k) {
      at[k] = static_cast<float>(uniform(rng));
      step[k] = kStep * static_cast<float>(uniform(rng, -1, 1));
    }
    for (int s = 0; s < kOfRay; ++s) {
      samples.x.push_back(at[0] + static_cast<float>(s) * step[0]);
      samples.y.push_back(at[1] + static_cast<float>(s) * step[1]);
      samples.z.push_back(at[2] + static_cast<float>(s) * step[2]);
    }
  }
  return samples;
}

/// @param seconds  of all samples
ScoreRow row_of(const std::string& method, const std::string& metric, double seconds, int samples) {
  ScoreRow row;
  row.suite = "splats";
  row.scene = "radiance field";
  row.case_name = "samples on rays";
  row.method = method;
  row.metric = metric;
  row.value = seconds / samples;
  row.unit = "s/sample";
  row.n = samples;
  return row;
}

void grid_rows(const Samples& samples, Rng rng, std::vector<ScoreRow>& rows) {
  const std::vector<GridLevel> levels = grid_levels({});
  std::vector<float> table(table_size(levels)), d_table(table.size());
  for (float& number : table) number = static_cast<float>(uniform(rng, -1, 1));
  const auto count = static_cast<int>(samples.x.size());
  std::vector<float> first(samples.x.size()), second(samples.x.size());
  // Level after level over all samples, as a training does it.
  const double encode = best_core_seconds([&] {
    for (const GridLevel& level : levels)
      encode_level(level, table.data(), samples.x.data(), samples.y.data(), samples.z.data(), count,
                   first.data(), second.data());
  });
  const double add = best_core_seconds([&] {
    for (const GridLevel& level : levels)
      add_derivatives(level, samples.x.data(), samples.y.data(), samples.z.data(), count,
                      first.data(), second.data(), d_table.data());
  });
  rows.push_back(row_of("hash grid", "seconds.encode", encode, count));
  rows.push_back(row_of("hash grid", "seconds.derivatives", add, count));
}

void network_rows(const char* name, const DenseKernels<float>& kernels, int samples, Rng rng,
                  std::vector<ScoreRow>& rows) {
  const NetworkShape shape;
  std::vector<float> weights(shape.size()), d_weights(shape.size());
  for (float& weight : weights) weight = static_cast<float>(uniform(rng, -0.2, 0.2));
  FieldBatch<float> batch, gradient;
  batch.resize(shape, kBatch);
  gradient.resize(shape, kBatch);
  for (auto* values : {&batch.encoded, &batch.described, &gradient.color}) {
    for (float& value : *values) value = static_cast<float>(uniform(rng, -1, 1));
  }
  const std::vector<float> d_log_density(kBatch, 0.1F);
  const double forward = best_core_seconds([&] {
    for (int s = 0; s < samples; s += kBatch) field_forward(shape, kernels, weights.data(), batch);
  });
  const double backward = best_core_seconds([&] {
    for (int s = 0; s < samples; s += kBatch)
      field_backward(shape, kernels, weights.data(), batch, d_log_density.data(), gradient,
                     d_weights.data());
  });
  const std::string method = std::string("networks, ") + name;
  rows.push_back(row_of(method, "seconds.forward", forward, samples));
  rows.push_back(row_of(method, "seconds.backward", backward, samples));
  ScoreRow products = rows[rows.size() - 2];
  products.metric = "products.forward";
  products.value = static_cast<double>(shape.size()) / products.value;
  products.unit = "1/s";
  rows.push_back(products);
}

}  // namespace

std::vector<ScoreRow> ngp_kernel_rows(std::uint64_t seed, int samples) {
  const Rng rng = Rng(seed).fork("radiance field");
  std::vector<ScoreRow> rows;
  grid_rows(samples_on_rays(samples, rng.fork("rays")), rng.fork("table"), rows);
  if (dense_kernels_avx2().forward != nullptr)
    network_rows("avx2", dense_kernels_avx2(), samples, rng.fork("weights"), rows);
  network_rows("portable", dense_kernels_portable(), samples, rng.fork("weights"), rows);
  for (ScoreRow& row : rows) row.seed = seed;
  return rows;
}

}  // namespace cousin
