#include "perception/ngp/ngp_rays.h"

#include <Eigen/Cholesky>
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

NgpVolume choose_volume(const NgpConfig& config, std::span<const NgpView> views) {
  NgpVolume volume;
  volume.cascades = config.cascades;
  if (!config.centre_m.empty()) {
    volume.centre_in_world_m = {config.centre_m[0], config.centre_m[1], config.centre_m[2]};
  } else {
    // Least squares of the distances to the optical axes; cameras in one row leave a line open,
    // where a weak pull to their mean decides.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero(), mean = Eigen::Vector3d::Zero();
    for (const NgpView& view : views) {
      const Eigen::Vector3d axis =
          view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
      const Eigen::Vector3d eye = cousin::centre_in_world_m(view.camera_from_world);
      normal += across;
      right += across * eye;
      mean += eye / static_cast<double>(views.size());
    }
    const double pull = 1e-6 * static_cast<double>(views.size());
    normal += pull * Eigen::Matrix3d::Identity();
    volume.centre_in_world_m = normal.ldlt().solve(right + pull * mean);
  }
  volume.side_m = config.side_m;
  if (config.side_m <= 0) {
    std::vector<double> distance_m;
    for (const NgpView& view : views) {
      const Eigen::Vector3d seen = view.camera_from_world * volume.centre_in_world_m;
      if (seen.z() > 0) distance_m.push_back(seen.norm());
    }
    if (2 * distance_m.size() < views.size()) return volume;
    const auto middle = distance_m.begin() + static_cast<std::ptrdiff_t>(distance_m.size() / 2);
    std::nth_element(distance_m.begin(), middle, distance_m.end());
    volume.side_m = std::isfinite(*middle) ? *middle : 0;
  }
  return volume;
}

void RayBundle::clear() {
  samples.clear();
  begin.assign(1, 0);
}

void RayBundle::add(const NgpModel& model, const MarchConfig& config, const Eigen::Vector3f& origin,
                    const Eigen::Vector3f& direction, float jitter) {
  of_ray.clear();
  if (direction.squaredNorm() > 0)
    march(model.volume, model.occupancy, config, origin, direction, jitter, of_ray);
  samples.insert(samples.end(), of_ray.begin(), of_ray.end());
  begin.push_back(static_cast<int>(samples.size()));
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
