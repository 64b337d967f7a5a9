#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/stage_files.h"
#include "perception/pipelines/pipeline_table.h"

namespace cousin {

/// Our stages for one scene, with a user's in place of some. @param capture  outlives them
Stages stages_of(const PipelineConfig& config, const Capture& capture, std::uint64_t seed,
                 const std::vector<StageSource>& sources, int scene_index,
                 const SplatWatch& watch = {}, const Warn& warn = {});

/// Those of `outside` for stages that the pipeline has not and nobody else gives.
Stages with_outside(Stages stages, const Stages& outside, const PipelineRow& row);

/// Seconds of a training in processes before this one, which its stage's own clock has not seen.
StageTiming seconds_before(const SplatTraining& training);
/// Adds them to a stage: "splats", which trains, or "poses", for which COLMAP ran.
void add_seconds_before(const std::string& stage, const StageTiming& before,
                        std::vector<StageTiming>& timings);

/// Runs stages and writes every seam into `estimate_dir` as soon as its stage is finished, as
/// `perceive` does. @param stages_of_run  told who watches a training @param sources  stages
/// among them that are read from files
Estimate perceive_with(const std::function<Stages(const SplatWatch&)>& stages_of_run,
                       const std::function<Estimate(const Stages&, const StageObserver&)>& run,
                       StageOrder order, const std::vector<StageSource>& sources, int scene_index,
                       const std::filesystem::path& estimate_dir, const Progress& progress);

/// Runs a pipeline on one capture with the given stages in place of ours, and writes every seam
/// into `estimate_dir` as soon as its stage is finished (nothing if the path is empty): what is
/// done survives a later failure, and a training of Gaussians that was stopped goes on
/// (`splats.unfinished` there, with COLMAP's folder `splats.unfinished.colmap`). Seams of
/// an earlier method are removed there first, but for stages that are read from folders. `warn`
/// hears of settings that the method does not use and of rows of files that are left out.
/// @param outside  stages for those that the pipeline has not (PipelineRow::from_outside)
Estimate perceive(const Capture& capture, const PipelineConfig& config, std::uint64_t seed,
                  const std::vector<StageSource>& sources, int scene_index,
                  const std::filesystem::path& estimate_dir, const Progress& progress = {},
                  const Warn& warn = {}, const Stages& outside = {});

}  // namespace cousin
