#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/image_scores.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/score/visible_surface.h"
#include "perception/pipelines/seeds.h"
#include "sim/dataset/truth_io.h"

namespace cousin {

/// `row` with this metric.
ScoreRow measured_row(ScoreRow row, const std::string& metric, double value,
                      const std::string& unit, std::int64_t n);

/// The true views as cameras that look at surfaces: poses while the middle row is read.
std::vector<SurfaceView> surface_views(const SceneTruth& truth);

/// The estimate's poses in the order of the true views; those that are not there have none.
/// @throws std::invalid_argument if one is of a frame that the truth does not have, or occurs twice
Poses in_order_of(const std::vector<TrueView>& views, const Poses& poses);

/// views.posed, camera.focal_rms, .centre_rms, .centre_max and .rotation_rms, the last three not
/// solved where there is no alignment; nothing without poses.
/// @throws as in_order_of.
void add_pose_rows(const SceneTruth& truth, const Poses& poses, PoseAlignment alignment,
                   const ScoreRow& base, std::vector<ScoreRow>& rows);

/// Each row's n is how many points it is over: of the measured ones those that count, or the true
/// surface's samples. @param points  all that were measured
/// WHAT.points, .accuracy_rms, .accuracy_mean, .accuracy_median, .bias, .completeness_mean,
/// .chamfer, and .precision_, .recall_, .f1_ of each tolerance in micrometres.
void add_cloud_rows(const std::string& what, std::int64_t points, const CloudScore& score,
                    const ScoreRow& base, std::vector<ScoreRow>& rows);

}  // namespace cousin
