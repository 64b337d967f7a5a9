#include "benchmarks/loop/perceive.h"

#include <algorithm>

#include "sim/dataset/seam_io.h"
#include "sim/types/whole_file.h"

namespace cousin {

Stages stages_of(const PipelineConfig& config, const Capture& capture, std::uint64_t seed,
                 const std::vector<StageSource>& sources, int scene_index, const SplatWatch& watch,
                 const Warn& warn) {
  const std::uint64_t own_seed = Rng(seed).fork(static_cast<std::uint64_t>(scene_index))();
  return with_stage_sources(stages_for(config, capture, own_seed, watch), sources,
                            row_of(config).order, scene_index, warn);
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

Estimate perceive_with(const std::function<Stages(const SplatWatch&)>& stages_of_run,
                       const std::function<Estimate(const Stages&, const StageObserver&)>& run,
                       StageOrder order, const std::vector<StageSource>& sources, int scene_index,
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
  const Stages stages = stages_of_run(watch);
  const auto observe = [&](std::string_view stage, bool finished, const Estimate& so_far) {
    const auto place = std::find(order.begin(), order.end(), stage) - order.begin();
    if (!finished) {
      if (progress)
        progress("perceive: " + std::string(stage), static_cast<int>(place),
                 static_cast<int>(order.size()));
    } else if (!estimate_dir.empty()) {
      stage_row(stage).write(estimate_dir, so_far, scene_index);
    }
  };
  if (!estimate_dir.empty()) {
    for (const StageRow& stage : stage_table()) {
      const bool is_read =
          std::any_of(sources.begin(), sources.end(), [&](const StageSource& source) {
            return source.stage == stage.name && source.kind == StageSource::Kind::directory;
          });
      if (!is_read) remove_seam(estimate_dir, stage);  // else it may be read from here
    }
    remove_own(estimate_dir / "timings.json");
  }
  Estimate estimate = run(stages, observe);
  add_seconds_before("splats", before, estimate.timings);
  add_seconds_before("poses", posed_before, estimate.timings);
  if (estimate_dir.empty()) return estimate;
  write_timings(estimate_dir, estimate.timings);
  // Only now: the next run begins with the first seam.
  remove_own(unfinished);
  remove_own_folder(unfinished_sfm);
  return estimate;
}

namespace {

/// Says what structure from motion found, after whoever else is told.
std::function<void(const SfmEstimate&)> with_doubts(
    const std::function<void(const SfmEstimate&)>& told, const Warn& warn) {
  return [told, warn](const SfmEstimate& sfm) {
    told(sfm);
    if (warn && sfm.status != SfmStatus::ok && has_poses(sfm.status))
      warn("structure from motion: " + std::string(to_string(sfm.status)) + ", " + sfm.reason);
    if (warn && !sfm.colmap_version.empty() && !sfm.colmap_version.starts_with("3.8"))
      warn("structure from motion: COLMAP " + sfm.colmap_version + ", tested with 3.8");
  };
}

}  // namespace

Stages with_outside(Stages stages, const Stages& outside, const PipelineRow& row) {
  for (const std::string_view name : row.from_outside) {
    const StageRow& stage = stage_row(name);
    if (!stage.is_there(stages) && stage.is_there(outside)) stage.replace(stages, outside);
  }
  return stages;
}

Estimate perceive(const Capture& capture, const PipelineConfig& config, std::uint64_t seed,
                  const std::vector<StageSource>& sources, int scene_index,
                  const std::filesystem::path& estimate_dir, const Progress& progress,
                  const Warn& warn, const Stages& outside) {
  const PipelineRow& row = row_of(config);
  if (warn) {
    for (const std::string& text : unused_settings(config)) warn(text);
  }
  return perceive_with(
      [&](const SplatWatch& watch) {
        SplatWatch own = watch;
        if (warn) own.left_early = warn;
        own.posed = with_doubts(watch.posed, warn);
        return with_outside(stages_of(config, capture, seed, sources, scene_index, own, warn),
                            outside, row);
      },
      [&](const Stages& stages, const StageObserver& observe) {
        return run_pipeline(capture, config, stages, observe);
      },
      row.order, sources, scene_index, estimate_dir, progress);
}

}  // namespace cousin
