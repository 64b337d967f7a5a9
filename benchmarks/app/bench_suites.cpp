// The suites: configuration, jobs and page of each.
#include "benchmarks/app/bench_suites.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "benchmarks/app/bench_page.h"
#include "benchmarks/app/suite_plots.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/calibration/calibration_suite.h"
#include "benchmarks/suites/calibration/studies.h"
#include "benchmarks/suites/plants/plants_suite.h"
#include "benchmarks/suites/program/program_suite.h"
#include "benchmarks/suites/real/real_report.h"
#include "benchmarks/suites/real/real_suite.h"
#include "benchmarks/suites/render/render_suite.h"
#include "benchmarks/suites/renderers/renderers_suite.h"
#include "benchmarks/suites/scenes/scenes_suite.h"
#include "benchmarks/suites/seedlings/seedlings_suite.h"
#include "benchmarks/suites/seeds/cousins_suite.h"
#include "benchmarks/suites/seeds/suite.h"
#include "benchmarks/suites/sensors/sensors_page.h"
#include "benchmarks/suites/sensors/sensors_suite.h"
#include "benchmarks/suites/sfm/sfm_suite.h"
#include "benchmarks/suites/splats/splats_suite.h"
#include "benchmarks/suites/stability/suite.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// Folder of trainings that were stopped, below a suite's.
constexpr const char* kUnfinished = "unfinished";

constexpr const char* kAgreementOnly =
    "Real captures: nobody measured the specimens, so this is agreement, not accuracy.";

/// Jobs whose results say which machine they were run on: kept ones may be of several.
std::vector<ShardJob> with_machine(std::vector<ShardJob> jobs) {
  for (ShardJob& job : jobs) {
    job.run = [run = std::move(job.run), name = job.name] {
      ScoreFile file = scores_from_json(run(), name);
      file.header.machine = machine_text();
      return to_json(file);
    };
  }
  return jobs;
}

/// Runs a suite's jobs that `out` holds no result of; says which were there and which failed. Their
/// results are scores.json.
std::vector<ShardResult> run_jobs(const JobContext& context, const fs::path& out,
                                  const std::vector<ShardJob>& jobs) {
  const std::vector<ShardJob> chosen = with_machine(jobs_named(jobs, context.options.only));
  const auto finished = std::count_if(chosen.begin(), chosen.end(), [&](const ShardJob& job) {
    return is_finished(out / "shards", job);
  });
  if (finished > 0)
    context.progress.line(std::to_string(finished) + " of " + std::to_string(chosen.size()) +
                          " jobs are there already: " + (out / "shards").string());
  StepClock clock;
  const auto results = run_shards(out / "shards", chosen, parse_shard(context.options.shard),
                                  [&](const std::string& name, int done, int total) {
                                    context.progress.line("job " + std::to_string(done + 1) +
                                                          " of " + std::to_string(total) +
                                                          clock.text(done, total) + ": " + name);
                                  });
  const auto reused =
      std::count_if(results.begin(), results.end(), [](const ShardResult& r) { return r.reused; });
  if (reused > 0) {
    context.progress.line(std::to_string(reused) + " of " + std::to_string(results.size()) +
                          " jobs taken from " + (out / "shards").string() +
                          "; another --out measures them again");
  }
  for (const ShardResult& result : results) {
    if (!result.error.empty()) context.progress.line(result.name + " failed: " + result.error);
  }
  return results;
}

/// A suite whose rows are those of its jobs and no more.
ScoreFile bench_jobs(const JobContext& context, const fs::path& out, const char* suite,
                     const std::vector<ShardJob>& jobs, const char* summary) {
  const auto results = run_jobs(context, out, jobs);
  SeedsReport report = titled((std::string("Cousin: bench ") + suite).c_str(), summary,
                              scores_of_shards(results, suite, context.options.seed));
  note_missing(context, results, report);
  return finish(std::move(report), context, out);
}

SeedsSuiteConfig seeds_config(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  SeedsSuiteConfig config;
  config.seed = o.seed;
  config.quick = o.quick;
  if (o.runs > 0) config.runs = o.runs;
  config.attribution = o.attribution;
  config.sets = o.sets;
  config.captures = o.captures;
  config.lpips = o.lpips;
  config.report = report_scenes_folder(out);
  config.unfinished = out / kUnfinished;
  return config;
}

std::vector<ShardJob> list_seeds(const JobContext& context, const fs::path& out) {
  return seeds_suite_jobs(seeds_config(context, out), context.progress.function());
}

ScoreFile bench_seeds(const JobContext& context, const fs::path& out) {
  const SeedsSuiteConfig config = seeds_config(context, out);
  const auto results = run_jobs(context, out, list_seeds(context, out));
  SeedsReport report =
      titled("Cousin: bench seeds", kMeasuredAgainstTruth, pool_seeds_suite(results, config));
  note_missing(context, results, report);
  report.config_toml = suite_toml(config);
  show_scenes(results, config.report, report);
  return finish(std::move(report), context, out);
}

ScoreFile bench_stability(const JobContext& context, const fs::path& out) {
  return finish(titled("Cousin: bench stability",
                       "Stiff and extreme cases, each held to theory or to a measured value.",
                       stability_suite(context.options.quick, context.progress.function())),
                context, out);
}

ScoreFile bench_render(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  SeedsReport report =
      titled("Cousin: bench render",
             "The renderer beside Embree alone, its noise beside the sensor's, its corners beside "
             "where they project.",
             render_suite(o.seed, o.sets, o.quick, context.progress.function()));
  report.config_toml = resolved_toml(seeds_run_config(o.sets));
  return finish(std::move(report), context, out);
}

std::vector<ShardJob> list_sensors(const JobContext& context, const fs::path&) {
  return sensors_suite_jobs(context.options.seed, context.options.quick);
}

ScoreFile bench_sensors(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  const auto results = run_jobs(context, out, list_sensors(context, out));
  SeedsReport report =
      titled("Cousin: bench sensors",
             "Every sensor model against theory or the published figure. Verified against theory "
             "only: no real device has been compared with the models.",
             scores_of_shards(results, "sensors", o.seed));
  note_missing(context, results, report);
  keep_scene(report, sensors_pictures(o.seed), out);
  return finish(std::move(report), context, out);
}

ScoreFile bench_renderers(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  RenderersConfig config;
  config.seed = o.seed;
  config.folder = fs::absolute(out);
  config.threads =
      o.threads > 0 ? o.threads : static_cast<int>(std::thread::hardware_concurrency());
  if (o.quick) config = quick(config);
  RenderersResult result = renderers_suite(config, context.progress.function());
  const char* summary =
      o.quick ? "The path tracer beside closed forms and beside Cycles: agreement, error against "
                "time. Cross-checked with Cycles; errors are the noise between two images of each."
              : "The path tracer beside closed forms and beside Cycles: agreement, error against "
                "time. Cross-checked with Cycles; errors are each renderer's own, against its own "
                "converged image.";
  SeedsReport report = titled("Cousin: bench renderers", summary, std::move(result.file));
  report.config_toml = to_toml(fields(config));
  keep_scene(report, result.pictures, out);
  return finish(std::move(report), context, out);
}

CousinsSuiteConfig cousins_config(const Options& o) {
  CousinsSuiteConfig config;
  config.seed = o.seed;
  config.quick = o.quick;
  config.sets = o.sets;
  return config;
}

std::vector<ShardJob> list_cousins(const JobContext& context, const fs::path&) {
  return cousins_suite_jobs(cousins_config(context.options), context.progress.function());
}

ScoreFile bench_cousins(const JobContext& context, const fs::path& out) {
  const CousinsSuiteConfig config = cousins_config(context.options);
  const auto results = run_jobs(context, out, list_cousins(context, out));
  SeedsReport report =
      titled("Cousin: bench cousins",
             "The seeds' errors on scenes that differ from the reference along one axis at a time: "
             "shape, growth, texture, light, sensor. Ranges are free: they say what was tried, not "
             "what is found in the world.",
             pool_cousins_suite(results, config));
  note_missing(context, results, report);
  report.config_toml = cousins_toml(config);
  return finish(std::move(report), context, out);
}

ScoreFile bench_real(const JobContext& context, const fs::path& out) {
  RealResult result =
      real_suite(COUSIN_REAL_DATA, out, context.options.quick, context.progress.function());
  result.file = finish(titled(kRealTitle, kAgreementOnly, std::move(result.file)), context, out);
  write_real_report(out / "report.html", result, context.command_line);  // with its pictures
  return result.file;
}

ScoreFile bench_program(const JobContext& context, const fs::path& out) {
  return finish(
      titled("Cousin: bench program", "The program as a user meets it, in a process of its own.",
             program_suite(fs::read_symlink("/proc/self/exe"), out, context.progress.function())),
      context, out);
}

ScoreFile bench_scenes(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  return finish(titled("Cousin: bench scenes",
                       "What plant scenes cost and what grows in them. Their sizes are free: the "
                       "traits are printed, not held to a population.",
                       scenes_suite(o.seed, o.quick, context.progress.function())),
                context, out);
}

ScoreFile bench_plants(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  return finish(
      titled("Cousin: bench plants",
             "Fruits and trusses: sizes beside the published ones, red shares, seconds to build, "
             "overlaps at rest. Verified against theory and publications only.",
             plants_suite(o.seed, o.quick, context.progress.function())),
      context, out);
}

std::vector<ShardJob> list_splats(const JobContext& context, const fs::path&) {
  const Options& o = context.options;
  SplatsSuiteConfig config;
  config.photographs =
      (fs::path(COUSIN_REAL_DATA) / ".." / "data" / "splat_neutral").lexically_normal();
  config.fox = fs::path(COUSIN_REAL_DATA) / "multiview/instantngp_fox/transforms.json";
  config.chair = fs::path(COUSIN_REAL_DATA) / "multiview/boofcv_chair";
  config.seed = o.seed;
  config.quick = o.quick;
  return splats_jobs(config);
}

ScoreFile bench_splats(const JobContext& context, const fs::path& out) {
  return bench_jobs(
      context, out, "splats", list_splats(context, out),
      "Gaussian splatting on a CPU: core time of each blended pair, wall time of a training "
      "step, and held-out PSNR against wall time on photographs that are not Cousin's.");
}

StudiesConfig studies_config(const Options& o) {
  StudiesConfig config;
  config.seed = o.seed;
  config.quick = o.quick;
  if (o.runs > 0) config.runs = o.runs;
  return config;
}

std::vector<ShardJob> list_calibration(const JobContext& context, const fs::path&) {
  const Options& o = context.options;
  const std::string verified = o.quick ? "verified.quick.json" : "verified.json";
  std::vector<ShardJob> jobs = study_jobs(studies_config(o));
  jobs.insert(
      jobs.begin(),
      {verified, std::string(COUSIN_VERSION) + "/" + std::to_string(o.seed) + "/" + verified,
       [&] { return to_json(calibration_suite(o.seed, o.quick, context.progress.function())); }});
  return jobs;
}

ScoreFile bench_calibration(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  const auto results = run_jobs(context, out, list_calibration(context, out));
  ScoreFile scores = scores_of_shards(results, "calibration", o.seed);
  std::vector<ScoreRow> studies = study_rows(scores.scores, studies_config(o));
  scores.scores.insert(scores.scores.end(), studies.begin(), studies.end());
  SeedsReport report =
      titled("Cousin: bench calibration",
             "What a calibration is worth. Solvers on the same corners, predicted intervals and "
             "seconds are on computed corners with normal noise: verified, and cross-checked with "
             "OpenCV and mrcal. The studies photograph boards through a sensor's model, find them "
             "and hold the lens found against the true one.",
             std::move(scores));
  note_missing(context, results, report);
  return finish(std::move(report), context, out);
}

std::vector<ShardJob> list_sfm(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  SfmSuiteConfig config;
  config.seed = o.seed;
  config.quick = o.quick;
  config.folder = fs::absolute(out / "colmap");
  config.neutral = fs::path(COUSIN_REAL_DATA) / ".." / "data" / "splat_neutral";
  return sfm_suite_jobs(config, context.progress.function());
}

ScoreFile bench_sfm(const JobContext& context, const fs::path& out) {
  return bench_jobs(
      context, out, "sfm", list_sfm(context, out),
      "Poses by COLMAP 3.8 before and after our adjustment, against exact ones. COLMAP's "
      "results vary with its threads, whose number is fixed here, and with its build.");
}

SeedlingsSuiteConfig seedlings_config(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  SeedlingsSuiteConfig config;
  config.seed = o.seed;
  config.quick = o.quick;
  if (o.runs > 0) config.samples = o.runs;
  config.lpips = o.lpips;
  config.report = report_scenes_folder(out);
  config.unfinished = out / kUnfinished;
  return config;
}

std::vector<ShardJob> list_seedlings(const JobContext& context, const fs::path& out) {
  return seedlings_suite_jobs(seedlings_config(context, out));
}

ScoreFile bench_seedlings(const JobContext& context, const fs::path& out) {
  const SeedlingsSuiteConfig config = seedlings_config(context, out);
  const auto results = run_jobs(context, out, list_seedlings(context, out));
  SeedsReport report = titled(
      "Cousin: bench seedlings",
      "Trays of watermelon seedlings under three lights, reconstructed from hand-held "
      "photographs with exact poses: how well Gaussians and a radiance field show the views "
      "they were trained on and others, over the time they took and over what the views "
      "cover. Published numbers are the Seedlings paper's tables 2 to 4: other plants, other "
      "photographs, a graphics card; its PSNR is taken to be of views trained on.",
      pool_seedlings_suite(results, config));
  note_missing(context, results, report);
  report.config_toml = seedlings_toml(config);
  show_scenes(results, config.report, report);
  return finish(std::move(report), context, out);
}

constexpr std::array<BenchSuite, 14> kSuites = {
    {{"stability", bench_stability, {"--quick"}},
     {"render", bench_render, {"--quick", "--set"}},
     {"renderers", bench_renderers, {"--quick"}},
     {"sensors", bench_sensors, {"--quick", "--shard", "--only"}, list_sensors},
     {"seeds",
      bench_seeds,
      {"--quick", "--set", "--captures", "--shard", "--only", "--attribution", "--runs", "--lpips"},
      list_seeds},
     {"seedlings",
      bench_seedlings,
      {"--quick", "--shard", "--only", "--runs", "--lpips"},
      list_seedlings},
     {"cousins", bench_cousins, {"--quick", "--set", "--shard", "--only"}, list_cousins},
     {"scenes", bench_scenes, {"--quick"}},
     {"plants", bench_plants, {"--quick"}},
     {"splats", bench_splats, {"--quick", "--shard", "--only"}, list_splats},
     {"calibration",
      bench_calibration,
      {"--quick", "--shard", "--only", "--runs"},
      list_calibration},
     {"sfm", bench_sfm, {"--quick", "--shard", "--only"}, list_sfm},
     {"real", bench_real, {"--quick"}},
     {"program", bench_program, {}}}};

}  // namespace

std::span<const BenchSuite> bench_suites() { return kSuites; }

}  // namespace cousin
