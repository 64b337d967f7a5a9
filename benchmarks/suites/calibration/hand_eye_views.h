#pragma once

#include "calibration/devices/hand_eye.h"
#include "sim/types/rng.h"

namespace cousin {

enum class ArmMotion { free, translation, one_axis };

/// A camera on an arm before a board, computed corners and arm noise.
struct HandEyeViewsConfig {
  int stops = 20;
  ArmMotion motion = ArmMotion::free;
  double corner_px = 0.1;
  double arm_m = 2e-4;                        ///< deviation of each coordinate
  double arm_rad = 0.02 / 57.29577951308232;  ///< of the rotation about each axis
};

struct HandEyeViews {
  HandEyeInput input;
  Pose gripper_from_camera;  ///< true
};
HandEyeViews make_hand_eye_views(const HandEyeViewsConfig& config, const Rng& rng);

struct HandEyeError {
  double place_m = 0;
  double turn_rad = 0;
};
HandEyeError hand_eye_error(const HandEyeViews& views, const HandEyeResult& result);

}  // namespace cousin
