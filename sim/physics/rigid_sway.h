#pragma once

#include <vector>

#include "sim/config/fields.h"
#include "sim/physics/wind.h"
#include "sim/truth/scene.h"

namespace cousin {

/// A whole plant that sways about its foot as one rigid body: the first mode of a stem that is
/// stiffest at its tip, without the flutter of leaves. Each of its two lean angles is a damped
/// oscillator that the drag drives: a'' + 2 zeta w a' + w^2 (a - lean u |u|) = 0, w = 2 pi f.
struct RigidSwayConfig {
  double frequency_hz = 1;        ///< of free swings
  double damping = 0.1;           ///< zeta, share of the critical
  double lean_rad_s2_m2 = 0.004;  ///< at rest in a wind of u m/s it leans by this times u^2
  double frequency_spread = 0.1;  ///< sigma from plant to plant over the mean
};
Fields fields(RigidSwayConfig& config);

/// Poses of a plant in the wind about the times of views: from 0.1 s before each to 0.5 s after, in
/// steps of 5 ms, which is what exposures, readouts and a rig's other sensors see. Between them it
/// is interpolated, and means nothing. The swing begins 8 periods before the first.
/// @param at_rest  world from the plant, whose foot is its origin  @param at_m  where it feels the
/// wind, in its axes
/// @throws std::invalid_argument for a step of more than a twentieth of the period, or times that
/// are not sorted.
std::vector<TimedPose> rigid_sway(const RigidSwayConfig& config, const WindField& wind,
                                  const Pose& at_rest, const Eigen::Vector3d& at_m,
                                  const std::vector<double>& times_s, Rng rng);

/// "wind", the mean speed, and the rest of its numbers under "gusts.": keys of a scene.
Fields scene_wind_fields(WindConfig& config);

/// Gives all specimens of a scene their motion in a wind, for its views. Each feels the wind at
/// `height_share` of its trait "height". Still air changes nothing.
void sway_specimens(Scene& scene, const WindConfig& wind, const RigidSwayConfig& config,
                    double height_share, const Rng& rng);

}  // namespace cousin
