#include "benchmarks/seeds/suite.h"

#include <algorithm>
#include <numeric>

#include "benchmarks/seeds/attribution.h"
#include "benchmarks/seeds/capture_store.h"
#include "benchmarks/seeds/perceive.h"
#include "benchmarks/seeds/plan.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/truth_stages.h"

namespace cousin {
namespace {

/// One capture and what is measured on it.
struct SuiteJob {
  std::string name;
  SeedsRunConfig config;
  std::uint64_t seed = 0;
  int run = 0;
  std::vector<int>
      view_counts;      ///< evenly spread subsets of the views; the last one is all of them
  bool pooled = false;  ///< its specimens (all views) enter the main table
  bool attribution = false;
};

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

double total_wall_s(const SeedsEstimate& estimate) {
  return std::accumulate(estimate.timings.begin(), estimate.timings.end(), 0.0,
                         [](double sum, const StageTiming& t) { return sum + t.wall_s; });
}

/// RMSE rows of one capture with the seconds they cost: points of the error-against-time curves.
void add_curve_rows(const SeedsScores& scores, const SeedsEstimate& estimate,
                    const SeedsScoreLabels& labels, std::vector<ScoreRow>& rows) {
  for (const char* trait : {"length", "width", "height", "area", "volume"}) {
    const auto pairs =
        trait_pairs(scores.specimens, trait, [](const SpecimenRow&) { return true; });
    if (pairs.size() < 2) continue;
    ScoreRow base;
    base.suite = labels.suite;
    base.scene = labels.scene;
    base.case_name = labels.case_name;
    base.method = labels.method;
    base.seed = labels.seed;
    base.wall_s = total_wall_s(estimate);
    const std::string name = trait;
    const TraitStatistics s =
        trait_statistics(pairs, Rng(labels.seed).fork("curve").fork(labels.case_name + name));
    rows.push_back(with_interval(base, "curve." + name + ".rmse",
                                 name == "area"     ? "m2"
                                 : name == "volume" ? "m3"
                                                    : "m",
                                 s.rmse, s.n));
    rows.push_back(with_interval(base, "curve." + name + ".mape", "1", s.mape, s.n));
  }
}

std::string run_job(const SuiteJob& job, const std::filesystem::path& captures,
                    const Progress& progress) {
  const SimulatedRun run = stored_seeds(captures, job.config, job.seed, job.run,
                                        planned_truth(job.attribution), progress);
  ScoreFile file;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = config_hash(job.config, job.seed);
  SeedsScoreLabels labels;
  labels.scene = job.config.scene.sphere ? "sphere" : job.config.scene.cultivar;
  labels.run = std::to_string(job.run);
  labels.seed = job.seed;
  const std::string size =
      std::to_string(job.config.rig.width_px) + "x" + std::to_string(job.config.rig.height_px);
  const std::uint64_t stage_seed = Rng(job.seed).fork(static_cast<std::uint64_t>(job.run))();
  for (const int views : job.view_counts) {
    const bool all = views == static_cast<int>(run.capture.frames.size());
    const Capture capture = subset(run.capture, views);
    const SceneTruth truth = subset(run.truth, views);
    labels.case_name =
        labels.scene + " run " + labels.run + " " + std::to_string(views) + " views " + size;
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
    ScoreRow row;
    row.suite = labels.suite;
    row.scene = labels.scene;
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
    row.seed = job.seed;
    file.scores.push_back(std::move(row));
  }
  return to_json(file);
}

SeedsRunConfig job_config(const SeedsSuiteConfig& suite, const std::vector<std::string>& own) {
  std::vector<std::string> sets = own;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  return seeds_run_config(sets);
}

std::vector<SuiteJob> list_jobs(const SeedsSuiteConfig& suite) {
  std::vector<SuiteJob> jobs;
  const auto add = [&](const std::string& name, int run, const std::vector<std::string>& sets,
                       std::vector<int> view_counts, bool pooled, bool attribution) {
    const SeedsRunConfig config = job_config(suite, sets);
    view_counts.push_back(config.scene.views);
    std::sort(view_counts.begin(), view_counts.end());
    view_counts.erase(std::unique(view_counts.begin(), view_counts.end()), view_counts.end());
    std::erase_if(view_counts, [&](int v) { return v > config.scene.views; });
    jobs.push_back({name + ".json", config, suite.seed, run, view_counts, pooled, attribution});
  };
  if (suite.quick) {
    for (const char* cultivar : {"zhengdan958", "jimai22", "suijing18"}) {
      add(std::string("quick_") + cultivar, 0,
          {std::string("cultivar=") + cultivar, "rig=phone_video_720p", "views=30"}, {10, 20}, true,
          suite.attribution);
    }
    return jobs;
  }
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
    add(cultivar + "_270views", 0, {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=270"},
        {120}, false, false);
  }
  return jobs;
}

}  // namespace

std::vector<ShardJob> seeds_suite_jobs(const SeedsSuiteConfig& config, const Progress& progress) {
  std::vector<ShardJob> jobs;
  for (const SuiteJob& job : list_jobs(config)) {
    std::string key = std::string(COUSIN_VERSION) + resolved_toml(job.config) +
                      std::to_string(job.seed) + "/" + std::to_string(job.run) +
                      (job.attribution ? "/attribution" : "");
    for (const int views : job.view_counts) key += "/" + std::to_string(views);
    jobs.push_back({job.name, key, [job, captures = config.captures, progress] {
                      return run_job(job, captures, progress);
                    }});
  }
  return jobs;
}

ScoreFile pool_seeds_suite(const std::vector<ShardResult>& results,
                           const SeedsSuiteConfig& config) {
  ScoreFile pooled;
  pooled.header.program_version = COUSIN_VERSION;
  SeedsScoreLabels labels;
  labels.seed = config.seed;
  for (const ShardResult& result : results) {
    if (!result.text.empty()) {
      const ScoreFile part = scores_from_json(result.text, result.name);
      pooled.scores.insert(pooled.scores.end(), part.scores.begin(), part.scores.end());
      pooled.specimens.insert(pooled.specimens.end(), part.specimens.begin(), part.specimens.end());
    } else if (!result.error.empty()) {
      ScoreRow row;
      row.suite = labels.suite;
      row.case_name = result.name;
      row.metric = result.error;
      row.status = ScoreStatus::error;
      pooled.scores.push_back(std::move(row));
    }
  }
  labels.scene = "pooled";
  for (ScoreRow& row : pooled_rows(pooled.specimens, labels))
    pooled.scores.push_back(std::move(row));
  for (ScoreRow& row : paired_rows(pooled.specimens, "ours", "paper", labels))
    pooled.scores.push_back(std::move(row));
  return pooled;
}

}  // namespace cousin
