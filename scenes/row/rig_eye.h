#pragma once

#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// The camera of a rig that targets are seen by: nominal lens and place. Not a key: it follows from
/// the rig.
struct RigEye {
  Camera camera{.width_px = 640,
                .height_px = 480,
                .fx_px = 390,
                .fy_px = 390,
                .cx_px = 319.5,
                .cy_px = 239.5};
  Pose eye_from_rig;
};

}  // namespace cousin
