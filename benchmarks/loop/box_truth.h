#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/dataset/truth_io.h"
#include "sim/types/seams.h"

namespace cousin {

/// A specimen as one image shows it.
struct TrueBox {
  std::size_t sensor = 0;  ///< of the rig
  std::size_t view = 0;    ///< place among the sensor's views
  int frame = 0;
  int specimen = 0;  ///< place in specimens_of()
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero(), high_px = Eigen::Vector2d::Zero();
  int pixels = 0;  ///< that show it
  /// The surface under the middle of the box, or where something else is there, at the nearest
  /// pixel that shows the specimen: in that camera's axes, by its true lens.
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  /// Places of a fruit in that camera's axes, at the time when the box's middle row is read. The
  /// centre is its model's origin, the axis its model's z. Calyx and cut are its keypoints
  /// calyx_centre and cut_point; NaN where it has none.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Constant(kNaN);
  Eigen::Vector3d calyx_m = Eigen::Vector3d::Constant(kNaN);
  Eigen::Vector3d cut_m = Eigen::Vector3d::Constant(kNaN);
  Eigen::Vector3d axis = Eigen::Vector3d::Constant(kNaN);
};
/// The boxes of all views of a sensor, view after view.
/// @throws std::invalid_argument if a view has no true depth or no true instances
std::vector<TrueBox> true_boxes_of(const SceneTruth& truth, std::size_t sensor = 0);

/// Place of each true box's measured one, that it overlaps most and by at least half (intersection
/// over union), each once; -1 where there is none.
std::vector<int> match_boxes(const std::vector<TrueBox>& truth, const Boxes& measured);

}  // namespace cousin
