#pragma once

#include <Eigen/Core>
#include <vector>

#include "perception/splats/splat_planes.h"

namespace cousin {

/// All that training carries from step to step: with the views and the configuration it determines
/// every later byte.
struct SplatTrainState {
  int step = 0;  ///< done
  int rest_updates = 0;
  int started_with = 0;  ///< Gaussians
  Eigen::Vector3d origin_in_world_m = Eigen::Vector3d::Zero();
  double extent_m = 0;         ///< of the scene, found at the start; 0 = not yet
  std::vector<double> near_m;  ///< of each view, found when it is first shown after the Gaussians
                               ///< changed in number; 0 = not yet
  SplatPlanes values, first_moment, second_moment;
  /// Since the last change of number: |gradient| of centres in images of width and height 2, and in
  /// how many images. One float a Gaussian, padded.
  std::vector<float> gradient_sum, gradient_count;

  bool operator==(const SplatTrainState&) const = default;
};

/// @param start  its splats with finite parameters; the rest are dropped
SplatTrainState start_training(const SplatModel& start);

/// Keeps Gaussians `source[i]` with their moments; those of -1 - n stand for a copy of n whose
/// moments begin at zero. Clears the gradient sums.
void gather(SplatTrainState& state, const std::vector<int>& source);

}  // namespace cousin
