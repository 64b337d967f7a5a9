#pragma once

#include <vector>

#include "calibration/boards/grid_growth.h"
#include "calibration/boards/target_detection.h"
#include "calibration/boards/target_grid.h"
#include "calibration/boards/target_view.h"
#include "sim/types/image.h"

namespace cousin {

/// Whether the square between a corner's directions along x and y is black, as designed.
bool is_dark_ahead(const TargetGrid& grid, int index);

/// Moves each found corner onto the nearest saddle of its kind within a third of a step, drops
/// those without one, and adds what the neighbours predict, outward, until nothing is added.
/// @param inverted  the squares' colours are swapped
void follow_saddles(const TargetGrid& grid, const std::vector<Saddle>& saddles, bool inverted,
                    FoundPixels& found);

/// Corners fitted in their windows, twice: the second time with the blur that the first one found.
std::vector<TargetObservation> measure_corners(const Image<float>& light, const TargetGrid& grid,
                                               const FoundPixels& found, bool inverted,
                                               const TargetDetectionConfig& config);

/// Discs fitted, their centres where the homography of all says.
std::vector<TargetObservation> measure_discs(const Image<float>& light, const TargetGrid& grid,
                                             const FoundPixels& found, double radius_px,
                                             const TargetDetectionConfig& config);

}  // namespace cousin
