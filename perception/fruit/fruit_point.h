#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "sim/config/fields.h"
#include "sim/types/seams.h"

namespace cousin {

/// Where a fruit's surface is under the middle of its box, from depth aligned to the colour image.
struct FruitPointConfig {
  /// The paper's rule: side of the window where the pixel itself has no depth, and how far from
  /// its median depths may be [Strawberries 2.6; the distance is free].
  int paper_window_px = 5;
  double paper_outlier_m = 0.03;
  /// Ours: depths of a window about the middle, of this share of the box's shorter side.
  double window_share = 0.4;
  int least_window_px = 5;
  int least_depths = 8;
  double least_share = 0.5;  ///< of the window's pixels that have depth; less is no surface
  /// Ours: a leaf beside a fruit lends it its depth where the sensor's imagers see it before the
  /// fruit. If of the pixels with depth in a ring about the mask, but those of other boxes, more
  /// than this share is as deep as the patch, within so much, the depth may be theirs.
  int ring_px = 6;
  double beside_m = 0.01;
  double most_beside = 0.5;
  /// Depths within this many pixels of each other err alike: the sensor's matching window.
  double correlated_px = 9;
  /// Ours: sigma of what all depths of a unit are off by, over the sigma of one of them, and sigma
  /// of what the reported lens is off, in pixels. Fitted to units of the D457 that are drawn (seeds
  /// 101 to 103; scored on others).
  double unit_sigmas = 1;
  double lens_sigma_px = 0.3;
};
Fields fields(FruitPointConfig& config);
void validate(const FruitPointConfig& config);

/// A point of a surface in a camera's axes, or why there is none.
struct FruitPoint {
  std::string why_none;  ///< empty: it is found
  Eigen::Vector3d point_m = Eigen::Vector3d::Constant(kNaN);
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Constant(kNaN);  ///< NaN: not given
};

/// Depth at the middle pixel, or the mean of a window's where it has none, back-projected by a
/// pinhole: X = (u - cx) Z / fx [Strawberries, equation 4]. It says nothing of its error.
FruitPoint point_by_paper(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                          const FruitPointConfig& config = {});

/// A curved patch z = a + b x + c y + d (x^2 + y^2) through the depths of a window, those of the
/// box's mask where it has one, by least squares with Tukey's weights: what stands before or
/// behind the fruit has no part in it. The point is the patch's under the middle of the box, or
/// where the mask shows something else there, at its nearest pixel, on the lens's own ray.
/// @param depth  with sigmas or without; without, the spread about the patch stands alone
/// @param others  all boxes of this image; it may be among them
FruitPoint point_by_patch(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                          std::span<const DetectedBox> others = {},
                          const FruitPointConfig& config = {});

}  // namespace cousin
