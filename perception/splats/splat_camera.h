#pragma once

#include "perception/splats/splat_planes.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// A pinhole camera as the kernels use it: floats, relative to a model's origin. Differences with
/// the origin are taken in double first, so a scene far from zero loses nothing.
struct SplatCamera {
  float rotation[9]{};     ///< camera from world, row by row
  float translation[3]{};  ///< camera from origin, metres
  float centre[3]{};       ///< of the camera, from the origin, metres
  float fx = 0, fy = 0, cx = 0, cy = 0;
  /// x/z and y/z of a centre are clamped to these in the Jacobian: image plus 0.3 of its half.
  float u_min = 0, u_max = 0, v_min = 0, v_max = 0;
  float near_m = 0;           ///< centres at less depth are left out; > 0
  float low_pass_px2 = 0.3F;  ///< added to the variances in the image; 0.3 in full-size images
  int width_px = 0;
  int height_px = 0;
};

/// @throws std::invalid_argument if the camera is not a valid pinhole, the pose not finite, or
/// near_m not a positive finite number.
SplatCamera splat_camera(const Camera& camera, const Pose& camera_from_world,
                         const Eigen::Vector3d& origin_in_world_m, double near_m);

/// `share` of the median depth of all finite centres in front of the camera; 1e-6 times `share` if
/// there is none.
double near_depth_m(const SplatPlanes& planes, const Pose& camera_from_world,
                    const Eigen::Vector3d& origin_in_world_m, double share);

}  // namespace cousin
