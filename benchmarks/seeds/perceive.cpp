#include "benchmarks/seeds/perceive.h"

#include <algorithm>

#include "benchmarks/seeds/truth_stages.h"
#include "sim/dataset/seam_io.h"
#include "sim/types/whole_file.h"

namespace cousin {

SeedsStages stages_of(const SeedsPipelineConfig& config, std::uint64_t seed,
                      const std::vector<StageSource>& sources, int scene_index,
                      const SplatWatch& watch, const Warn& warn) {
  const std::uint64_t own_seed = Rng(seed).fork(static_cast<std::uint64_t>(scene_index))();
  return with_stage_sources(seeds_stages(config, own_seed, watch), sources, scene_index, warn);
}

StageTiming seconds_before(const SplatTraining& training) {
  StageTiming before;
  if (training.curve.empty()) return before;
  before.wall_s = std::max(0.0, training.curve.back().wall_s - training.seconds.total);
  before.cpu_s = std::max(0.0, training.curve.back().cpu_s - training.seconds.total_cpu);
  return before;
}

void add_seconds_before(const std::string& stage, const StageTiming& before,
                        std::vector<StageTiming>& timings) {
  for (StageTiming& timing : timings) {
    if (timing.stage != stage) continue;
    timing.wall_s += before.wall_s;
    timing.cpu_s += before.cpu_s;
  }
}

SeedsEstimate perceive_with(
    const std::function<SeedsStages(const SplatWatch&)>& stages_of_run,
    const std::function<SeedsEstimate(const SeedsStages&, const StageObserver&)>& run,
    const std::vector<StageSource>& sources, int scene_index,
    const std::filesystem::path& estimate_dir, const Progress& progress) {
  const StepProgress steps = [&](int done, int all) {
    if (progress) progress("perceive: splats, step", done, all);
  };
  SplatWatch watch;
  watch.progress = steps;
  StageTiming before, posed_before;
  watch.end = [&](const SplatTraining& training) { before = seconds_before(training); };
  watch.posed = [&](const SfmEstimate& sfm) { posed_before = sfm.done_before; };
  const std::filesystem::path unfinished = estimate_dir / "splats.unfinished";
  const std::filesystem::path unfinished_sfm = estimate_dir / "splats.unfinished.colmap";
  if (!estimate_dir.empty()) {
    watch.checkpoint = {unfinished, 500, true};
    watch.sfm_folder = unfinished_sfm;
  }
  const SeedsStages stages = stages_of_run(watch);
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
    remove_own(estimate_dir / "timings.json");
  }
  SeedsEstimate estimate = run(stages, observe);
  add_seconds_before("splats", before, estimate.timings);
  add_seconds_before("poses", posed_before, estimate.timings);
  if (estimate_dir.empty()) return estimate;
  write_timings(estimate_dir, estimate.timings);
  // Only now: the next run begins with the first seam.
  remove_own(unfinished);
  remove_own_folder(unfinished_sfm);
  return estimate;
}

SeedsEstimate perceive_seeds(const Capture& capture, const SeedsPipelineConfig& config,
                             std::uint64_t seed, const std::vector<StageSource>& sources,
                             int scene_index, const std::filesystem::path& estimate_dir,
                             const Progress& progress, const Warn& warn) {
  const bool has_training =
      config.method == SeedsMethod::splats || config.method == SeedsMethod::splats_paper;
  if (warn && !has_training && config.splats.poses != SplatPoses::board) {
    warn("splats.poses=" + std::string(to_string(config.splats.poses)) +
         " is not used: it is of the methods splats and splats_paper");
  }
  return perceive_with(
      [&](const SplatWatch& watch) {
        SplatWatch own = watch;
        if (warn) own.left_early = warn;
        own.posed = [&warn, told = watch.posed](const SfmEstimate& sfm) {
          told(sfm);
          if (warn && sfm.status != SfmStatus::ok && has_poses(sfm.status))
            warn("structure from motion: " + std::string(to_string(sfm.status)) + ", " +
                 sfm.reason);
          if (warn && !sfm.colmap_version.empty() && !sfm.colmap_version.starts_with("3.8"))
            warn("structure from motion: COLMAP " + sfm.colmap_version + ", tested with 3.8");
        };
        return stages_of(config, seed, sources, scene_index, own, warn);
      },
      [&](const SeedsStages& stages, const StageObserver& observe) {
        return run_seeds(capture, config, stages, observe);
      },
      sources, scene_index, estimate_dir, progress);
}

}  // namespace cousin
