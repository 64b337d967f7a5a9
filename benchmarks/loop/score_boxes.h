#pragma once

#include <span>
#include <string>
#include <string_view>

#include "benchmarks/loop/score_seeds.h"

namespace cousin {

struct TrueBox;

using TraitNames = std::span<const std::string_view>;
/// Whether traits are the place of a surface's point, and so of a box rather than of its specimen.
bool are_of_points(TraitNames traits);
/// Whether all of them are.
bool are_all_of_points(TraitNames traits);

/// Hidden shares in percent that divide the cases: below `half`, `half` to `most`, above.
struct HiddenEdges {
  int half = 40, most = 70;
};
/// Those of pickers' targets: 70 % and 50 % of the fruit in sight.
inline constexpr HiddenEdges kPickersEdges{30, 50};

/// What of a box makes its specimen hard to measure: "cut by the image", "nearer than 0.3 m",
/// "farther than 1 m" [0.1 to 1 m, Apples 2.1.1; a D455 sees nothing nearer than 0.29 m], else
/// "unoccluded" (below 5 % hidden), "hidden below 40 %", "hidden 40 to 70 %", "hidden above 70 %".
/// "" where the truth does not say how much is hidden.
/// @param hidden  other edges than 40 and 70 %
std::string box_case(const TrueBox& box, int instance, const TruthImages& images,
                     HiddenEdges hidden = {});

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
/// Other traits than point_x, point_y, point_z and distance are those of the box's specimen, or its
/// places in that camera (is_of_place). Their rows are by how much of it is hidden (box_case, with
/// kPickersEdges where places are among them), statistics of the trait and of its sigmas and of
/// places (add_place_rows), and so are the cultivars of their specimen rows: "fuji, unoccluded".
/// A trait that no box of the estimate has is left out, if any has another of them.
/// `estimate.boxes` hold the boxes that traits are of.
/// @param traits  that are scored; empty: those that the estimate has, or of none the point's
/// @throws std::invalid_argument without true depth and instances of every view, or if a specimen
/// has no such trait
SeedsScores score_boxes(const SceneTruth& truth, const Estimate& estimate,
                        const SeedsScoreLabels& labels, TraitNames traits = {});

/// What the traits of an estimate are of, as their names say; where nothing was measured, as its
/// seams say. For estimates from files, whose pipeline nobody names.
TraitsOf traits_of_estimate(const Estimate& estimate);

/// Scores an estimate as its traits ask for: score_run, score_plants, score_trees, or score_boxes
/// of these traits.
SeedsScores score_estimate(TraitsOf traits_of, const SceneTruth& truth, const Estimate& estimate,
                           const SeedsScoreLabels& labels, TraitNames traits = {});

}  // namespace cousin
