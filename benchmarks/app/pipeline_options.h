#pragma once

#include <memory>
#include <string>
#include <vector>

#include "benchmarks/app/options.h"
#include "benchmarks/loop/stage_files.h"
#include "benchmarks/score/learned/learned_distance.h"
#include "perception/pipelines/pipeline_table.h"

namespace cousin {

/// `start` with --config, then --method, then --set, whose keys may have "pipeline." before them.
/// @throws std::invalid_argument naming what is wrong
PipelineConfig configured_pipeline(const Options& options, const PipelineConfig& start);

/// --stage of the command line, each of which the pipeline has.
/// @throws std::invalid_argument naming one that it has not: it would be read and never used
std::vector<StageSource> stage_sources(const Options& options, const PipelineRow& row);

/// Refuses options that this pipeline does not read, naming those that do.
/// @throws std::invalid_argument
void refuse_foreign_options(const Options& options, const PipelineRow& row);

/// Refuses those of pipelines that score a scene as a whole. @throws std::invalid_argument
void refuse_whole_scene_options(const Options& options);

/// The network of --lpips; null where it is not given.
std::shared_ptr<const LearnedDistance> learned_of(const Options& options);

}  // namespace cousin
