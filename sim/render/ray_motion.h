#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/types/pose.h"

namespace cousin {

/// Poses of an instance evenly over a span, as few as keep each step within one degree and what
/// lies between steps within 1e-6 of the object's size and path; 129 at most, even where the motion
/// has kinks between them. One where it stands
/// still. `reach_m`: farthest point of the object from its origin. Private to sim/render.
std::vector<Pose> motion_steps(const Instance& instance, const TimeSpan& span_s, double reach_m);

/// The pose at a fraction of the way through even steps: the translation linear, the rotation by
/// normalised linear interpolation of quaternions, which is what Embree does for small angles.
Pose pose_between(const std::vector<Pose>& steps, double fraction);

}  // namespace cousin
