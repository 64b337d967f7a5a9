#include "benchmarks/seeds/suite.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <set>
#include <utility>

#include "benchmarks/seeds/attribution.h"
#include "benchmarks/seeds/capture_store.h"
#include "benchmarks/seeds/perceive.h"
#include "benchmarks/seeds/plan.h"
#include "benchmarks/seeds/render_noise.h"
#include "benchmarks/seeds/report_scene.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/trained_models.h"
#include "benchmarks/seeds/truth_stages.h"
#include "perception/sfm/colmap_run.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

/// Models that are trained on all views of a capture, and the steps after which they are measured
/// beside their ends; none of a method without steps.
struct TrainedJob {
  bool splats = false;    ///< any of these
  bool reference = true;  ///< the paper's way
  bool ours = true;       ///< ours for surfaces
  std::vector<int> reference_at, ours_at, ngp_at;
  /// Of trainings of ours for surfaces and for images, each one of its own: they are on small
  /// photographs first, so that one on its way is not one that ends there.
  std::vector<int> ours_steps, images_steps;
};

/// One capture and what is measured on it.
struct SuiteJob {
  std::string name;
  std::vector<std::string> sets;  ///< its own, before the user's
  SeedsRunConfig config;
  std::uint64_t seed = 0;
  int run = 0;
  std::vector<int>
      view_counts;      ///< evenly spread subsets of the views; the last one is all of them
  bool pooled = false;  ///< its specimens (all views) enter a table of many runs
  bool attribution = false;
  bool shown = false;  ///< the page has pictures of it
  TrainedJob trained;
  bool only_trained = false;  ///< all views by trained models, and by nothing else
  int noise_views = 0;        ///< photographed twice, and nothing else is done
};

/// Views of the Gaussians' captures that are photographed twice.
constexpr int kNoiseViews = 4;

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
SeedsEstimate paper_on_same_cloud(const Capture& capture, const SeedsPipelineConfig& config,
                                  std::uint64_t seed, const SeedsEstimate& ours) {
  SeedsPipelineConfig paper = config;
  paper.method = SeedsMethod::paper;
  SeedsStages stages = seeds_stages(paper, seed);
  stages.corners = nullptr;
  stages.poses = nullptr;
  stages.depth = nullptr;
  stages.cloud = [&ours](const Capture&, const SeedsEstimate&) { return ours.cloud; };
  SeedsEstimate estimate = run_seeds(capture, paper, stages);
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
SeedsEstimate posed_alone(const Capture& capture, const SeedsPipelineConfig& config,
                          std::uint64_t seed) {
  const SeedsStages all = seeds_stages(config, seed);
  SeedsStages stages;
  stages.corners = all.corners;
  stages.poses = all.poses;
  return run_seeds(capture, config, stages);
}

/// Measures by models trained on all views of a capture. @return what our Gaussians found
SeedsEstimate measured_by_trained(const SuiteJob& job, SeedsTrainingTask task, const Poses& poses,
                                  ScoreFile& file) {
  MeasuredModel reference, ours;
  if (job.trained.reference) {
    task.at = job.trained.reference_at;
    reference = measure_by_splats(task, SeedsMethod::splats_paper);
    if (!job.pooled) reference.file.specimens.clear();
    append(reference.file, file);
    if (task.pipeline.splats.poses != SplatPoses::board) task.posed_by = &reference.estimate;
  }
  if (job.trained.ours) {
    task.at = job.trained.ours_at;
    ours = measure_by_splats(task, SeedsMethod::splats);
    if (!job.pooled) ours.file.specimens.clear();
    append(ours.file, file);
  }
  task.at = {};
  for (const int steps : job.trained.ours_steps) {
    SeedsTrainingTask own = task;
    own.pipeline.splats.steps = steps;
    if (!own.unfinished.empty()) own.unfinished /= "splats" + std::to_string(steps);
    MeasuredModel model = measure_by_splats(own, SeedsMethod::splats);
    model.file.specimens.clear();
    append(model.file, file);
  }
  for (const int steps : job.trained.images_steps)
    append({.scores = measure_for_images(task, steps)}, file);
  task.at = job.trained.ngp_at;
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
SeedsEstimate add_trained(const SuiteJob& job, SeedsTrainingTask task, const Poses& poses,
                          ScoreFile& file) {
  const SplatPoses from = job.config.pipeline.splats.poses;
  if (from == SplatPoses::board) return measured_by_trained(job, std::move(task), poses, file);
  task.labels.case_name += kPosesOf + std::string(to_string(from));
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
  if (!job.trained.splats || suite.unfinished.empty()) return {};
  return suite.unfinished / std::filesystem::path(job.name).stem();
}

ScoreFile noise_of(const SuiteJob& job) {
  const SeedsSimulation simulation(job.config, job.seed, job.run);
  SeedsScoreLabels labels;
  labels.suite = kSplatsSuite;
  labels.scene = job.config.scene.cultivar;
  labels.seed = job.seed;
  labels.method = "photographs";
  const Camera& camera = simulation.capture_header().rig.front().camera;
  labels.case_name = labels.scene + " run " + std::to_string(job.run) + " " +
                     std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px);
  const NoiseFloor floor =
      measure_noise_floor(simulation, job.config.pipeline.green, job.noise_views);
  ScoreFile file;
  for (const auto& [metric, value] : {std::pair("noise_floor.psnr", floor.psnr_db),
                                      std::pair("noise_floor.psnr_object", floor.psnr_object_db),
                                      std::pair("noise_floor.psnr_whole", floor.psnr_whole_db)}) {
    ScoreRow row = labelled_row(labels);
    row.metric = metric;
    row.value = value;
    row.unit = "dB";
    row.n = job.noise_views;
    file.scores.push_back(row);
  }
  return file;
}

std::string run_job(const SuiteJob& job, const SeedsSuiteConfig& suite,
                    const LearnedDistance* learned, const Progress& progress) {
  if (job.noise_views > 0) return to_json(noise_of(job));
  const SimulatedRun run = stored_seeds(suite.captures, job.config, job.seed, job.run,
                                        planned_truth(job.attribution), progress);
  ScoreFile file;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = config_hash(job.config, job.seed);
  SeedsScoreLabels labels;
  if (job.config.scene.spread == SizeSpread::paper) labels.suite = kPaperSpread;
  if (job.trained.splats) labels.suite = kSplatsSuite;
  labels.scene = job.config.scene.sphere ? "sphere" : job.config.scene.cultivar;
  labels.run = std::to_string(job.run);
  labels.seed = job.seed;
  const Camera& camera = run.capture.rig.front().camera;
  const std::string size = std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px);
  const std::uint64_t stage_seed = Rng(job.seed).fork(static_cast<std::uint64_t>(job.run))();
  for (const int views : job.view_counts) {
    const bool all = views == static_cast<int>(run.capture.frames.size());
    const Capture capture = subset(run.capture, views);
    const SceneTruth truth = subset(run.truth, views);
    labels.case_name =
        labels.scene + " run " + labels.run + " " + std::to_string(views) + " views " + size;
    if (const int every = job.config.pipeline.splats.hold_out_every; every > 1)
      labels.case_name += ", one in " + std::to_string(every) + " held out";
    const SeedsTrainingTask training{.run = &run,
                                     .pipeline = job.config.pipeline,
                                     .stage_seed = stage_seed,
                                     .labels = labels,
                                     .learned = learned,
                                     .progress = progress,
                                     .unfinished = unfinished_of(job, suite)};
    if (job.only_trained) {
      add_trained(job, training, {}, file);
      continue;
    }
    const SeedsEstimate ours =
        perceive_seeds(capture, job.config.pipeline, stage_seed, {}, 0, {}, progress);
    const SeedsEstimate paper = paper_on_same_cloud(capture, job.config.pipeline, stage_seed, ours);
    for (const auto& [method, estimate] : {std::pair{"ours", &ours}, std::pair{"paper", &paper}}) {
      labels.method = method;
      SeedsScores scores = score_run(truth, *estimate, labels);
      add_curve_rows(scores, *estimate, labels, file.scores);
      file.scores.insert(file.scores.end(), scores.rows.begin(), scores.rows.end());
      if (all && job.pooled) {
        file.specimens.insert(file.specimens.end(), scores.specimens.begin(),
                              scores.specimens.end());
      }
    }
    const SeedsEstimate* shown = &ours;
    SeedsEstimate by_splats;
    if (all && job.trained.splats) {
      by_splats = add_trained(job, training, ours.poses, file);
      shown = &by_splats;
    }
    if (all && job.shown && !suite.report.empty())
      write_report_scene(suite.report,
                         report_scene(std::filesystem::path(job.name).stem(), run, *shown));
    if (all && job.attribution) {
      labels.method = "ours";
      const auto steps = attribute_seeds(run, job.config.pipeline,
                                         stages_of(job.config.pipeline, stage_seed, {}, 0), labels,
                                         &ours, progress);
      for (ScoreRow& row : attribution_rows(steps, labels)) {
        row.scene = labels.scene;
        file.scores.push_back(std::move(row));
      }
    }
  }
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
  return to_json(file);
}

SeedsRunConfig job_config(const SeedsSuiteConfig& suite, const std::vector<std::string>& own) {
  std::vector<std::string> sets = own;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  return seeds_run_config(sets);
}

/// What decides the trainings of a job, beside its configuration.
std::string text_of(const TrainedJob& job, SeedsRunConfig config) {
  if (!job.splats) return {};
  std::string text = job.reference || job.ours ? "/splats without strays, drawn whole"
                                               : "/images alone without strays, drawn whole";
  if (job.reference && !job.ours) text += ", the paper's alone";
  if (job.ours && !job.reference) text += ", ours alone";
  for (const auto* at : {&job.reference_at, &job.ours_at, &job.ngp_at, &job.images_steps}) {
    text += "/";
    for (const int step : *at) text += " " + std::to_string(step);
  }
  for (const int steps : job.ours_steps) text += ", ours " + std::to_string(steps);
  const SeedsPipelineConfig pipeline = config.pipeline;
  for (const int steps : job.images_steps) {
    config.pipeline = pipeline_for_images(pipeline, steps);
    text += "/" + resolved_toml(config);
  }
  return text;
}

/// The user's keys can make jobs equal; the same seeds must not count twice.
void drop_repeated(std::vector<SuiteJob>& jobs) {
  std::set<std::string> seen;
  std::erase_if(jobs, [&](const SuiteJob& job) {
    std::string text =
        resolved_toml(job.config) + std::to_string(job.run) + (job.noise_views > 0 ? "/noise" : "");
    for (const int views : job.view_counts) text += "/" + std::to_string(views);
    return !seen.insert(text + text_of(job.trained, job.config)).second;
  });
}

std::vector<SuiteJob> list_jobs(const SeedsSuiteConfig& suite) {
  std::vector<SuiteJob> jobs;
  const auto add = [&](const std::string& name, int run, const std::vector<std::string>& sets,
                       std::vector<int> view_counts, bool pooled, bool attribution,
                       const TrainedJob& trained = {}) {
    const SeedsRunConfig config = job_config(suite, sets);
    view_counts.push_back(config.scene.views);
    std::sort(view_counts.begin(), view_counts.end());
    view_counts.erase(std::unique(view_counts.begin(), view_counts.end()), view_counts.end());
    std::erase_if(view_counts, [&](int v) { return v > config.scene.views; });
    // One cultivar a species has pictures, so that the page stays small.
    const std::string& cultivar = config.scene.cultivar;
    const bool shown =
        pooled && run == 0 && !config.scene.sphere &&
        (cultivar == "zhengdan958" || cultivar == "jimai22" || cultivar == "suijing18") &&
        config.scene.spread == SizeSpread::literature;
    jobs.push_back({name + ".json", sets, config, suite.seed, run, view_counts, pooled, attribution,
                    shown, trained});
  };
  const auto add_noise = [&](const std::string& name, const std::vector<std::string>& sets) {
    SuiteJob job;
    job.name = name + ".json";
    job.sets = sets;
    job.config = job_config(suite, sets);
    job.seed = suite.seed;
    job.noise_views = std::min(kNoiseViews, job.config.scene.views);
    jobs.push_back(std::move(job));
  };
  if (suite.quick) {
    for (const char* cultivar : {"zhengdan958", "jimai22", "suijing18"}) {
      add(std::string("quick_") + cultivar, 0,
          {std::string("cultivar=") + cultivar, "rig=phone_video_720p", "views=20"}, {10}, true,
          suite.attribution);
    }
    const std::vector<std::string> few = {"cultivar=zhengdan958", "rig=phone_video_720p",
                                          "views=20", "pipeline.splats.reference_steps=1000",
                                          "pipeline.splats.steps=1000"};
    add("quick_splats_zhengdan958", 0, few, {}, true, false,
        {.splats = true,
         .reference_at = {500},
         .ours_at = {500},
         .ngp_at = {100, 250},
         .ours_steps = {250},
         .images_steps = {500}});
    add_noise("quick_noise_zhengdan958", few);
    drop_repeated(jobs);
    return jobs;
  }
  // Trainings that need neither the reference's nor ours for surfaces before them.
  const auto add_alone = [&](const std::string& name, const std::vector<std::string>& sets,
                             TrainedJob trained) {
    trained.splats = true;
    trained.reference = trained.ours = false;
    add(name, 0, sets, {}, false, false, trained);
    jobs.back().only_trained = true;
  };
  const std::vector<std::string> cultivars = cultivar_names();
  for (int run = 0; run < suite.runs; ++run) {
    for (const std::string& cultivar : cultivars) {
      add(cultivar + "_run" + std::to_string(run), run,
          {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=60"}, {}, true,
          suite.attribution && run == 0);
    }
    if (run > 0) continue;
    add("sphere_run0", run, {"sphere=true", "rig=phone_video_1080p", "views=60"}, {}, true, false);
    for (const char* cultivar : {"zhengdan958", "jimai22", "suijing18"}) {
      add(std::string(cultivar) + "_720p", run,
          {std::string("cultivar=") + cultivar, "rig=phone_video_720p", "views=60"}, {10, 20, 40},
          false, false);
    }
  }
  for (const std::string& cultivar : cultivars) {
    const std::vector<std::string> own = {"cultivar=" + cultivar, "rig=phone_video_720p",
                                          "views=60"};
    add(cultivar + "_splats", 0, own, {}, true, false,
        {.splats = true,
         .reference_at = {500, 1000, 2000, 5000},
         .ours_at = {300, 600},
         .images_steps = {1000, 3000}});
    add_alone(cultivar + "_ngp", own, {.ngp_at = {500, 1000, 2000, 5000, 7000}});
    add_noise(cultivar + "_noise", own);
  }
  add("sphere_splats", 0, {"sphere=true", "rig=phone_video_720p", "views=60"}, {}, true, false,
      {.splats = true});
  const std::vector<std::string> held_out = {"cultivar=zhengdan958", "rig=phone_video_720p",
                                             "views=60", "pipeline.splats.hold_out_every=8"};
  std::vector<std::string> as_long = held_out;
  as_long.emplace_back("pipeline.splats.reference_steps=30000");
  add("zhengdan958_splats_30k", 0, as_long, {}, false, false,
      {.splats = true, .ours = false, .reference_at = {500, 1000, 2000, 5000, 7000, 10000}});
  // The same photographs by the others, as far: half an hour to an hour each.
  add_alone("zhengdan958_surfaces_30k", held_out,
            {.ours_steps = {500, 1000, 2000, 5000, 7000, 10000, 30000}});
  add_alone("zhengdan958_images_30k", held_out,
            {.images_steps = {500, 1000, 2000, 3000, 5000, 7000, 10000, 30000}});
  add_alone("zhengdan958_ngp_30k", held_out,
            {.ngp_at = {500, 1000, 2000, 5000, 7000, 10000, 30000}});
  // The paper's chain from its first step on, and what our adjustment of the same tracks changes.
  const std::vector<std::string> small = {"cultivar=zhengdan958", "rig=phone_video_720p",
                                          "views=60"};
  const auto add_posed = [&](const std::string& name, SplatPoses poses,
                             const std::vector<std::string>& same, const TrainedJob& trained) {
    std::vector<std::string> own = same;
    own.push_back("pipeline.splats.poses=" + std::string(to_string(poses)));
    // A user's word about poses is of every job: these would be one of the others.
    if (job_config(suite, same).pipeline.splats.poses != SplatPoses::board ||
        job_config(suite, own).pipeline.splats.poses != poses)
      return;
    add(name + "_" + std::string(to_string(poses)), 0, own, {}, false, false, trained);
    jobs.back().only_trained = true;
  };
  for (const SplatPoses poses : {SplatPoses::sfm, SplatPoses::adjusted})
    add_posed("zhengdan958_splats", poses, small, {.splats = true});
  // As many photographs, pixels and steps as the paper has: two hours. Ours by such poses is
  // measured on the small ones.
  add_posed("zhengdan958_270views_splats", SplatPoses::sfm,
            {"cultivar=zhengdan958", "rig=phone_video_1080p", "views=270",
             "pipeline.splats.reference_steps=30000", "pipeline.splats.most_pixels=6e8"},
            {.splats = true, .ours = false, .reference_at = {5000, 7000, 10000}});
  for (const std::string& cultivar : cultivars) {
    add(cultivar + "_270views", 0, {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=270"},
        {120}, false, false);
  }
  for (const std::string& cultivar : cultivars) {
    add(cultivar + "_paper_spread", 0,
        {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=60", "spread=paper"}, {}, true,
        false);
  }
  drop_repeated(jobs);
  return jobs;
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
  for (const SuiteJob& job : list_jobs(config)) {
    std::string key =
        std::string(COUSIN_VERSION) + resolved_toml(job.config) + std::to_string(job.seed) + "/" +
        std::to_string(job.run) + (job.attribution ? "/attribution" : "") +
        (job.trained.splats ? text_of(job.trained, job.config) + network : "") +
        (job.trained.splats && job.config.pipeline.splats.poses != SplatPoses::board ? colmap
                                                                                     : "") +
        (job.noise_views > 0 ? "/noise 4 " + std::to_string(job.noise_views) : "") +
        user_files_hash(job.config.scene) + built_in_tables();
    for (const int views : job.view_counts) key += "/" + std::to_string(views);
    jobs.push_back(
        {job.name, key,
         [job, config, learned, progress] { return run_job(job, config, learned.get(), progress); },
         unfinished_of(job, config)});
  }
  return jobs;
}

std::string suite_toml(const SeedsSuiteConfig& config) {
  const std::vector<SuiteJob> jobs = list_jobs(config);
  std::string text = "# " + jobs.front().name + "\n" + resolved_toml(jobs.front().config) +
                     "\n# All jobs: --seed " + std::to_string(config.seed) + "\n";
  for (const SuiteJob& job : jobs) {
    text += "# " + job.name + ", run " + std::to_string(job.run) + ":";
    for (const std::string& set : job.sets) text += " --set " + set;
    for (const std::string& set : config.sets) text += " --set " + set;
    text += "\n";
  }
  return text;
}

}  // namespace cousin
