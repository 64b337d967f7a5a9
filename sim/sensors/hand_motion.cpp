#include "sim/sensors/hand_motion.h"

#include <Eigen/Geometry>

namespace cousin {

Eigen::Vector3d normal3(Rng& rng) {
  const double x = normal(rng);
  const double y = normal(rng);
  return {x, y, normal(rng)};
}

HandMotion draw_hand_motion(double speed_m_per_s, double rate_rad_per_s, Rng rng) {
  HandMotion motion;
  motion.velocity_m_per_s = speed_m_per_s * normal3(rng);
  motion.rate_rad_per_s = rate_rad_per_s * normal3(rng);
  return motion;
}

Pose moved_rig_from_rig(const HandMotion& motion, double time_s) {
  Pose pose;
  pose.translation_m = time_s * motion.velocity_m_per_s;
  const double rate = motion.rate_rad_per_s.norm();
  if (rate > 0) {
    pose.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(time_s * rate, motion.rate_rad_per_s / rate));
  }
  return pose;
}

}  // namespace cousin
