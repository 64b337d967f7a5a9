#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/score/learned/learned_distance.h"
#include "benchmarks/score/scores.h"
#include "perception/pipelines/views.h"

namespace cousin {

/// What the pipeline `scene` made of a capture, and how its images look beside the photographs.
struct ViewsRun {
  Estimate estimate;  ///< poses, splats, depths, cloud and one surface at most
  /// No truth is needed for them: train.psnr, .psnr_exposed (after the one factor on light that
  /// fits each photograph best), .ssim, .flip and the same of held_out, n = views;
  /// gaussians; gaussians.seen_by_3, the share that at least three of all placed views see;
  /// cloud.points; mesh.area; seconds of stages.
  std::vector<ScoreRow> rows;
};

/// Runs the pipeline on one capture with the given stages in place of ours. Writes every seam into
/// `estimate_dir` as soon as its stage is finished, then scores.csv, splats_seen.csv (views that
/// see each Gaussian, in the order of splats.ply), exposures.csv where exposures were measured, and
/// pictures/ of at most four views: photograph and model with its exposure, those held out where
/// there are any. @param name  of the scene in the rows
/// @param learned  network that whole images are scored by too, rows "train." and "held_out.lpips"
ViewsRun perceive_views(const Capture& capture, const ViewsPipelineConfig& config,
                        std::uint64_t seed, const std::vector<StageSource>& sources,
                        int scene_index, const std::string& name,
                        const std::filesystem::path& estimate_dir, const Progress& progress = {},
                        const Warn& warn = {}, const LearnedDistance* learned = nullptr);

}  // namespace cousin
