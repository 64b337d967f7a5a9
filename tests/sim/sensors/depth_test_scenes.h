#pragma once

#include "sim/render/ray_scene.h"
#include "sim/sensors/active_stereo.h"

namespace cousin::test {

/// A D457-like camera of 320 x 240 pixels without errors of calibration: f B = 192 * 0.095 = 18.24.
ActiveStereoConfig small_depth_camera();

/// Rectangle at depth z_m before the rig at the origin that looks along +x: from left to right and
/// top to bottom in metres of the rig's x and y.
void add_plate(Scene& scene, double z_m, double left_m, double top_m, double right_m,
               double bottom_m, const Material& material);
/// Grey for the infrared; `contrast` > 0 adds a fine print.
Material infrared_grey(float albedo, float contrast = 0, double scale_m = 0.006);
Pose rig_looking_along_x();
/// An even sky of this irradiance.
Sky even_sky(double irradiance);

StereoDepth look(const Scene& scene, const ActiveStereoConfig& config, std::uint64_t seed = 1);

}  // namespace cousin::test
