#pragma once

#include <vector>

#include "benchmarks/suites/sensors/depth_wall.h"

namespace cousin {

/// Fits the fast model's curves, waves, slopes and what its ratios are made of to what the full
/// model made of walls, each given by the light and the geometry of its sampled pixels: predicted
/// are means over them, fill of the normal distribution at the score, spreads of the pixels that
/// have a depth. Least squares [Levenberg & Marquardt] with curves kept smooth; the contrast's
/// parts are the best of a grid. Ripple and bias follow from the walls that face the camera.
/// @param walls   at least 8, with two frames each
/// @param config  of the camera; its own `model` does not count
/// @param model   whose curves, waves and slopes are replaced
/// @throws std::invalid_argument for fewer walls.
void fit_depth_curves(const std::vector<WallScores>& walls, const ActiveStereoConfig& config,
                      DepthModelConfig& model);

}  // namespace cousin
