#pragma once

#include "sim/config/fields.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// A depth camera's own depth in place of depth from several views.
struct SensorDepthConfig {
  double sigma_px = 0.1;      ///< of the sensor's disparity, from which a depth's sigma follows
  double max_sigma_m = 0.01;  ///< depths with a larger one are left out
};
Fields fields(SensorDepthConfig& config);
void validate(const SensorDepthConfig& config);

/// Whether some frame has depth.
bool has_sensor_depth(const Capture& capture);

/// The box of the world that is kept.
struct DepthVolume {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
};

/// Each frame's depth brought into the first sensor's pixels by the reported calibration, through
/// the lens of that frame's pose; what lies outside `volume` is left out. The sensor named "depth"
/// counts, else the first that has depth. Where the rig reports `ir_left` and `ir_right`, sigma is
/// that of a stereo camera, Z^2 sigma_px / (f B). Frames without a pose or without depth get an
/// empty image.
/// @throws std::invalid_argument if poses and frames do not match or the configuration is invalid.
Depths depths_of_sensor(const Capture& capture, const Poses& poses, const DepthVolume& volume,
                        const SensorDepthConfig& config = {});

/// Poses of a rig that knows where it is, of its first sensor; `no_board` for frames that do not
/// say.
Poses poses_of_rig(const Capture& capture);

}  // namespace cousin
