#pragma once

#include <vector>

#include "benchmarks/loop/score_seeds.h"

namespace cousin {

/// Scores depth images of the first camera against the first surfaces there:
/// - depth.frames: share of frames that have depth; depth.measured: of pixels that show a surface;
/// - depth.error, depth.error_relative: medians of the absolute error, the latter over the depth;
///   depth.bias: median error;
/// - depth.bad_05_px, .bad_1_px, .bad_2_px: shares of the measured pixels whose disparity to the
///   next camera of the rig would be off by more; depth.offset_px, the median of these errors,
///   which a unit's calibration makes, and depth.spread_px, their robust deviation about it;
///   nothing where there is no other camera;
/// - depth.coverage_95: of intervals of 1.96 sigma; depth.normalised: median of |error| over sigma,
///   0.67 of normal errors.
/// Cases: "all", and by true distance "0.5 to 1 m" and so on, in octaves.
/// @throws std::invalid_argument without true depth, for an image of another size than its view's,
/// one of a frame that the truth has not, or a depth that is zero, negative or infinite
std::vector<ScoreRow> score_depths(const SceneTruth& truth, const Estimate& estimate,
                                   const SeedsScoreLabels& labels);

}  // namespace cousin
