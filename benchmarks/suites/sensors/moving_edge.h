#pragma once

#include "sim/sensors/rig.h"

namespace cousin {

/// The rig's camera at 640 px width (its own shape, focal length and times), without distortion.
RigConfig small_rig(const RigConfig& config);

/// A camera that moves sideways before a wall with a straight upright edge, its views made by
/// `true_views`, seen through the truth pass: where the edge is in each row, against f v t / Z.
struct MovingEdge {
  double skew_px = 0;           ///< last row against first, from a straight line through all rows
  double expected_skew_px = 0;  ///< |f v readout / Z|
  double blur_px = 0;  ///< length of the edge's trail over the exposure, from 65 views of its time
  double expected_blur_px = 0;  ///< |f v exposure / Z|
};
MovingEdge measure_moving_edge(const RigConfig& rig, std::size_t sensor);

/// Spots all over the image through `config`'s optics at 640 px width, noise-free: where red and
/// blue land against the radial maps.
struct LateralColour {
  double error_px = 0;         ///< largest
  double displacement_px = 0;  ///< largest from green that the maps have
};
LateralColour measure_lateral_colour(const CameraSensorConfig& config);

}  // namespace cousin
