#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// A camera with its place in the rig, for calibration files of other programs. All of them count
/// pixels from a pixel's centre and look along +z with x right and y down, as we do; lengths are
/// written in metres, numbers so that they read back equal.
struct CalibratedCamera {
  std::string name;  ///< of the sensor
  Camera camera;
  Pose camera_from_reference;  ///< the reference is the rig
};

/// Each @throws std::invalid_argument naming the camera, its lens model and the format that does
/// not hold it.

/// OpenCV FileStorage YAML: camera_matrix, distortion_coefficients (4 of a fisheye, which
/// distortion_model then says), and R and T with X_camera = R X_first + T. No splines.
std::string opencv_yaml(const CalibratedCamera& camera, const CalibratedCamera& first);
/// ROS camera_info: plumb_bob, rational_polynomial or equidistant; no rectification. No thin
/// prisms, no splines.
std::string ros_camera_info(const CalibratedCamera& camera);
/// Kalibr's camchain of all cameras: pinhole with radtan (k1 k2 p1 p2), equidistant or none;
/// T_cn_cnm1 takes one camera's coordinates to the next one's.
std::string kalibr_camchain(const std::vector<CalibratedCamera>& cameras);
/// mrcal's .cameramodel: pinhole, OPENCV5, 8 and 12, and splines of whole degrees; extrinsics take
/// the reference to the camera. No Kannala-Brandt.
std::string mrcal_cameramodel(const CalibratedCamera& camera);

/// A .cameramodel of those lens models or OPENCV4; keys of calibration runs are passed over.
/// @param name  for errors. @throws std::runtime_error naming it, the key, value and limit.
CalibratedCamera camera_from_mrcal(std::string_view text, const std::string& name);

/// The cameras of a Kalibr camchain; each one's reference is the first. @throws as
/// camera_from_mrcal.
std::vector<CalibratedCamera> cameras_from_kalibr(std::string_view text, const std::string& name);

}  // namespace cousin
