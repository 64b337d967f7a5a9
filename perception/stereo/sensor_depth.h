#pragma once

#include <limits>

#include "sim/config/fields.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// A depth camera's own depth in place of depth from several views.
struct SensorDepthConfig {
  double sigma_px = 0.1;  ///< of a stereo camera's disparity, from which a depth's sigma follows
  double max_sigma_m = 0.01;  ///< depths with a larger one are left out
  /// Width of the sensor's matching window: within half of it a step of depth is smeared.
  double window_px = 11;
  bool level_on_plate = true;  ///< whether a frame's depths are moved onto the plate, if it sees it
  int least_plate_px = 100;    ///< of the plate in a frame, to say how far its depths are off
};
Fields fields(SensorDepthConfig& config);
void validate(const SensorDepthConfig& config);

/// Whether some frame has depth.
bool has_sensor_depth(const Capture& capture);

/// The box of the world that is kept, and a flat plate in it.
struct DepthVolume {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
  double plate_m = 0;  ///< side of a square about the origin whose face is z = 0; 0 = none
};

/// How far a frame's depths of the plate's face are off, along the axis.
struct PlateResidual {
  int pixels = 0;       ///< that see it
  double offset_m = 0;  ///< median of depth - the face's, objects on it apart
  double sigma_m = std::numeric_limits<double>::quiet_NaN();  ///< robust spread about the median
};
/// @param depth_m  in the pixels of `pose`'s camera; NaN = none. Pixels within an eighth of the
/// plate's edge are left out, as are, twice, those beyond 3 sigmas: objects on it.
PlateResidual plate_residual(const Image<float>& depth_m, const FramePose& pose, double plate_m);

/// Each frame's depth brought into the first sensor's pixels by the reported calibration, through
/// the lens of that frame's pose; what lies outside `volume` by more than 3 sigmas is left out (a
/// closer cut would raise the mean of what is left). The sensor named "depth" counts, else the
/// first that has depth. Where the rig reports `ir_left` and `ir_right`, sigma is that of a stereo
/// camera, Z^2 sigma_px / (f B). A frame that sees the plate says itself how far its depths are
/// off, by calibration and matching: they are moved by that, and their sigma is at least their
/// spread about the plate, whatever the kind of sensor. Frames without a pose or without depth get
/// an empty image.
/// @throws std::invalid_argument if poses and frames do not match or the configuration is invalid.
Depths depths_of_sensor(const Capture& capture, const Poses& poses, const DepthVolume& volume,
                        const SensorDepthConfig& config = {});

/// Poses of a rig that knows where it is, of its first sensor; `no_board` for frames that do not
/// say.
Poses poses_of_rig(const Capture& capture);

}  // namespace cousin
