#pragma once

#include <Eigen/Core>

#include "sim/imaging/stereo_matching.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

/// The rectified pair that is wanted. Zeros: as the left lens has it.
struct RectificationConfig {
  int width_px = 0, height_px = 0;
  double focal_px = 0;
};

/// Two calibrated cameras turned into two pinhole cameras of one orientation, their x axis along
/// the baseline and their z axis as near as it gets to the mean of the given ones [Fusiello, Trucco
/// & Verri, MVA 2000]: the same point then lies in the same row. Lenses, vergence and unequal
/// principal points are taken out together. Maps hold, for each rectified pixel, the pixel of the
/// given image; NaN where its lens has none.
struct Rectification {
  Camera camera;                        ///< of both rectified images
  Eigen::Matrix3d rectified_from_left;  ///< rotations about the camera centres
  Eigen::Matrix3d rectified_from_right;
  double baseline_m = 0;
  Image<Eigen::Vector2f> left_px, right_px;
};
/// @throws std::invalid_argument for an invalid camera or configuration, a baseline below 1 um, or
/// a right camera that lies before or behind the left one rather than beside it (more than 45
/// degrees off), or to its left.
Rectification rectify(const Camera& left, const Camera& right, const Pose& right_from_left,
                      const RectificationConfig& config = {});

/// The image through a map, bilinear; where the map leaves the image: 0 and not valid.
struct Remapped {
  Image<float> image;
  Image<std::uint8_t> valid;  ///< 255 or 0
};
Remapped remap(const Image<float>& image, const Image<Eigen::Vector2f>& map_px);

/// Passive stereo: rectified, matched, and depth along the rectified left camera's axis. NaN where
/// there is no match or one of the images does not reach.
struct PassiveDepth {
  Image<float> depth_m;
  StereoMatches matches;
};
PassiveDepth passive_depth(const Image<Rgb8>& left, const Image<Rgb8>& right,
                           const Rectification& rectification, const StereoMatchConfig& config);

}  // namespace cousin
