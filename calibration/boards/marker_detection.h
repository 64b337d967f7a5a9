#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calibration/boards/charuco_layout.h"
#include "calibration/boards/target_grid.h"
#include "sim/types/image.h"

namespace cousin {

/// A square marker with its code: corners from its upper left one on, clockwise as it stands
/// upright for cv::aruco.
struct SeenMarker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners_px;
};

/// Markers of a charuco board's dictionary or an april grid's tags, by cv::aruco, sorted by id; a
/// code seen twice is left out. Corners to a pixel or two. `corners_m` of each: marker_corners_m.
/// @param images  of one size, the same picture by several tones: linear ones, whose edges stay
/// between black and white where they are blurred, show small markers; lifted shadows dark ones. A
/// later one is looked at only if not all markers are found yet.
/// @throws std::invalid_argument if the dictionary does not exist.
std::vector<SeenMarker> find_markers(std::span<const Image<std::uint8_t>* const> images,
                                     const CalibrationTarget& target);

/// How many markers the board has.
int marker_count(const CalibrationTarget& target);
/// Where a marker's corners are on the print, in the order of SeenMarker.
std::array<Eigen::Vector2d, 4> marker_corners_m(const CalibrationTarget& target,
                                                CharucoLayout layout, int id);

/// How the markers lie to each other.
struct MarkerOrder {
  int agree = 0, differ = 0;  ///< pairs of neighbours that lie as on the print, and that do not
};
MarkerOrder marker_order(const CalibrationTarget& target, CharucoLayout layout,
                         const std::vector<SeenMarker>& markers);

/// The grid's points predicted from the markers about each: by the homography of the corners of
/// those next to it.
FoundPixels points_from_markers(const TargetGrid& grid, CharucoLayout layout,
                                const std::vector<SeenMarker>& markers);

}  // namespace cousin
