#include "benchmarks/seeds/perceive.h"

#include <algorithm>

#include "benchmarks/seeds/truth_stages.h"
#include "sim/dataset/seam_io.h"

namespace cousin {

SeedsStages stages_of(const SeedsPipelineConfig& config, std::uint64_t seed,
                      const std::vector<StageSource>& sources, int scene_index,
                      const SplatWatch& watch) {
  const std::uint64_t own_seed = Rng(seed).fork(static_cast<std::uint64_t>(scene_index))();
  return with_stage_sources(seeds_stages(config, own_seed, watch), sources, scene_index);
}

SeedsEstimate perceive_seeds(const Capture& capture, const SeedsPipelineConfig& config,
                             std::uint64_t seed, const std::vector<StageSource>& sources,
                             int scene_index, const std::filesystem::path& estimate_dir,
                             const Progress& progress) {
  const StepProgress steps = [&](int done, int all) {
    if (progress) progress("perceive: splats, step", done, all);
  };
  const SeedsStages stages = stages_of(config, seed, sources, scene_index, {steps, {}});
  const auto& names = seeds_stage_names();
  const auto observe = [&](const std::string& stage, bool finished, const SeedsEstimate& so_far) {
    const auto place = std::find(names.begin(), names.end(), stage) - names.begin();
    if (!finished) {
      if (progress)
        progress("perceive: " + stage, static_cast<int>(place), static_cast<int>(names.size()));
    } else if (!estimate_dir.empty()) {
      write_seam(estimate_dir, stage, so_far, scene_index);
    }
  };
  if (!estimate_dir.empty()) {
    for (const std::string& stage : names) {
      const bool is_read =
          std::any_of(sources.begin(), sources.end(), [&](const StageSource& source) {
            return source.stage == stage && source.kind == StageSource::Kind::directory;
          });
      if (!is_read) remove_seam(estimate_dir, stage);  // else it may be read from here
    }
    std::filesystem::remove(estimate_dir / "timings.json");
  }
  SeedsEstimate estimate = run_seeds(capture, config, stages, observe);
  if (!estimate_dir.empty()) write_timings(estimate_dir, estimate.timings);
  return estimate;
}

}  // namespace cousin
