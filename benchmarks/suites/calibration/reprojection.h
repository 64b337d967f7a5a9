#pragma once

#include "calibration/solve/calibrate.h"

namespace cousin {

/// One calibration's residuals in the definitions that programs print; rejected observations left
/// out, NaN where nothing is left. For normal noise of deviation sigma a coordinate and many
/// points: sigma, 1.414 sigma, 1.253 sigma, and 1.414 sigma over the root of a view's points.
struct ReprojectionErrors {
  double rms_coordinate_px = 0;
  double rms_point_px = 0;      ///< what cv::calibrateCamera returns
  double mean_distance_px = 0;  ///< MATLAB's cameraParameters.MeanReprojectionError
  /// What OpenCV's tutorial prints: of each view the root of the sum of squares over the number of
  /// points, averaged over the views. It shrinks with the points a view has.
  double tutorial_px = 0;
};
ReprojectionErrors reprojection_errors(const CalibrationResult& result);

}  // namespace cousin
