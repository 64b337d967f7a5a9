#pragma once

#include <vector>

#include "benchmarks/score/image_scores.h"
#include "benchmarks/score/scores.h"
#include "perception/pipelines/seeds.h"
#include "sim/dataset/truth_io.h"

namespace cousin {

/// Scores a scene as a whole, of which no specimens were told apart: poses, and cloud and meshes
/// against every surface of the scene that two true views at least could see.
/// - views.posed, camera.*: as of seeds; alignment.scale with PoseAlignment::similarity: true
///   lengths over the estimate's, not_solved as all rows of clouds and meshes where three posed
///   views that are not on a line are missing;
/// - surface.seen: share of all surface that could be seen;
/// - cloud_seen.*, mesh_seen.*: accuracy, bias, completeness, Chamfer distance, and precision,
///   recall and F1 at 0.2, 1 and 5 mm [Knapitsch et al., 2017]. Measured points that are nearer to
///   a surface that could not be seen do not count. `points` is the n that were measured;
/// - specimens.*: the same of specimens and their organs alone: measured points, and triangles by
///   their middles, that are nearer to them than to anything else, and in the box of one, grown on
///   every side by half its diagonal.
/// Things that move are taken where they are at time 0. On a plain board an estimate with poses is
/// turned first, see board_turn.h.
/// @param alignment  `similarity`: the estimate's frame and unit are its own
/// @param has_cloud  it says of its cloud what it is, were it empty; of meshes `surfaces` says so
/// @throws std::invalid_argument if a pose is of no true frame, or a point is not finite.
std::vector<ScoreRow> score_views(const SceneTruth& truth, const Estimate& estimate,
                                  PoseAlignment alignment, bool has_cloud, const ScoreRow& base);

}  // namespace cousin
