#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "sim/imaging/rectification.h"
#include "sim/types/capture.h"

namespace cousin {

/// Whether a capture is of a stereo pair: its first two sensors are cameras that lie side by side.
/// @throws std::invalid_argument saying what it has instead: one sensor, a depth sensor, cameras at
/// one place, the second at the left of the first or before or behind it
void check_stereo_rig(const Capture& capture);

/// One frame of two grey images that are rectified already, as a rig of parallel pinhole cameras
/// hands it over: depth = focal_px * baseline_m / disparity.
Capture capture_of_pair(Image<std::uint8_t> left, Image<std::uint8_t> right, double focal_px,
                        double baseline_m);

/// Why a frame's two images are no pair; empty if they are: one is missing, their sizes differ from
/// each other or from their calibration's, or they were exposed too far apart.
std::string why_no_stereo_pair(const Capture& capture, const Frame& frame, double most_apart_s);

/// Brightness of the two images as two parallel pinhole cameras would show it, by the reported
/// calibration.
struct RectifiedPair {
  Rectification geometry;
  Image<float> left_source, right_source;  ///< brightness codes 0..255 as they were taken
  Remapped left, right;                    ///< rectified
};
/// @throws as check_stereo_rig and rectify
RectifiedPair rectified_pair(const Capture& capture, const Frame& frame);

/// The right image through another map.
void use_right_map(RectifiedPair& pair, Image<Eigen::Vector2f> right_px);

}  // namespace cousin
