#pragma once

#include <Eigen/Core>

#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin {

/// Three normals, x first.
Eigen::Vector3d normal3(Rng& rng);

/// How what carries a rig moves while a frame is taken, in the rig's axes; constant for the frame.
struct HandMotion {
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
};

/// Each component normal with the given sigma.
HandMotion draw_hand_motion(double speed_m_per_s, double rate_rad_per_s, Rng rng);

/// The rig's frame at time 0 to that at `time_s`, of either sign.
Pose moved_rig_from_rig(const HandMotion& motion, double time_s);

}  // namespace cousin
