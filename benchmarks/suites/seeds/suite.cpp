#include "benchmarks/suites/seeds/suite.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include "benchmarks/loop/attribution.h"
#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/report_scene.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/truth_stages.h"
#include "benchmarks/suites/seeds/capture_store.h"
#include "benchmarks/suites/seeds/render_noise.h"
#include "benchmarks/suites/seeds/suite_jobs.h"
#include "benchmarks/suites/seeds/trained_models.h"
#include "perception/sfm/colmap_run.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

Capture subset(const Capture& capture, int views) {
  Capture part = capture;
  part.frames.clear();
  const int all = static_cast<int>(capture.frames.size());
  for (int i = 0; i < views; ++i)
    part.frames.push_back(capture.frames[static_cast<std::size_t>(i * all / views)]);
  return part;
}

SceneTruth subset(const SceneTruth& truth, int views) {
  SceneTruth part = truth;
  part.views.clear();
  part.images.clear();
  const int all = static_cast<int>(truth.views.size());
  for (int i = 0; i < views; ++i)
    part.views.push_back(truth.views[static_cast<std::size_t>(i * all / views)]);
  return part;
}

/// The paper's steps on the cloud that ours made: same poses, depth and points.
Estimate paper_on_same_cloud(const Capture& capture, const SeedsPipelineConfig& config,
                             std::uint64_t seed, const Estimate& ours) {
  SeedsPipelineConfig paper = config;
  paper.method = SeedsMethod::paper;
  Stages stages = seeds_stages(paper, seed);
  stages.corners = nullptr;
  stages.poses = nullptr;
  stages.depths = nullptr;
  stages.cloud = [&ours](const Capture&, const Estimate&) { return ours.cloud; };
  Estimate estimate = run_seeds(capture, paper, stages);
  estimate.poses = ours.poses;
  // Its seconds include those of the stages it shares.
  std::vector<StageTiming> timings;
  for (const StageTiming& t : ours.timings) {
    if (t.stage == "corners" || t.stage == "poses" || t.stage == "depth" || t.stage == "cloud")
      timings.push_back(t);
  }
  for (const StageTiming& t : estimate.timings) {
    if (t.stage != "cloud") timings.push_back(t);
  }
  estimate.timings = timings;
  return estimate;
}

/// Corners and poses, and nothing after them.
Estimate posed_alone(const Capture& capture, const SeedsPipelineConfig& config,
                     std::uint64_t seed) {
  const Stages all = seeds_stages(config, seed);
  Stages stages;
  stages.corners = all.corners;
  stages.poses = all.poses;
  return run_seeds(capture, config, stages);
}

/// Measures by models trained on all views of a capture. @return what our Gaussians found
Estimate measured_by_trained(const SuiteJob& job, SeedsTrainingTask task, const Poses& poses,
                             ScoreFile& file) {
  MeasuredModel reference, ours;
  if (job.work.trained.reference) {
    task.at = job.work.trained.reference_at;
    reference = measure_by_splats(task, SeedsMethod::splats_paper);
    if (!job.work.pooled) reference.file.specimens.clear();
    append(reference.file, file);
    if (task.pipeline.splats.poses != SplatPoses::board) task.posed_by = &reference.estimate;
  }
  if (job.work.trained.ours) {
    task.at = job.work.trained.ours_at;
    ours = measure_by_splats(task, SeedsMethod::splats);
    if (!job.work.pooled) ours.file.specimens.clear();
    append(ours.file, file);
  }
  task.at = {};
  for (const int steps : job.work.trained.ours_steps) {
    SeedsTrainingTask own = task;
    own.pipeline.splats.steps = steps;
    if (!own.unfinished.empty()) own.unfinished /= "splats" + std::to_string(steps);
    MeasuredModel model = measure_by_splats(own, SeedsMethod::splats);
    model.file.specimens.clear();
    append(model.file, file);
  }
  for (const int steps : job.work.trained.images_steps)
    append({.scores = measure_for_images(task, steps)}, file);
  task.at = job.work.trained.ngp_at;
  const bool lacks_poses = !task.at.empty() && poses.empty();
  const Poses used =
      lacks_poses ? posed_alone(task.run->capture, task.pipeline, task.stage_seed).poses : poses;
  append({.scores = measure_by_ngp(task, used)}, file);
  return std::move(ours.estimate);
}

/// What structure from motion said, if it was that which failed.
std::optional<SfmStatus> why_no_poses(const StageError& error) {
  try {
    std::rethrow_if_nested(error);
  } catch (const NoPosesError& none) {
    return none.status;
  } catch (...) {  // something else: the caller has the error
  }
  return {};
}

/// The same by poses that COLMAP finds once for all of them, where the job has these; where it
/// found none for these photographs a row says so. What the machine did to it is an error: another
/// try may end well.
Estimate add_trained(const SuiteJob& job, SeedsTrainingTask task, const Poses& poses,
                     ScoreFile& file) {
  const SplatPoses from = seeds_pipeline(job.config).splats.poses;
  if (from == SplatPoses::board) return measured_by_trained(job, std::move(task), poses, file);
  task.labels.case_name += ", poses " + std::string(to_string(from));
  task.labels.settings.poses = to_string(from);
  if (!task.unfinished.empty()) task.sfm_folder = task.unfinished / "colmap";
  ScoreRow row = labelled_row(task.labels);
  try {
    return measured_by_trained(job, std::move(task), poses, file);
  } catch (const StageError& error) {
    const std::optional<SfmStatus> why = why_no_poses(error);
    if (!why || *why == SfmStatus::program_failed || *why == SfmStatus::timed_out) throw;
    row.method = to_string(SeedsMethod::splats_paper);
    row.metric = "poses: " + std::string(to_string(*why));
    row.status = *why == SfmStatus::not_built ? ScoreStatus::not_built : ScoreStatus::not_solved;
    file.scores.push_back(row);
    return {};
  }
}

/// Where a job's trainings go on from; nowhere if it has none.
std::filesystem::path unfinished_of(const SuiteJob& job, const SeedsSuiteConfig& suite) {
  if (!job.work.trained.splats || suite.unfinished.empty()) return {};
  return suite.unfinished / job.grid.name;
}

ScoreFile noise_of(const SuiteJob& job) {
  const Simulation simulation(job.config, job.seed, job.run);
  SeedsScoreLabels labels;
  labels.suite = kSplatsSuite;
  labels.scene = seeds_scene(job.config).cultivar;
  labels.seed = job.seed;
  labels.method = "photographs";
  const Camera& camera = simulation.capture_header().rig.front().camera;
  labels.case_name = labels.scene + " run " + std::to_string(job.run) + " " +
                     std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px);
  const NoiseFloor floor =
      measure_noise_floor(simulation, seeds_pipeline(job.config).green, job.work.noise_views);
  ScoreFile file;
  for (const auto& [metric, value] : {std::pair("noise_floor.psnr", floor.psnr_db),
                                      std::pair("noise_floor.psnr_object", floor.psnr_object_db),
                                      std::pair("noise_floor.psnr_whole", floor.psnr_whole_db)}) {
    ScoreRow row = labelled_row(labels);
    row.metric = metric;
    row.value = value;
    row.unit = "dB";
    row.n = job.work.noise_views;
    file.scores.push_back(row);
  }
  return file;
}

SeedsScoreLabels job_labels(const SuiteJob& job) {
  SeedsScoreLabels labels;
  if (seeds_scene(job.config).spread == SizeSpread::paper) labels.suite = kPaperSpread;
  if (job.work.trained.splats) labels.suite = kSplatsSuite;
  labels.scene = seeds_scene(job.config).sphere ? "sphere" : seeds_scene(job.config).cultivar;
  labels.run = std::to_string(job.run);
  labels.seed = job.seed;
  return labels;
}

std::string size_text(const Camera& camera) {
  return std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px);
}

void label_views(const SuiteJob& job, const Camera& camera, int views, SeedsScoreLabels& labels) {
  labels.case_name = labels.scene + " run " + labels.run + " " + std::to_string(views) + " views " +
                     size_text(camera);
  const int every = seeds_pipeline(job.config).splats.hold_out_every;
  if (every > 1) labels.case_name += ", one in " + std::to_string(every) + " held out";
  labels.settings = {.run = job.run,
                     .views = views,
                     .width_px = camera.width_px,
                     .height_px = camera.height_px,
                     .held_out_every = every > 1 ? every : 0};
}

/// Specimens count where the job's are pooled and all views are measured.
void add_both_methods(const SceneTruth& truth, const Estimate& ours, const Estimate& paper,
                      bool has_specimens, SeedsScoreLabels& labels, ScoreFile& file) {
  for (const auto& [method, estimate] : {std::pair{"ours", &ours}, std::pair{"paper", &paper}}) {
    labels.method = method;
    SeedsScores scores = score_run(truth, *estimate, labels);
    add_curve_rows(scores, *estimate, labels, file.scores);
    file.scores.insert(file.scores.end(), scores.rows.begin(), scores.rows.end());
    if (has_specimens) {
      file.specimens.insert(file.specimens.end(), scores.specimens.begin(), scores.specimens.end());
    }
  }
}

void add_attribution(const SuiteJob& job, const SimulatedRun& run, const Capture& capture,
                     std::uint64_t stage_seed, const Estimate& ours, SeedsScoreLabels& labels,
                     const Progress& progress, ScoreFile& file) {
  labels.method = "ours";
  const auto steps = attribute(run, seeds_pipeline(job.config),
                               stages_of(seeds_pipeline(job.config), capture, stage_seed, {}, 0),
                               labels, &ours, progress);
  for (ScoreRow& row : attribution_rows(steps, kSeedTraits, labels)) {
    row.scene = labels.scene;
    file.scores.push_back(std::move(row));
  }
}

void add_simulator_seconds(const SimulatedRun& run, const SeedsScoreLabels& labels,
                           ScoreFile& file) {
  const std::string size = size_text(run.capture.rig.front().camera);
  for (const StageTiming& timing : run.timings) {
    ScoreRow row = labelled_row(labels);
    row.case_name = labels.scene + " run " + labels.run + " " + size;
    row.method = "simulator";
    row.metric = "seconds." + timing.stage;
    row.value = timing.wall_s;
    row.unit = "s";
    row.n = static_cast<std::int64_t>(run.capture.frames.size());
    row.wall_s = timing.wall_s;
    row.cpu_s = timing.cpu_s;
    row.peak_rss_mb = timing.peak_rss_mb;
    row.peak_above_start_mb = timing.peak_above_start_mb;
    file.scores.push_back(std::move(row));
  }
}

std::string run_job(const SuiteJob& job, const SeedsSuiteConfig& suite,
                    const LearnedDistance* learned, const Progress& progress) {
  if (job.work.noise_views > 0) return to_json(noise_of(job));
  const SimulatedRun run =
      stored_seeds(suite.captures, job.config, job.seed, job.run,
                   planned_truth(SeedsPipelineConfig(), job.work.attribution), progress);
  ScoreFile file;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = config_hash(job.config, job.seed);
  SeedsScoreLabels labels = job_labels(job);
  const Camera& camera = run.capture.rig.front().camera;
  const std::uint64_t stage_seed = Rng(job.seed).fork(static_cast<std::uint64_t>(job.run))();
  for (const int views : job.work.view_counts) {
    const bool all = views == static_cast<int>(run.capture.frames.size());
    const Capture capture = subset(run.capture, views);
    const SceneTruth truth = subset(run.truth, views);
    label_views(job, camera, views, labels);
    const SeedsTrainingTask training{.run = &run,
                                     .pipeline = seeds_pipeline(job.config),
                                     .stage_seed = stage_seed,
                                     .labels = labels,
                                     .learned = learned,
                                     .progress = progress,
                                     .unfinished = unfinished_of(job, suite)};
    if (job.work.only_trained) {
      add_trained(job, training, {}, file);
      continue;
    }
    const Estimate ours =
        perceive(capture, seeds_pipeline(job.config), stage_seed, {}, 0, {}, progress);
    const Estimate paper =
        paper_on_same_cloud(capture, seeds_pipeline(job.config), stage_seed, ours);
    add_both_methods(truth, ours, paper, all && job.work.pooled, labels, file);
    const Estimate* shown = &ours;
    Estimate by_splats;
    if (all && job.work.trained.splats) {
      by_splats = add_trained(job, training, ours.poses, file);
      shown = &by_splats;
    }
    if (all && job.shown && !suite.report.empty())
      write_report_scene(suite.report, report_scene(job.grid.name, run, *shown));
    if (all && job.work.attribution)
      add_attribution(job, run, capture, stage_seed, ours, labels, progress, file);
  }
  add_simulator_seconds(run, labels, file);
  return to_json(file);
}

}  // namespace

std::vector<ShardJob> seeds_suite_jobs(const SeedsSuiteConfig& config, const Progress& progress) {
  std::shared_ptr<const LearnedDistance> learned;
  std::string network;
  if (!config.lpips.empty()) {
    learned = load_learned_distance(config.lpips);
    network = "/" + sha256_hex_of_file(config.lpips);
  }
  std::vector<ShardJob> jobs;
  const std::string colmap = "/colmap " + colmap_version() +
                             (COUSIN_WITH_CERES ? " adjusted, lens judged" : " without adjustment");
  for (const SuiteJob& job : seeds_jobs(config)) {
    std::string key =
        std::string(COUSIN_VERSION) + resolved_toml(job.config) + std::to_string(job.seed) + "/" +
        std::to_string(job.run) + (job.work.attribution ? "/attribution" : "") +
        (job.work.trained.splats ? training_text(job.work.trained, job.config) + network : "") +
        (job.work.trained.splats && seeds_pipeline(job.config).splats.poses != SplatPoses::board
             ? colmap
             : "") +
        (job.work.noise_views > 0 ? "/noise 4 " + std::to_string(job.work.noise_views) : "") +
        user_files_hash(job.config.scene) + built_in_tables();
    for (const int views : job.work.view_counts) key += "/" + std::to_string(views);
    jobs.push_back(shard_of(
        job.grid, key,
        [job, config, learned, progress] { return run_job(job, config, learned.get(), progress); },
        unfinished_of(job, config)));
  }
  return jobs;
}

std::string suite_toml(const SeedsSuiteConfig& config) {
  const std::vector<SuiteJob> jobs = seeds_jobs(config);
  std::string text = "# " + jobs.front().grid.name + ".json\n" +
                     resolved_toml(jobs.front().config) + "\n# All jobs: --seed " +
                     std::to_string(config.seed) + "\n";
  for (const SuiteJob& job : jobs) {
    text += "# " + job.grid.name + ".json, run " + std::to_string(job.run) + ":";
    for (const std::string& set : job.grid.sets) text += " --set " + set;
    for (const std::string& set : config.sets) text += " --set " + set;
    text += "\n";
  }
  return text;
}

}  // namespace cousin
