#pragma once

#include <Eigen/Core>

#include "sim/types/camera.h"

namespace cousin {

/// d(pixel)/d(coefficient) for the coefficients of `camera`'s lens model, in their order; 2 x
/// distortion_count.
/// @param point_in_camera_m  a point that `project` accepts
Eigen::Matrix<double, 2, Eigen::Dynamic> d_pixel_d_distortion(
    const Camera& camera, const Eigen::Vector3d& point_in_camera_m);

}  // namespace cousin
