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

/// Points in the unit cube of the encoding, as columns of a batch: padded to kBatchStep.
struct EncodedPoints {
  std::vector<float> x, y, z;
  std::vector<float> features;  ///< rows 2 * level + f of columns() numbers

  int columns() const { return static_cast<int>(x.size()); }
  /// Makes room for so many points and their features, all at the cube's corner.
  void resize(const NetworkShape& shape, std::size_t count);
  void set(const NgpModel& model, std::size_t i, const Eigen::Vector3f& inner);
  /// Features of one level.
  void encode_level(const NgpModel& model, const std::vector<GridLevel>& levels, std::size_t level);
};

/// A bundle of rays through a field: samples ray after ray, as columns of a batch.
struct RayBundle {
  std::vector<RaySample> samples;  ///< of all rays
  std::vector<int> begin;          ///< of each ray, and the end of the last
  std::vector<float> length;       ///< of each column
  EncodedPoints points;
  std::vector<RaySample> of_ray;

  void clear();
  /// Appends a ray of these samples.
  void add(std::span<const RaySample> of_one_ray);
  /// Marches one ray and appends its samples.
  void add(const NgpModel& model, const MarchConfig& march, const Eigen::Vector3f& origin,
           const Eigen::Vector3f& direction, float jitter);
  /// Sets `points` and `length` by all samples; features are still to be encoded.
  void place(const NgpModel& model);
  /// Runs both networks on the encoded points with their rays' harmonics. The features are then in
  /// the batch, and no longer here.
  void pass(const NgpModel& model, const DenseKernels<float>& kernels,
            std::span<const std::array<float, kHarmonics>> directions, FieldBatch<float>& batch);
  /// All three.
  void run(const NgpModel& model, const std::vector<GridLevel>& levels,
           const DenseKernels<float>& kernels,
           std::span<const std::array<float, kHarmonics>> directions, FieldBatch<float>& batch);
  /// One ray of a batch that has passed.
  RaySamples<float> ray(const FieldBatch<float>& batch, std::size_t r) const;
};

/// Scratch of `densities`.
struct DensityScratch {
  EncodedPoints points;
  FieldBatch<float> batch;
};
/// Densities at points of inner coordinates (at most a few thousand at a time).
void densities(const NgpModel& model, const std::vector<GridLevel>& levels,
               const DenseKernels<float>& kernels, std::span<const Eigen::Vector3f> at,
               DensityScratch& scratch, std::span<float> out);

NetworkShape network_shape(const NgpConfig& config);

}  // namespace cousin::ngp
