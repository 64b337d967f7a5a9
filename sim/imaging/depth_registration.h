#pragma once

#include <cstdint>

#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

/// A depth image as seen from another camera: every pixel's square is drawn at its depth as the
/// rectangle of whole pixels between its projected corners and half a pixel beside, so that a
/// slanted surface has no gaps (librealsense's align.cpp rounds both corners in, for as much); the
/// nearest wins. Depth is along the other camera's axis, in the same unit; 0 = none.
/// @param depth  times `unit_m` = metres along the depth camera's axis; 0 = none.
/// @throws std::invalid_argument for an invalid camera, a size that is not the camera's, or a unit
/// that is not positive.
Image<std::uint16_t> register_depth(const Image<std::uint16_t>& depth, double unit_m,
                                    const Camera& depth_camera, const Camera& other,
                                    const Pose& other_from_depth);

}  // namespace cousin
