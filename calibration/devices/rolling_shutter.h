#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "calibration/solve/calibrate.h"
#include "sim/config/fields.h"

namespace cousin {

/// Calibration of a camera that reads its rows one after the other while it moves. Row v of a view
/// shows a point X of the target at
///   exp(s omega) R X' + t + s w,   s = (v - (rows - 1) / 2) line_delay,
/// with X' from the target's middle, (R, t) the pose at the middle row, omega its turning rate and
/// w the speed of the target's middle, both in the camera's axes and held over the readout.
///
/// A single picture only tells the product of line delay and velocity. What parts the two is a
/// video: between two views whose time stamps are at most `max_gap_s` apart, poses and velocities
/// are tied as by a velocity that wanders with an acceleration of the given deviation a step, which
/// makes of the poses a cubic spline in time (its slope at a frame is right to the fourth order of
/// the step). Views with no such neighbour have a velocity of their own, weakly held about zero;
/// the line delay is never taken from that. Lengths are in metres here. How a velocity changes
/// within a readout is not modelled: at 2 m/s^2 and 20 ms, a tenth of a pixel at 0.4 m.
struct RollingShutterConfig {
  double readout_s = 0;        ///< known time from first to last row; 0: it is solved for
  double speed_m_per_s = 0.5;  ///< deviation of each coordinate of w, of a view by itself ...
  double rate_rad_per_s = 1;   ///< ... and of omega, if the readout takes `usual_readout_s`
  double usual_readout_s = 0.015;
  double acceleration_m_per_s2 = 2;          ///< deviation, a step between neighbours
  double turn_acceleration_rad_per_s2 = 10;  ///< the same of omega
  double max_gap_s = 0.1;                    ///< between time stamps of neighbours
  double max_readout_deviation_s = 0.002;    ///< above it the line delay is not determined
};
Fields fields(RollingShutterConfig& config);
void validate(const RollingShutterConfig& config);

/// Of one view that was used.
struct RollingView {
  int view = 0;                 ///< index into the input's views
  bool has_neighbours = false;  ///< in time
  /// omega (rad) and w (length) times the readout: determined whether or not the line delay is.
  Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
};

struct RollingShutterResult {
  /// Its parameters end with "camera0.line_delay_s" where that is solved for; poses are those of
  /// the middle row. `not_determined` without time stamps of neighbours, or without motion between
  /// them: then "camera0.line_delay_s" is named, and lens and motions hold all the same.
  CalibrationResult calibration;
  double line_delay_s = std::numeric_limits<double>::quiet_NaN();  ///< a row; NaN: not determined
  std::vector<RollingView> views;
  int neighbours = 0;  ///< pairs of views that time stamps tie
};

/// From `calibrate`'s answer on: Levenberg-Marquardt over lens, poses, velocities and line delay,
/// the deviation of the corners estimated with them. Any solver gives the start. Deterministic.
/// `bad_input` for several cameras, two views of one frame, a robust loss, a board deformation, or
/// two views at one time.
/// @param calibration  of the lens and of the start
/// @throws std::invalid_argument for an invalid config
[[nodiscard]] RollingShutterResult calibrate_rolling_shutter(
    const CalibrationInput& input, const CalibrationConfig& calibration = {},
    const RollingShutterConfig& config = {});

}  // namespace cousin
