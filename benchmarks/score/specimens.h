#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace cousin {

struct SpecimenMatch {
  int measured = 0;  ///< index into the measured centroids
  int truth = 0;     ///< index into the true ones
  double distance_m = 0;
};

struct SpecimenMatching {
  std::vector<SpecimenMatch> matches;  ///< by measured index; each index at most once
  std::vector<int> spurious;           ///< measured ones without a true one
  std::vector<int> missed;             ///< true ones without a measured one
};

/// Pairs measured with true specimens by their centroids: of all assignments whose pairs are at
/// most `gate_m` apart, one with the most pairs, and among those the least sum of distances [Kuhn
/// 1955, Munkres 1957; shortest augmenting paths]. Centroids that are not finite match nothing.
/// Cubic in the count.
/// @throws std::invalid_argument if the gate is not positive.
SpecimenMatching match_specimens(std::span<const Eigen::Vector3d> measured_in_world_m,
                                 std::span<const Eigen::Vector3d> truth_in_world_m, double gate_m);

}  // namespace cousin
