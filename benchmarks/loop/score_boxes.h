#pragma once

#include "benchmarks/loop/score_seeds.h"

namespace cousin {

/// Scores traits that are of one box each (TraitsOf::boxes), such as the place of a fruit's surface
/// in the camera. In each image of each sensor a measured box stands for the true one that it
/// overlaps most, by at least half (intersection over union), each once.
/// - boxes.found, boxes.missed, boxes.spurious: of the boxes that are there;
/// - point.error_3d: mean distance of a measured point from the true one, and by true distance in
///   steps of 0.1 m from 0.3 to 0.6 m [Strawberries, Table 5], cases "0.3 to 0.4 m", with the RMSE
///   and the mean absolute error of each trait;
/// - one specimen row for each true box and trait, not_solved where it was not measured.
/// Cases of another sensor than the first begin with its name, "right, 0.3 to 0.4 m", and it has no
/// specimen rows; one that no box of the estimate is of is left out.
/// `estimate.boxes` hold the boxes that traits are of.
/// @throws std::invalid_argument without true depth and instances of every view
SeedsScores score_boxes(const SceneTruth& truth, const Estimate& estimate,
                        const SeedsScoreLabels& labels);

/// Scores an estimate as its traits ask for: score_run, score_boxes or score_plants.
SeedsScores score_estimate(TraitsOf traits_of, const SceneTruth& truth, const Estimate& estimate,
                           const SeedsScoreLabels& labels);

}  // namespace cousin
