#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace cousin {

/// One object that several images show: tracks.json.
struct Track {
  int id = 0;
  std::vector<int> boxes;  ///< ids of boxes.json, each of another image and in one track alone
  /// Of the object; NaN: not known.
  Eigen::Vector3d centre_in_world_m =
      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< zero: not known
};
using Tracks = std::vector<Track>;

}  // namespace cousin
