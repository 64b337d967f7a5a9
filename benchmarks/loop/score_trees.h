#pragma once

#include "benchmarks/loop/score_seeds.h"

namespace cousin {

/// Scores the fruits of a tree over all views, and the tree's own traits (TraitsOf::trees). What
/// counts hangs in the tree's place of the row, as the scene's "tree" says it (place_along,
/// place_across): fruits of neighbours that reach into it too. A measured fruit stands for the true
/// one whose middle is nearest, within 0.04 m, each once, also for one that hangs beside the place.
/// - fruits.found, .missed: of those that hang there; fruits.beside: measured ones of the others;
/// - fruits.doubled: within 0.08 m of a fruit that another stands for; fruits.spurious: the rest;
/// - one specimen row for each true fruit and trait, and one of the tree ("tree") for fruit_count
///   and yield; not_solved where it was not measured.
/// @throws std::invalid_argument if the scene has no tree that says its place
SeedsScores score_trees(const SceneTruth& truth, const Estimate& estimate,
                        const SeedsScoreLabels& labels);

/// True tracks for an estimate's boxes: those of one specimen together, each with its true middle.
/// Boxes that are of no specimen are of no track.
Tracks true_tracks(const SceneTruth& truth, const Boxes& boxes);

}  // namespace cousin
