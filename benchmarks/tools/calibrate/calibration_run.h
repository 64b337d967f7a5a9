#pragma once

#include <optional>
#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/tools/calibrate/calibration_photos.h"
#include "calibration/boards/target_detection.h"
#include "calibration/devices/depth_check.h"
#include "calibration/devices/registration.h"
#include "calibration/devices/rolling_shutter.h"
#include "calibration/solve/calibrate.h"
#include "calibration/solve/calibration_uncertainty.h"
#include "calibration/solve/next_view.h"

namespace cousin {

struct CalibrateConfig {
  LensModel model = LensModel::opencv5;
  /// As a person calibrates: residuals over what detection predicts for them. What a lens does far
  /// beyond the points is judged by the median over the image instead of the RMS.
  CalibrationConfig calibration{.weigh_by_covariance = true, .max_deviation_share = 1e6};
  TargetDetectionConfig detection;
  bool rolling_shutter =
      false;                 ///< one camera: rows are read one after the other, time stamps count
  double frame_rate_hz = 0;  ///< of a folder that is a video, picture by picture; 0: it is none
  RollingShutterConfig rolling;
  RegistrationConfig registration;      ///< of a depth camera's dataset, which reports its own
  DepthCheckConfig depth;               ///< of its depth on the boards
  double most_rms_px = 0.5;             ///< RMS a coordinate above which the lens does not fit ...
  double most_rms_sigmas = 8;           ///< ... if it is as many times what detection predicts, too
  double most_deviation_share = 0.01;   ///< of the width: median of the projection's deviation
  double warn_deviation_share = 0.002;  ///< the same, for a warning
  double least_tilt_spread_rad = 0.17;  ///< between boards: below, they count as parallel
};
Fields fields(CalibrateConfig& config);
void validate(const CalibrateConfig& config);

/// What one of a run's cameras is worth.
struct CameraVerdict {
  double rms_px = 0;           ///< a coordinate, of this camera's residuals
  double predicted_px = 0;     ///< RMS of the deviations that detection predicted for its points
  double coverage = 0;         ///< share of a 10 x 8 grid over its images that points fall into
  double tilt_spread_rad = 0;  ///< largest angle between two boards' normals
  UncertaintyMap uncertainty;  ///< empty without covariance
  double deviation_px = 0;     ///< median of its worst deviations; NaN without
  double valid_share = 0;      ///< of the image, K in ValidRegion
  std::optional<NextView> next;
};

/// A folder or dataset calibrated.
struct CalibrationRun {
  CalibrationPhotos photos;
  CalibrateConfig config;
  CalibrationInput input;  ///< one view for each photo, same order
  CalibrationResult result;
  std::vector<CameraVerdict> verdicts;  ///< one for each camera, empty unless there is a result
  std::optional<CrossValidation> cross;
  std::optional<RollingShutterResult> rolling;  ///< with rolling_shutter; `result` is its lens
  /// Where a dataset has a colour camera and a depth camera's left imager: what the device reports
  /// against `result`.
  std::optional<RegistrationDifference> registration;
  std::optional<DepthCheck> depth;     ///< where a dataset has depth in one of the cameras' pixels
  std::vector<DepthView> depth_views;  ///< what it is of
  std::vector<std::string> problems;   ///< why nothing should be used; empty = use it
  std::vector<std::string> warnings;
  Image<Rgb8> sample;  ///< camera 0's first photo in which the board was found
  double detect_s = 0;
};

/// Finds the target in every photo, in parallel, numbers half-turned boards alike over the cameras,
/// solves and judges.
/// @throws std::runtime_error naming the file for one that cannot be read or has another size than
/// the first of its camera, if no photo shows the target, and if most of those that show one show a
/// target of another size.
CalibrationRun run_calibration(CalibrationPhotos photos, const CalibrateConfig& config,
                               const Progress& progress);

/// For each view of camera 1 whose half turn is not known, whether it must be turned for the
/// cameras' places to each other to agree with the other frames'; poses from each camera's own
/// calibration. Turns them. Does nothing for one camera.
void agree_on_half_turns(CalibrationInput& input, const CalibrationConfig& config);

}  // namespace cousin
