#include "benchmarks/suites/seeds/suite_jobs.h"

#include <algorithm>
#include <set>
#include <utility>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/seeds/trained_models.h"

namespace cousin {
namespace {

constexpr const char* kSmall = "phone_video_720p";
constexpr const char* kLarge = "phone_video_1080p";
constexpr int kNoiseViews = 4;

/// Captures, and of each level of the factor "work" what is measured on them; one: of all.
struct SeedsBlock {
  GridBlock grid;
  std::vector<SeedsWork> works;
};

RunConfig job_config(const SeedsSuiteConfig& suite, const std::vector<std::string>& own) {
  std::vector<std::string> sets = own;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  return seeds_run_config(sets);
}

Factor one_of_each_species() {
  return key_factor("cultivar", {"zhengdan958", "jimai22", "suijing18"});
}

std::vector<Factor> captures(Factor specimens, const char* rig, int views,
                             const std::vector<Factor>& more = {}) {
  std::vector<Factor> factors = {std::move(specimens), key_factor("rig", {rig}),
                                 key_factor("views", {std::to_string(views)})};
  factors.insert(factors.end(), more.begin(), more.end());
  return factors;
}

/// The same for runs `first` up to and without `end`.
std::vector<Factor> runs(int first, int end, std::vector<Factor> factors) {
  factors.insert(factors.begin(), number_factor("run", first, end));
  return factors;
}

/// Trainings that need neither the reference's nor ours for surfaces before them.
SeedsWork alone(TrainedJob trained) {
  trained.splats = true;
  trained.reference = trained.ours = false;
  return {.trained = std::move(trained), .only_trained = true};
}

std::vector<SeedsBlock> quick_blocks(const SeedsSuiteConfig& suite) {
  const std::vector<Factor> few = {key_factor("pipeline.splats.reference_steps", {"1000"}),
                                   key_factor("pipeline.splats.steps", {"1000"}),
                                   named_factor("work", {"splats", "noise"})};
  return {
      {{"quick_{cultivar}", captures(one_of_each_species(), kSmall, 20)},
       {{.view_counts = {10}, .pooled = true, .attribution = suite.attribution}}},
      {{"quick_{work}_{cultivar}",
        captures(key_factor("cultivar", {"zhengdan958"}), kSmall, 20, few)},
       {{.pooled = true,
         .trained = {.splats = true,
                     .reference_at = {500},
                     .ours_at = {500},
                     .ngp_at = {100, 250},
                     .ours_steps = {250},
                     .images_steps = {500}}},
        {.noise_views = kNoiseViews}}},
  };
}

std::vector<SeedsBlock> run_blocks(const SeedsSuiteConfig& suite) {
  const std::vector<Factor> all = captures(key_factor("cultivar", cultivar_names()), kLarge, 60);
  return {
      {{"{cultivar}_run{run}", runs(0, 1, all)},
       {{.pooled = true, .attribution = suite.attribution}}},
      {{"sphere_run0", captures(key_factor("sphere", {"true"}), kLarge, 60)}, {{.pooled = true}}},
      {{"{cultivar}_720p", captures(one_of_each_species(), kSmall, 60)},
       {{.view_counts = {10, 20, 40}}}},
      {{"{cultivar}_run{run}", runs(1, suite.runs, all)}, {{.pooled = true}}},
  };
}

std::vector<SeedsBlock> training_blocks() {
  return {
      {{"{cultivar}_{work}", captures(key_factor("cultivar", cultivar_names()), kSmall, 60,
                                      {named_factor("work", {"splats", "ngp", "noise"})})},
       {{.pooled = true,
         .trained = {.splats = true,
                     .reference_at = {500, 1000, 2000, 5000},
                     .ours_at = {300, 600},
                     .images_steps = {1000, 3000}}},
        alone({.ngp_at = {500, 1000, 2000, 5000, 7000}}),
        {.noise_views = kNoiseViews}}},
      {{"sphere_splats", captures(key_factor("sphere", {"true"}), kSmall, 60)},
       {{.pooled = true, .trained = {.splats = true}}}},
  };
}

/// One capture's photographs by all, as far as the paper trains: half an hour to an hour each.
std::vector<SeedsBlock> long_blocks() {
  const Factor one = key_factor("cultivar", {"zhengdan958"});
  const Factor held_out = key_factor("pipeline.splats.hold_out_every", {"8"});
  return {
      {{"{cultivar}_splats_30k",
        captures(one, kSmall, 60,
                 {held_out, key_factor("pipeline.splats.reference_steps", {"30000"})})},
       {{.trained = {.splats = true,
                     .ours = false,
                     .reference_at = {500, 1000, 2000, 5000, 7000, 10000}}}}},
      {{"{cultivar}_{work}_30k",
        captures(one, kSmall, 60, {held_out, named_factor("work", {"surfaces", "images", "ngp"})})},
       {alone({.ours_steps = {500, 1000, 2000, 5000, 7000, 10000, 30000}}),
        alone({.images_steps = {500, 1000, 2000, 3000, 5000, 7000, 10000, 30000}}),
        alone({.ngp_at = {500, 1000, 2000, 5000, 7000, 10000, 30000}})}},
  };
}

/// The paper's chain from its first step on, and what our adjustment of the same tracks changes.
/// With as many photographs, pixels and steps as the paper has it takes two hours; ours by such
/// poses is measured on the small ones.
std::vector<SeedsBlock> posed_blocks(const SeedsSuiteConfig& suite) {
  // A user's word about poses is of every job: these would be one of the others.
  const auto is_as_named = [&suite](const GridJob& job) {
    const RunConfig plain = job_config(suite, {}), own = job_config(suite, job.sets);
    return seeds_pipeline(plain).splats.poses == SplatPoses::board &&
           to_string(seeds_pipeline(own).splats.poses) == job.at("pipeline.splats.poses").word;
  };
  const Factor one = key_factor("cultivar", {"zhengdan958"});
  return {
      {{"{cultivar}_splats_{pipeline.splats.poses}",
        captures(one, kSmall, 60, {key_factor("pipeline.splats.poses", {"sfm", "adjusted"})}),
        is_as_named},
       {{.trained = {.splats = true}, .only_trained = true}}},
      {{"{cultivar}_{views}views_splats_{pipeline.splats.poses}",
        captures(one, kLarge, 270,
                 {key_factor("pipeline.splats.reference_steps", {"30000"}),
                  key_factor("pipeline.splats.most_pixels", {"6e8"}),
                  key_factor("pipeline.splats.poses", {"sfm"})}),
        is_as_named},
       {{.trained = {.splats = true, .ours = false, .reference_at = {5000, 7000, 10000}},
         .only_trained = true}}},
  };
}

std::vector<SeedsBlock> spread_blocks() {
  const Factor all = key_factor("cultivar", cultivar_names());
  return {
      {{"{cultivar}_{views}views", captures(all, kLarge, 270)}, {{.view_counts = {120}}}},
      {{"{cultivar}_{spread}_spread", captures(all, kLarge, 60, {key_factor("spread", {"paper"})})},
       {{.pooled = true}}},
  };
}

std::vector<SeedsBlock> seeds_blocks(const SeedsSuiteConfig& suite) {
  if (suite.quick) return quick_blocks(suite);
  std::vector<SeedsBlock> blocks;
  for (const auto& some :
       {run_blocks(suite), training_blocks(), long_blocks(), posed_blocks(suite), spread_blocks()})
    blocks.insert(blocks.end(), some.begin(), some.end());
  return blocks;
}

SuiteJob seeds_job(const SeedsSuiteConfig& suite, GridJob place, SeedsWork work) {
  const int run = place.has("run") ? place.number("run") : 0;
  RunConfig config = job_config(suite, place.sets);
  SuiteJob job{std::move(place), std::move(config), suite.seed, run, std::move(work)};
  const int views = job.config.scene.views();
  std::vector<int>& counts = job.work.view_counts;
  if (job.work.noise_views > 0) {
    job.work.noise_views = std::min(job.work.noise_views, views);
  } else {
    counts.push_back(views);
    std::sort(counts.begin(), counts.end());
    counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
    std::erase_if(counts, [&](int v) { return v > views; });
  }
  // One cultivar a species has pictures, so that the page stays small.
  const std::string& cultivar = seeds_scene(job.config).cultivar;
  job.shown = job.work.pooled && run == 0 && !seeds_scene(job.config).sphere &&
              (cultivar == "zhengdan958" || cultivar == "jimai22" || cultivar == "suijing18") &&
              seeds_scene(job.config).spread == SizeSpread::literature;
  return job;
}

/// The user's keys can make jobs equal; the same seeds must not count twice.
void drop_repeated(std::vector<SuiteJob>& jobs) {
  std::set<std::string> seen;
  std::erase_if(jobs, [&](const SuiteJob& job) {
    std::string text = resolved_toml(job.config) + std::to_string(job.run) +
                       (job.work.noise_views > 0 ? "/noise" : "");
    for (const int views : job.work.view_counts) text += "/" + std::to_string(views);
    return !seen.insert(text + training_text(job.work.trained, job.config)).second;
  });
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
  const std::vector<SeedsBlock> blocks = seeds_blocks(suite);
  Grid grid;
  for (const SeedsBlock& block : blocks) grid.push_back(block.grid);
  std::vector<SuiteJob> jobs;
  for (GridJob& place : jobs_of(grid)) {
    const std::vector<SeedsWork>& works = blocks[place.block].works;
    const std::size_t work = place.has("work") ? place.at("work").level : 0;
    jobs.push_back(seeds_job(suite, std::move(place), works.at(work)));
  }
  drop_repeated(jobs);
  return jobs;
}

}  // namespace cousin
