#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "perception/ngp/field_network.h"
#include "perception/ngp/ngp.h"
#include "perception/ngp/ray_composite.h"

namespace cousin::ngp {

/// Unit directions of all pixels of a camera, in its axes; zero where the lens has none.
Image<Eigen::Vector3f> pixel_directions(const Camera& camera);

/// The 16 real spherical harmonics up to degree 3 of a unit direction.
std::array<float, kHarmonics> harmonics(const Eigen::Vector3f& unit);

/// The shortest step and how steps grow, as a configuration says.
MarchConfig march_config(const NgpConfig& config);

/// A bundle of rays through a field: samples ray after ray, as columns of a batch.
struct RayBundle {
  std::vector<RaySample> samples;      ///< of all rays
  std::vector<int> begin;              ///< of each ray, and the end of the last
  std::vector<float> x, y, z, length;  ///< x, y, z in the unit cube of the encoding; padded
  FieldBatch<float> batch;
  std::vector<RaySample> of_ray;

  void clear();
  /// Appends a ray of these samples.
  void add(std::span<const RaySample> of_one_ray);
  /// Marches one ray and appends its samples.
  void add(const NgpModel& model, const MarchConfig& march, const Eigen::Vector3f& origin,
           const Eigen::Vector3f& direction, float jitter);
  /// Encodes all samples with their rays' harmonics and runs both networks.
  void run(const NgpModel& model, const std::vector<GridLevel>& levels,
           const DenseKernels<float>& kernels,
           std::span<const std::array<float, kHarmonics>> directions);
  RaySamples<float> ray(std::size_t r) const;
};

/// Densities at points of inner coordinates (at most a few thousand at a time).
void densities(const NgpModel& model, const std::vector<GridLevel>& levels,
               const DenseKernels<float>& kernels, std::span<const Eigen::Vector3f> at,
               RayBundle& scratch, std::span<float> out);

NetworkShape network_shape(const NgpConfig& config);

}  // namespace cousin::ngp
