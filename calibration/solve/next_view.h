#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"

namespace cousin {

/// A way to hold the target that has not been photographed yet, and what it would give.
struct NextView {
  Pose camera_from_target;
  std::string words;   ///< for a person: place in the picture, size, tilt
  double now_px = 0;   ///< RMS deviation of the projection over the image, as it is
  double then_px = 0;  ///< with this view added
};

/// The view, of those tried, that lowers the mean variance of the camera's projection most: places
/// in the picture, sizes, tilts up to 50 degrees. First order: the view's normal equations, its
/// pose eliminated and its corners as good as the residuals' RMS, are added to the inverse of the
/// result's covariance; the variance is over a
/// grid of pixels, a rotation of the camera (which best fits) left out. Of a splined lens the
/// covariance holds its regularising prior, without which what no corner saw would be infinitely
/// unsure: now_px is then large, and the view goes where nothing was seen. Nothing for a result
/// without covariance or a target that no candidate shows.
/// @param target_m  by id, flat in z = 0, about the origin
/// @param reach_px  pixels farther from the principal point are none of the image's: a fisheye's
/// dark corners
std::optional<NextView> best_next_view(const CalibrationResult& result, int camera,
                                       const std::vector<Eigen::Vector3d>& target_m,
                                       double reach_px = std::numeric_limits<double>::infinity());

}  // namespace cousin
