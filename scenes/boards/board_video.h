#pragma once

#include <vector>

#include "sim/types/pose.h"

namespace cousin {

/// A smooth way past poses: a uniform cubic B-spline, whose velocity and acceleration have no jump,
/// over translations, and over quaternions that are then made of unit length. It stays between the
/// poses and meets none. Private to scenes/boards.
class PosePath {
 public:
  /// @param step_s  from one pose to the next
  /// @throws std::invalid_argument for fewer than four poses
  PosePath(std::vector<Pose> poses, double step_s);
  /// How many poses a path of so long needs.
  static int pose_count(double length_s, double step_s);
  /// At a time from 0 to (poses - 3) steps; held beyond.
  Pose at(double time_s) const;

 private:
  std::vector<Pose> poses_;  ///< each quaternion on its neighbour's side
  double step_s_;
};

}  // namespace cousin
