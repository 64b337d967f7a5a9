#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "perception/pipelines/seeds.h"
#include "scenes/seeds/seeds_scene.h"

namespace cousin {

/// run_config of seeds by their own pipeline.
RunConfig seeds_run_config(const std::vector<std::string>& assignments,
                           const std::filesystem::path& file = {});

/// The scene of a run of seeds. @throws std::logic_error of another run
SeedsSceneConfig& seeds_scene(RunConfig& config);
const SeedsSceneConfig& seeds_scene(const RunConfig& config);
/// The pipeline of a run of seeds. @throws std::logic_error if the run has another or none
SeedsPipelineConfig& seeds_pipeline(RunConfig& config);
const SeedsPipelineConfig& seeds_pipeline(const RunConfig& config);

}  // namespace cousin
