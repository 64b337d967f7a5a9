#include "perception/ngp/ngp_rays.h"

#include <algorithm>
#include <cmath>

#include "perception/silhouette/spherical_harmonics.h"

namespace cousin::ngp {

Image<Eigen::Vector3f> pixel_directions(const Camera& camera) {
  Image<Eigen::Vector3f> out(camera.width_px, camera.height_px, Eigen::Vector3f::Zero());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (const auto direction = unproject(camera, Eigen::Vector2d(x, y)))
        out(x, y) = direction->cast<float>();
    }
  }
  return out;
}

std::array<float, kHarmonics> harmonics(const Eigen::Vector3f& unit) {
  static const RealHarmonics kBasis(3);
  Eigen::Matrix<double, kHarmonics, 1> values;
  kBasis.evaluate(unit.cast<double>(), values);
  std::array<float, kHarmonics> out;
  for (int i = 0; i < kHarmonics; ++i)
    out[static_cast<std::size_t>(i)] = static_cast<float>(values(i));
  return out;
}

MarchConfig march_config(const NgpConfig& config) {
  MarchConfig march;
  march.shortest = std::sqrt(3.0) / config.steps;
  march.cone = config.cascades > 1 ? 1.0 / 256 : 0;
  return march;
}

NetworkShape network_shape(const NgpConfig& config) { return {kFeatures * config.grid.levels}; }

void EncodedPoints::resize(const NetworkShape& shape, std::size_t count) {
  const std::size_t columns = (count + kBatchStep - 1) / kBatchStep * kBatchStep;
  for (auto* values : {&x, &y, &z}) values->assign(columns, 0);
  features.resize(static_cast<std::size_t>(shape.encoded) * columns);
}

void EncodedPoints::set(const NgpModel& model, std::size_t i, const Eigen::Vector3f& inner) {
  const auto scale = static_cast<float>(0.5 / model.volume.reach());
  x[i] = inner.x() * scale + 0.5F;
  y[i] = inner.y() * scale + 0.5F;
  z[i] = inner.z() * scale + 0.5F;
}

void EncodedPoints::encode_level(const NgpModel& model, const std::vector<GridLevel>& levels,
                                 std::size_t level) {
  float* first = features.data() + kFeatures * level * x.size();
  ngp::encode_level(levels[level], model.table.data(), x.data(), y.data(), z.data(), columns(),
                    first, first + x.size());
}

void RayBundle::clear() {
  samples.clear();
  begin.assign(1, 0);
}

void RayBundle::add(std::span<const RaySample> of_one_ray) {
  samples.insert(samples.end(), of_one_ray.begin(), of_one_ray.end());
  begin.push_back(static_cast<int>(samples.size()));
}

void RayBundle::add(const NgpModel& model, const MarchConfig& config, const Eigen::Vector3f& origin,
                    const Eigen::Vector3f& direction, float jitter) {
  of_ray.clear();
  if (direction.squaredNorm() > 0)
    march(model.volume, model.occupancy, config, origin, direction, jitter, of_ray);
  add(of_ray);
}

void RayBundle::place(const NgpModel& model) {
  points.resize(network_shape(model.config), samples.size());
  length.assign(points.x.size(), 0);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    points.set(model, s, samples[s].at);
    length[s] = samples[s].length;
  }
}

void RayBundle::pass(const NgpModel& model, const DenseKernels<float>& kernels,
                     std::span<const std::array<float, kHarmonics>> directions,
                     FieldBatch<float>& batch) {
  const NetworkShape shape = network_shape(model.config);
  batch.resize(shape, points.columns());
  std::swap(batch.encoded, points.features);
  const std::size_t n = points.x.size();
  for (std::size_t k = 0; k < kHarmonics; ++k) {
    float* row = batch.described.data() + (kGeometry + k) * n;
    std::fill(row + samples.size(), row + n, 0.0F);
    for (std::size_t r = 0; r + 1 < begin.size(); ++r)
      std::fill(row + begin[r], row + begin[r + 1], directions[r][k]);
  }
  field_forward(shape, kernels, model.weights.data(), batch);
}

void RayBundle::run(const NgpModel& model, const std::vector<GridLevel>& levels,
                    const DenseKernels<float>& kernels,
                    std::span<const std::array<float, kHarmonics>> directions,
                    FieldBatch<float>& batch) {
  place(model);
  for (std::size_t l = 0; l < levels.size(); ++l) points.encode_level(model, levels, l);
  pass(model, kernels, directions, batch);
}

RaySamples<float> RayBundle::ray(const FieldBatch<float>& batch, std::size_t r) const {
  RaySamples<float> out;
  out.count = begin[r + 1] - begin[r];
  out.log_density = batch.described.data() + begin[r];
  out.color = batch.color.data() + begin[r];
  out.stride = batch.samples;
  out.length = length.data() + begin[r];
  return out;
}

void densities(const NgpModel& model, const std::vector<GridLevel>& levels,
               const DenseKernels<float>& kernels, std::span<const Eigen::Vector3f> at,
               DensityScratch& scratch, std::span<float> out) {
  const NetworkShape shape = network_shape(model.config);
  scratch.points.resize(shape, at.size());
  for (std::size_t s = 0; s < at.size(); ++s) scratch.points.set(model, s, at[s]);
  for (std::size_t l = 0; l < levels.size(); ++l) scratch.points.encode_level(model, levels, l);
  scratch.batch.resize(shape, scratch.points.columns());
  std::swap(scratch.batch.encoded, scratch.points.features);
  field_density(shape, kernels, model.weights.data(), scratch.batch);
  for (std::size_t s = 0; s < at.size(); ++s) out[s] = density_of(scratch.batch.described[s]);
}

}  // namespace cousin::ngp
