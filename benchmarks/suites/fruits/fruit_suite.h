#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/grid.h"

namespace cousin {

/// A suite whose jobs are captures of one scene of fruits, each measured by all methods of the
/// scene's pipeline from true boxes. Every box of a view counts.
struct FruitSuite {
  std::string_view name;
  const SceneRow& (*scene)() = nullptr;
  PipelineConfig (*pipeline)() = nullptr;
  std::uint64_t seed = 1;
  std::vector<std::string> sets;  ///< the user's, after the job's own
  /// The scene in rows of a job: one for the jobs that are pooled together. The usual jobs are of
  /// `plain`; names of other cases begin with their scene, "family, unoccluded".
  std::string_view plain;
  std::string (*scene_of)(const GridJob& job) = nullptr;
  std::vector<std::string_view> traits;  ///< whose relative errors and intervals have rows
  std::string_view known_density = {};   ///< trait whose error a mass of known density has
  int fruits_timed = 10;                 ///< of the row of seconds
  double limit_s = 0;                    ///< of it, for ours
  /// What the project aims at in a pooled row; none: it is told only.
  std::optional<ScoreLimit> (*limit)(const ScoreRow& row) = nullptr;
};

/// One job: scores of each method. Of rows it keeps seconds and counts of boxes, of which the
/// pooled ones are made; specimens are one row a box and trait.
ScoreFile run_fruit_job(const FruitSuite& suite, const GridJob& job);

/// Of each method and case (box_case; after "SCENE, " of other jobs than the usual), over all runs:
/// - TRAIT.measured, the share of boxes; .mape, .rmse, .bias; .coverage_95 of its intervals,
///   .width_over_rmse, their mean width, and .rmse_by_width, the RMSE of relative errors in the
///   third of widest intervals over that in the third of narrowest;
/// - places and directions (add_place_rows), and point.rmse_x, .rmse_y, .rmse_z, .rmse_3d, and
///   .coverage_95 over the three;
/// - case "all": whole in the image, in the sensor's range; "all, surest 50 %": the half of all
///   these boxes whose intervals are the narrowest, as a robot has them that leaves the others out;
///   no such case where fewer than half are measured;
/// - seconds.N_fruits: of an image with so many that are measured;
/// - ratios of ours to the other methods on the same boxes with paired tests.
/// Boxes of one run are drawn together: they show the same plants.
std::vector<ScoreRow> fruit_pooled_rows(const FruitSuite& suite, const ScoreFile& jobs);

/// Error against the share of all boxes that are reported, the surest first, of pooled rows.
/// @param trait  whose rows say how many boxes there are: "volume"
/// @param metric  that is drawn: "cut.error_3d"
LinePlot abstention_plot(const std::vector<ScoreRow>& rows, const std::string& method,
                         const std::string& trait, const std::string& metric,
                         const std::string& label, double factor);

/// What each camera comes to on the same plants: a line for each scene "CAMERA" of pooled rows of
/// `method` whose case is "CAMERA, all".
struct CameraColumn {
  std::string title;   ///< with its unit
  std::string metric;  ///< of pooled rows
  double factor = 1;
  int decimals = 1;
};
ReportTable camera_table(const std::vector<ScoreRow>& rows, const std::string& method,
                         const std::vector<std::string>& cameras,
                         const std::vector<CameraColumn>& columns);

}  // namespace cousin
