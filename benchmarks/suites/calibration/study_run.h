#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/suites/calibration/study_points.h"

namespace cousin {

/// What is measured of each calibration, and averaged over the runs of a point.
struct StudyMetric {
  const char* name;
  const char* unit;
  const char* shown;  ///< on a plot, with its unit; empty = not drawn
  double scale;       ///< from `unit` to what is shown
};
std::span<const StudyMetric> study_metrics();

/// Photographs a group's board once, finds it in each sensor's photographs and calibrates for each
/// of its points in each of its ways: a row a point, method and metric, whose case is the point's
/// name and " run N". wall_s = seconds of finding the board and solving. The camera, the board and
/// the way of going about are those of the run, the same for all groups.
std::vector<ScoreRow> run_group(const StudyGroup& group, int run, std::uint64_t seed);

}  // namespace cousin
