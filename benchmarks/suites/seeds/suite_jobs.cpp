#include "benchmarks/suites/seeds/suite_jobs.h"

#include <algorithm>
#include <set>
#include <utility>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/seeds/trained_models.h"

namespace cousin {
namespace {

/// Views of the Gaussians' captures that are photographed twice.
constexpr int kNoiseViews = 4;

RunConfig job_config(const SeedsSuiteConfig& suite, const std::vector<std::string>& own) {
  std::vector<std::string> sets = own;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  return seeds_run_config(sets);
}

/// The user's keys can make jobs equal; the same seeds must not count twice.
void drop_repeated(std::vector<SuiteJob>& jobs) {
  std::set<std::string> seen;
  std::erase_if(jobs, [&](const SuiteJob& job) {
    std::string text =
        resolved_toml(job.config) + std::to_string(job.run) + (job.noise_views > 0 ? "/noise" : "");
    for (const int views : job.view_counts) text += "/" + std::to_string(views);
    return !seen.insert(text + training_text(job.trained, job.config)).second;
  });
}

/// Jobs of a suite as they come together.
struct SeedsJobList {
  const SeedsSuiteConfig& suite;
  std::vector<SuiteJob> jobs = {};

  void add(const std::string& name, int run, const std::vector<std::string>& sets,
           std::vector<int> view_counts, bool pooled, bool attribution,
           const TrainedJob& trained = {}) {
    const RunConfig config = job_config(suite, sets);
    view_counts.push_back(config.scene.views());
    std::sort(view_counts.begin(), view_counts.end());
    view_counts.erase(std::unique(view_counts.begin(), view_counts.end()), view_counts.end());
    std::erase_if(view_counts, [&](int v) { return v > config.scene.views(); });
    // One cultivar a species has pictures, so that the page stays small.
    const std::string& cultivar = seeds_scene(config).cultivar;
    const bool shown =
        pooled && run == 0 && !seeds_scene(config).sphere &&
        (cultivar == "zhengdan958" || cultivar == "jimai22" || cultivar == "suijing18") &&
        seeds_scene(config).spread == SizeSpread::literature;
    jobs.push_back({name + ".json", sets, config, suite.seed, run, view_counts, pooled, attribution,
                    shown, trained});
  }

  void add_noise(const std::string& name, const std::vector<std::string>& sets) {
    SuiteJob job{.name = name + ".json",
                 .sets = sets,
                 .config = job_config(suite, sets),
                 .seed = suite.seed};
    job.noise_views = std::min(kNoiseViews, job.config.scene.views());
    jobs.push_back(std::move(job));
  }

  /// Trainings that need neither the reference's nor ours for surfaces before them.
  void add_alone(const std::string& name, const std::vector<std::string>& sets,
                 TrainedJob trained) {
    trained.splats = true;
    trained.reference = trained.ours = false;
    add(name, 0, sets, {}, false, false, trained);
    jobs.back().only_trained = true;
  }

  void add_posed(const std::string& name, SplatPoses poses, const std::vector<std::string>& same,
                 const TrainedJob& trained) {
    std::vector<std::string> own = same;
    own.push_back("pipeline.splats.poses=" + std::string(to_string(poses)));
    // A user's word about poses is of every job: these would be one of the others.
    const RunConfig before = job_config(suite, same), after = job_config(suite, own);
    if (seeds_pipeline(before).splats.poses != SplatPoses::board ||
        seeds_pipeline(after).splats.poses != poses)
      return;
    add(name + "_" + std::string(to_string(poses)), 0, own, {}, false, false, trained);
    jobs.back().only_trained = true;
  }
};

void add_quick_jobs(SeedsJobList& list) {
  for (const char* cultivar : {"zhengdan958", "jimai22", "suijing18"}) {
    list.add(std::string("quick_") + cultivar, 0,
             {std::string("cultivar=") + cultivar, "rig=phone_video_720p", "views=20"}, {10}, true,
             list.suite.attribution);
  }
  const std::vector<std::string> few = {"cultivar=zhengdan958", "rig=phone_video_720p", "views=20",
                                        "pipeline.splats.reference_steps=1000",
                                        "pipeline.splats.steps=1000"};
  list.add("quick_splats_zhengdan958", 0, few, {}, true, false,
           {.splats = true,
            .reference_at = {500},
            .ours_at = {500},
            .ngp_at = {100, 250},
            .ours_steps = {250},
            .images_steps = {500}});
  list.add_noise("quick_noise_zhengdan958", few);
}

void add_runs(SeedsJobList& list, const std::vector<std::string>& cultivars) {
  const SeedsSuiteConfig& suite = list.suite;
  for (int run = 0; run < suite.runs; ++run) {
    for (const std::string& cultivar : cultivars) {
      list.add(cultivar + "_run" + std::to_string(run), run,
               {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=60"}, {}, true,
               suite.attribution && run == 0);
    }
    if (run > 0) continue;
    list.add("sphere_run0", run, {"sphere=true", "rig=phone_video_1080p", "views=60"}, {}, true,
             false);
    for (const char* cultivar : {"zhengdan958", "jimai22", "suijing18"}) {
      list.add(std::string(cultivar) + "_720p", run,
               {std::string("cultivar=") + cultivar, "rig=phone_video_720p", "views=60"},
               {10, 20, 40}, false, false);
    }
  }
}

void add_trainings(SeedsJobList& list, const std::vector<std::string>& cultivars) {
  for (const std::string& cultivar : cultivars) {
    const std::vector<std::string> own = {"cultivar=" + cultivar, "rig=phone_video_720p",
                                          "views=60"};
    list.add(cultivar + "_splats", 0, own, {}, true, false,
             {.splats = true,
              .reference_at = {500, 1000, 2000, 5000},
              .ours_at = {300, 600},
              .images_steps = {1000, 3000}});
    list.add_alone(cultivar + "_ngp", own, {.ngp_at = {500, 1000, 2000, 5000, 7000}});
    list.add_noise(cultivar + "_noise", own);
  }
  list.add("sphere_splats", 0, {"sphere=true", "rig=phone_video_720p", "views=60"}, {}, true, false,
           {.splats = true});
}

/// One capture's photographs by all, as far as the paper trains.
void add_long_trainings(SeedsJobList& list) {
  const std::vector<std::string> held_out = {"cultivar=zhengdan958", "rig=phone_video_720p",
                                             "views=60", "pipeline.splats.hold_out_every=8"};
  std::vector<std::string> as_long = held_out;
  as_long.emplace_back("pipeline.splats.reference_steps=30000");
  list.add("zhengdan958_splats_30k", 0, as_long, {}, false, false,
           {.splats = true, .ours = false, .reference_at = {500, 1000, 2000, 5000, 7000, 10000}});
  // The same photographs by the others, as far: half an hour to an hour each.
  list.add_alone("zhengdan958_surfaces_30k", held_out,
                 {.ours_steps = {500, 1000, 2000, 5000, 7000, 10000, 30000}});
  list.add_alone("zhengdan958_images_30k", held_out,
                 {.images_steps = {500, 1000, 2000, 3000, 5000, 7000, 10000, 30000}});
  list.add_alone("zhengdan958_ngp_30k", held_out,
                 {.ngp_at = {500, 1000, 2000, 5000, 7000, 10000, 30000}});
}

/// The paper's chain from its first step on, and what our adjustment of the same tracks changes.
void add_posed_trainings(SeedsJobList& list) {
  const std::vector<std::string> small = {"cultivar=zhengdan958", "rig=phone_video_720p",
                                          "views=60"};
  for (const SplatPoses poses : {SplatPoses::sfm, SplatPoses::adjusted})
    list.add_posed("zhengdan958_splats", poses, small, {.splats = true});
  // As many photographs, pixels and steps as the paper has: two hours. Ours by such poses is
  // measured on the small ones.
  list.add_posed("zhengdan958_270views_splats", SplatPoses::sfm,
                 {"cultivar=zhengdan958", "rig=phone_video_1080p", "views=270",
                  "pipeline.splats.reference_steps=30000", "pipeline.splats.most_pixels=6e8"},
                 {.splats = true, .ours = false, .reference_at = {5000, 7000, 10000}});
}

void add_views_and_spread(SeedsJobList& list, const std::vector<std::string>& cultivars) {
  for (const std::string& cultivar : cultivars) {
    list.add(cultivar + "_270views", 0,
             {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=270"}, {120}, false, false);
  }
  for (const std::string& cultivar : cultivars) {
    list.add(cultivar + "_paper_spread", 0,
             {"cultivar=" + cultivar, "rig=phone_video_1080p", "views=60", "spread=paper"}, {},
             true, false);
  }
}

}  // namespace

std::string training_text(const TrainedJob& job, RunConfig config) {
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
  const SeedsPipelineConfig pipeline = seeds_pipeline(config);
  for (const int steps : job.images_steps) {
    seeds_pipeline(config) = pipeline_for_images(pipeline, steps);
    text += "/" + resolved_toml(config);
  }
  return text;
}

std::vector<SuiteJob> seeds_jobs(const SeedsSuiteConfig& suite) {
  SeedsJobList list{suite};
  if (suite.quick) {
    add_quick_jobs(list);
  } else {
    const std::vector<std::string> cultivars = cultivar_names();
    add_runs(list, cultivars);
    add_trainings(list, cultivars);
    add_long_trainings(list);
    add_posed_trainings(list);
    add_views_and_spread(list, cultivars);
  }
  drop_repeated(list.jobs);
  return std::move(list.jobs);
}

}  // namespace cousin
