#include "benchmarks/suites/seeds/trained_models.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "benchmarks/loop/limits.h"
#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/splat_images.h"
#include "benchmarks/suites/splats/kept_training.h"
#include "benchmarks/suites/splats/ngp_view.h"
#include "perception/cloud/measure_traits.h"
#include "perception/splats/splat_render.h"
#include "sim/types/stage_clock.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

constexpr std::size_t kAllViews = std::numeric_limits<std::size_t>::max();
/// Of each kind, that a model is scored by: on the way, and at its end.
constexpr std::size_t kViewsOnTheWay = 10, kViewsAtTheEnd = 60;

// Chosen on views trained on of 60 of maize (seed 1, 1280 x 720).
constexpr int kSplatsForImages = 100000;
constexpr double kCentreRateForImages = 1e-3;  ///< a share of the cameras' extent

bool is_before_training(const StageTiming& timing) {
  return timing.stage == "corners" || timing.stage == "poses";
}

/// What a stage's clock has to be changed by to say the seconds of all processes without those that
/// models and checkpoints take to be kept.
StageTiming seconds_of_training_alone(const SplatTraining& training) {
  StageTiming change = seconds_before(training);
  change.wall_s -= training.seconds.kept;
  change.cpu_s -= training.seconds.kept_cpu;
  return change;
}

StageTiming seconds_of_poses(const Estimate& estimate) {
  for (const StageTiming& timing : estimate.timings) {
    if (timing.stage == "poses") return timing;
  }
  return {};
}

Stages stages_of(const SeedsTrainingTask& task, const SeedsPipelineConfig& config,
                 const SplatWatch& watch) {
  Stages stages = stages_of(config, task.run->capture, task.stage_seed, {}, 0, watch);
  if (task.posed_by != nullptr) {
    stages.poses = [&task](const Capture&, const Estimate&) { return task.posed_by->poses; };
  }
  return stages;
}

/// The chain after a training that was left at this model. @param last  the training's end
Estimate measured(const SeedsTrainingTask& task, const SeedsPipelineConfig& config,
                  const Estimate& end, const StageTiming& last, const KeptModel& way) {
  Stages stages = stages_of(config, task.run->capture, task.stage_seed, {}, 0);
  stages.corners = nullptr;
  stages.poses = [&end](const Capture&, const Estimate&) { return end.poses; };
  stages.splats = [&](const Capture& capture, const Estimate&) {
    if (config.method != SeedsMethod::splats) return way.model;
    return without_strays(way.model, volume_of(config, board_of(capture, config)));
  };
  Estimate estimate = run_seeds(task.run->capture, config, stages);
  std::vector<StageTiming> timings;
  for (StageTiming timing : end.timings) {
    if (timing.stage == "splats") {  // without the steps that came after
      timing.wall_s -= last.wall_s - way.seconds.wall_s;
      timing.cpu_s -= last.cpu_s - way.seconds.cpu_s;
      timing.peak_rss_mb = way.seconds.peak_rss_mb;
      timing.peak_above_start_mb = way.seconds.peak_above_start_mb;
    } else if (!is_before_training(timing)) {
      continue;
    }
    timings.push_back(timing);
  }
  for (const StageTiming& timing : estimate.timings) {
    if (!is_before_training(timing) && timing.stage != "splats") timings.push_back(timing);
  }
  estimate.timings = std::move(timings);
  return estimate;
}

void add_rows(const SeedsTrainingTask& task, const SeedsPipelineConfig& config,
              const Estimate& estimate, const SeedsScoreLabels& labels, bool is_end,
              ScoreFile& file) {
  SeedsScores scores = score_run(task.run->truth, estimate, labels);
  add_curve_rows(scores, estimate, labels, file.scores);
  append({.scores = std::move(scores.rows)}, file);
  if (is_end) append({.specimens = std::move(scores.specimens)}, file);
  append({.scores = splat_image_rows(task.run->capture, estimate, config, labels, task.learned,
                                     is_end ? kViewsAtTheEnd : kViewsOnTheWay)},
         file);
}

SeedsScoreLabels after_steps(SeedsScoreLabels labels, int steps) {
  labels.case_name += ", " + std::to_string(steps) + " steps";
  labels.settings.steps = steps;
  return labels;
}

double total_wall_s(const Estimate& estimate) {
  return std::accumulate(estimate.timings.begin(), estimate.timings.end(), 0.0,
                         [](double sum, const StageTiming& t) { return sum + t.wall_s; });
}

NgpConfig ngp_config(const SeedsTrainingTask& task) {
  const SweepVolume volume = volume_of(task.pipeline, board_of(task.run->capture, task.pipeline));
  const Eigen::Vector3d centre_m = 0.5 * (volume.low_m + volume.high_m);
  NgpConfig config;
  config.iterations = task.at.back();
  config.seed = task.stage_seed;
  config.side_m = (volume.high_m - volume.low_m).maxCoeff();
  config.centre_m = {centre_m.x(), centre_m.y(), centre_m.z()};
  config.cascades = 1;  // the rest is black
  return config;
}

}  // namespace

void add_curve_rows(const SeedsScores& scores, const Estimate& estimate,
                    const SeedsScoreLabels& labels, std::vector<ScoreRow>& rows) {
  for (const std::string_view trait : kSeedTraits) {
    const auto pairs =
        trait_pairs(scores.specimens, trait, [](const SpecimenRow&) { return true; });
    ScoreRow base = labelled_row(labels);
    base.wall_s = total_wall_s(estimate);
    const std::string name(trait), unit(trait_row(trait).unit);
    if (pairs.size() < 2) {
      add_missing(rows, base, "curve." + name + ".rmse", unit);
      continue;
    }
    const TraitStatistics s =
        trait_statistics(pairs, Rng(labels.seed).fork("curve").fork(labels.case_name + name));
    rows.push_back(with_interval(base, "curve." + name + ".rmse", unit, s.rmse, s.n));
    rows.push_back(with_interval(base, "curve." + name + ".mape", "1", s.mape, s.n));
  }
}

MeasuredModel measure_by_splats(const SeedsTrainingTask& task, SeedsMethod method) {
  SeedsPipelineConfig config = task.pipeline;
  config.method = method;
  SeedsScoreLabels labels = task.labels;
  labels.method = std::string(to_string(method));
  const KeptTraining kept(task.unfinished.empty() ? task.unfinished
                                                  : task.unfinished / labels.method);
  const int last =
      method == SeedsMethod::splats_paper ? config.splats.reference_steps : config.splats.steps;
  SplatWatch watch;
  watch.progress = [&](int done, int all) {
    if (task.progress) task.progress("perceive: " + labels.method + ", step", done, all);
  };
  watch.snapshots = kept.snapshots(task.at);
  watch.checkpoint = kept.checkpoint();
  watch.sfm_folder = task.sfm_folder;
  StageTiming before, steps;
  StageTiming posed_before =
      task.posed_by != nullptr ? seconds_of_poses(*task.posed_by) : StageTiming{};
  MeasuredModel result;
  watch.end = [&](const SplatTraining& training) {
    before = seconds_of_training_alone(training);
    if (training.curve.empty()) return;
    steps.wall_s = training.curve.back().wall_s;
    steps.cpu_s = training.curve.back().cpu_s;
  };
  watch.posed = [&](const SfmEstimate& sfm) {
    posed_before = sfm.done_before;
    ScoreRow row = labelled_row(labels);
    row.metric = "structure from motion: " + std::string(to_string(sfm.status)) + ", views placed";
    row.unit = "1";
    row.n = static_cast<std::int64_t>(sfm.poses.size());
    row.value = static_cast<double>(sfm.poses.size() - sfm.lost.size());
    result.file.scores.push_back(row);
  };
  result.estimate = run_seeds(task.run->capture, config, stages_of(task, config, watch));
  add_seconds_before("splats", before, result.estimate.timings);
  add_seconds_before("poses", posed_before, result.estimate.timings);
  add_rows(task, config, result.estimate, after_steps(labels, last), true, result.file);
  if (result.estimate.splats.splats.empty()) {
    result.file.scores.push_back(untrained_row(labelled_row(labels), result.estimate.splats));
    return result;
  }
  std::vector<int> on_the_way = task.at;
  std::erase_if(on_the_way, [last](int step) { return step >= last; });
  for (const KeptModel& way : kept.models(on_the_way)) {
    add_rows(task, config, measured(task, config, result.estimate, steps, way),
             after_steps(labels, way.step), false, result.file);
  }
  return result;
}

SeedsPipelineConfig pipeline_for_images(SeedsPipelineConfig pipeline, int steps) {
  pipeline.method = SeedsMethod::splats;
  pipeline.splats.steps = steps;
  pipeline.splats.most_splats = kSplatsForImages;
  pipeline.splats.shape_rate = pipeline.splats.opacity_rate = 1;
  pipeline.splats.centre_rate = kCentreRateForImages;
  return pipeline;
}

std::vector<ScoreRow> measure_for_images(const SeedsTrainingTask& task, int steps) {
  const SeedsPipelineConfig config = pipeline_for_images(task.pipeline, steps);
  SeedsScoreLabels labels = after_steps(task.labels, steps);
  labels.method = "splats_images";
  const KeptTraining kept(task.unfinished.empty()
                              ? task.unfinished
                              : task.unfinished / (labels.method + std::to_string(steps)));
  SplatWatch watch;
  watch.progress = [&](int done, int all) {
    if (task.progress) task.progress("perceive: " + labels.method + ", step", done, all);
  };
  watch.checkpoint = kept.checkpoint();
  watch.sfm_folder = task.sfm_folder;
  StageTiming before;
  watch.end = [&](const SplatTraining& training) { before = seconds_of_training_alone(training); };
  Estimate estimate = run_seeds(task.run->capture, config, stages_of(task, config, watch));
  add_seconds_before("splats", before, estimate.timings);
  std::vector<ScoreRow> rows =
      splat_image_rows(task.run->capture, estimate, config, labels, task.learned, kAllViews);
  if (rows.empty()) return {untrained_row(labelled_row(labels), estimate.splats)};
  ScoreRow seconds = rows.back();
  seconds.metric = "seconds.splats";
  seconds.value = seconds.wall_s;
  seconds.unit = "s";
  rows.push_back(seconds);
  return rows;
}

std::vector<ScoreRow> measure_by_ngp(const SeedsTrainingTask& task, const Poses& poses) {
  if (task.at.empty()) return {};
  std::vector<ScoredPhotograph> scored;
  for (const ScoredPhotograph& photograph :
       scored_photographs(task.run->capture, poses, task.pipeline,
                          task.pipeline.splats.reference_margin_px, kAllViews)) {
    scored.push_back(made_small(photograph));
  }
  std::vector<NgpView> views;
  for (const ScoredPhotograph& photograph : scored) {
    if (!photograph.held_out) views.push_back(ngp_view(photograph.view));
  }
  SeedsScoreLabels labels = task.labels;
  labels.method = "instant-ngp";
  std::vector<ScoreRow> rows;
  const auto add = [&](const KeptField& way) {
    ScoreRow base = labelled_row(after_steps(labels, way.step));
    base.wall_s = way.seconds.wall_s;
    base.cpu_s = way.seconds.cpu_s;
    base.peak_rss_mb = way.seconds.peak_rss_mb;
    base.peak_above_start_mb = way.seconds.peak_above_start_mb;
    std::vector<ScoredPhotograph> some;
    const std::size_t every = std::max<std::size_t>(1, scored.size() / (2 * kViewsOnTheWay));
    for (std::size_t i = 0; i < scored.size(); ++i) {
      if (scored[i].held_out || i % every == 0) some.push_back(scored[i]);
    }
    const SeedsImageRenderer render = [&](const Camera& camera, const Pose& pose) {
      return fidelity_planes(render_ngp(way.model, camera, pose).color);
    };
    for (ScoreRow& row : photograph_rows(some, render, base, task.learned)) {
      // Its photographs are small already; a third of that is nobody's size.
      if (row.metric.ends_with("_small")) continue;
      row.metric += "_small";
      rows.push_back(row);
    }
  };
  const auto steps = [&](int done, int all) {
    if (task.progress) task.progress("radiance field, step", done, all);
  };
  const KeptFieldTraining kept(task.unfinished.empty() ? task.unfinished
                                                       : task.unfinished / labels.method);
  const NgpTraining training =
      train_ngp(views, ngp_config(task), kept.snapshots(task.at), steps, kept.checkpoint());
  for (const KeptField& way : kept.models(task.at)) add(way);
  if (training.status != NgpStatus::ok) {
    ScoreRow row = labelled_row(labels);
    row.metric = "training: " + std::string(to_string(training.status)) + ", " + training.reason;
    row.status = ScoreStatus::not_solved;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace cousin
