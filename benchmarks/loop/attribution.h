#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/simulate.h"

namespace cousin {

/// One bar of the waterfall: the trait errors that are left when truth stands in every seam up to
/// `stage`, in the order of the flow; "none" is the pipeline as it is. What a stage adds to the
/// error is the step between its bar and the one before.
struct SeamStep {
  std::string stage;
  SeedsScores scores;
  double wall_s = 0;  ///< of the stages that ran
};

/// Runs the pipeline once as it is and once more for each seam with truth up to there.
/// `run.truth.images` must hold truth_stage_needs().
/// @param own       the stages that are explained, ours or a user's (see stages_of)
/// @param estimate  the pipeline's own result on run.capture if it is known already; its stages are
/// not run again
std::vector<SeamStep> attribute(const SimulatedRun& run, const PipelineConfig& config,
                                const Stages& own, const SeedsScoreLabels& labels,
                                const Estimate* estimate = nullptr, const Progress& progress = {});

/// Rows "length.rmse", "length.bias", ... of these traits and "camera.centre_rms" with case "truth
/// up to STAGE" for each step.
std::vector<ScoreRow> attribution_rows(const std::vector<SeamStep>& steps,
                                       std::span<const std::string_view> traits,
                                       const SeedsScoreLabels& labels);

}  // namespace cousin
