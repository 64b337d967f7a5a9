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

void RayBundle::run(const NgpModel& model, const std::vector<GridLevel>& levels,
                    const DenseKernels<float>& kernels,
                    std::span<const std::array<float, kHarmonics>> directions) {
  const NetworkShape shape = network_shape(model.config);
  batch.resize(shape, static_cast<int>(samples.size()));
  const auto n = static_cast<std::size_t>(batch.samples);
  for (auto* values : {&x, &y, &z, &length}) values->assign(n, 0);
  const auto scale = static_cast<float>(0.5 / model.volume.reach());
  for (std::size_t s = 0; s < samples.size(); ++s) {
    x[s] = samples[s].at.x() * scale + 0.5F;
    y[s] = samples[s].at.y() * scale + 0.5F;
    z[s] = samples[s].at.z() * scale + 0.5F;
    length[s] = samples[s].length;
  }
  encode(levels, model.table.data(), x.data(), y.data(), z.data(), batch.samples,
         batch.encoded.data(), batch.samples);
  for (std::size_t k = 0; k < kHarmonics; ++k) {
    float* row = batch.described.data() + (kGeometry + k) * n;
    std::fill(row + samples.size(), row + n, 0.0F);
    for (std::size_t r = 0; r + 1 < begin.size(); ++r)
      std::fill(row + begin[r], row + begin[r + 1], directions[r][k]);
  }
  field_forward(shape, kernels, model.weights.data(), batch);
}

RaySamples<float> RayBundle::ray(std::size_t r) const {
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
               RayBundle& scratch, std::span<float> out) {
  const NetworkShape shape = network_shape(model.config);
  scratch.batch.resize(shape, static_cast<int>(at.size()));
  const auto n = static_cast<std::size_t>(scratch.batch.samples);
  for (auto* values : {&scratch.x, &scratch.y, &scratch.z}) values->assign(n, 0);
  const auto scale = static_cast<float>(0.5 / model.volume.reach());
  for (std::size_t s = 0; s < at.size(); ++s) {
    scratch.x[s] = at[s].x() * scale + 0.5F;
    scratch.y[s] = at[s].y() * scale + 0.5F;
    scratch.z[s] = at[s].z() * scale + 0.5F;
  }
  encode(levels, model.table.data(), scratch.x.data(), scratch.y.data(), scratch.z.data(),
         scratch.batch.samples, scratch.batch.encoded.data(), scratch.batch.samples);
  field_density(shape, kernels, model.weights.data(), scratch.batch);
  for (std::size_t s = 0; s < at.size(); ++s) out[s] = density_of(scratch.batch.described[s]);
}

}  // namespace cousin::ngp
