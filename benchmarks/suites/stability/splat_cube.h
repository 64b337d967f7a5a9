#pragma once

#include "perception/splats/splat_model.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// 400 Gaussians of all shapes, turns and opacities in a cube of 1 m about zero, for the cases that
/// begin from a model with nothing wrong; and a camera of 108 x 75 pixels that sees it whole.
SplatModel cube_of_splats();
Camera cube_camera();
Pose view_of_cube();
/// The i-th of so many places on a ring about the cube, from above.
Pose ring_pose(int i, int views = 8);

}  // namespace cousin
