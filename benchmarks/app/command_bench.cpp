// bench and report: the suites and their pages.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <thread>

#include "benchmarks/app/bench_output.h"
#include "benchmarks/app/commands.h"
#include "benchmarks/calibration/calibration_suite.h"
#include "benchmarks/calibration/studies.h"
#include "benchmarks/plants/plants_suite.h"
#include "benchmarks/program/program_suite.h"
#include "benchmarks/real/real_report.h"
#include "benchmarks/real/real_suite.h"
#include "benchmarks/render/render_suite.h"
#include "benchmarks/renderers/renderers_page.h"
#include "benchmarks/renderers/renderers_suite.h"
#include "benchmarks/scenes/scenes_suite.h"
#include "benchmarks/seedlings/seedlings_page.h"
#include "benchmarks/seedlings/seedlings_suite.h"
#include "benchmarks/seeds/cousins_suite.h"
#include "benchmarks/seeds/result_folder.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/seeds_report.h"
#include "benchmarks/seeds/suite.h"
#include "benchmarks/seeds/trained_plots.h"
#include "benchmarks/sensors/sensors_page.h"
#include "benchmarks/sensors/sensors_suite.h"
#include "benchmarks/sfm/sfm_suite.h"
#include "benchmarks/shards/shard_scores.h"
#include "benchmarks/splats/splats_page.h"
#include "benchmarks/splats/splats_suite.h"
#include "benchmarks/stability/suite.h"
#include "perception/sfm/colmap_run.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// Folder of trainings that were stopped, below a suite's.
constexpr const char* kUnfinished = "unfinished";

/// Plots and tables that suites make of their rows: on the page at once, and again from the tables
/// alone.
void add_plots(SeedsReport& report) {
  report.curves = renderers_curves(report.scores.scores);
  report.lines = sensors_plots(report.scores.scores);
  for (LinePlot& plot : cousins_plots(report.scores.scores))
    report.lines.push_back(std::move(plot));
  for (LinePlot& plot : study_plots(report.scores.scores)) report.lines.push_back(std::move(plot));
  for (ErrorTimeCurve& curve : study_times(report.scores.scores))
    report.curves.push_back(std::move(curve));
  for (ErrorTimeCurve& curve : splats_curves(report.scores.scores))
    report.curves.push_back(std::move(curve));
  for (LinePlot& plot : trained_plots(report.scores.scores))
    report.lines.push_back(std::move(plot));
  for (LinePlot& plot : seedlings_plots(report.scores.scores))
    report.lines.push_back(std::move(plot));
  for (ErrorTimeCurve& curve : seedlings_curves(report.scores.scores))
    report.curves.push_back(std::move(curve));
  report.tables = papers_tables(report.scores.scores);
}

/// Keeps pictures for the page and notes which it shows.
void keep_scene(SeedsReport& report, const ReportScene& scene, const fs::path& out) {
  if (scene.pictures.empty()) return;
  write_report_scene(report_scenes_folder(out), scene);
  report.scores.header.more["scenes"] = scene.name;
  report.scenes = {scene};
}

/// Heads the tables, writes them and the page.
ScoreFile finish(SeedsReport report, const JobContext& context, const fs::path& out) {
  add_plots(report);
  ScoreHeader& header = report.scores.header;
  header.program_version = COUSIN_VERSION;
  if (header.machine.empty()) header.machine = machine_text();
  const auto& rows = report.scores.scores;
  const bool is_by_colmap = std::any_of(rows.begin(), rows.end(), [](const ScoreRow& row) {
    return row.suite == "sfm" || row.suite == "splats" || is_posed_by_tracks(row);
  });
  if (is_by_colmap) header.more["colmap"] = colmap_version();
  header.more["command"] = report.command_line = context.command_line;
  header.more["title"] = report.title;
  header.more["summary"] = report.summary;
  write_report_folder(out, report);
  context.progress.line("scores: " + (out / "scores.csv").string() +
                        ", report: " + (out / "report.html").string());
  return report.scores;
}

constexpr const char* kRealTitle = "Cousin: bench real";
constexpr const char* kAgreementOnly =
    "Real captures: nobody measured the specimens, so this is agreement, not accuracy.";

SeedsReport titled(const char* title, const char* summary, ScoreFile scores) {
  SeedsReport report;
  report.title = title;
  report.summary = summary;
  report.scores = std::move(scores);
  return report;
}

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
  const auto results = run_shards(
      out / "shards", with_machine(jobs_named(jobs, context.options.only)),
      parse_shard(context.options.shard), [&](const std::string& name, int done, int total) {
        context.progress.line("job " + std::to_string(done + 1) + " of " + std::to_string(total) +
                              ": " + name);
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

void note_missing(const JobContext& context, const std::vector<ShardResult>& results,
                  SeedsReport& report) {
  const auto missing = std::count_if(results.begin(), results.end(), is_missing);
  if (missing == 0) return;
  const std::string note =
      std::to_string(missing) + " of " + std::to_string(results.size()) + " jobs are not there yet";
  context.progress.line(note);
  report.scores.header.more["note"] = note;
}

/// The pictures of the jobs on this page: a --quick run and a full one share the folder.
void show_scenes(const std::vector<ShardResult>& results, const fs::path& folder,
                 SeedsReport& report) {
  std::set<std::string> shown;
  for (const ShardResult& result : results) {
    if (!result.text.empty()) shown.insert(fs::path(result.name).stem());
  }
  report.scenes =
      read_report_scenes(folder, [&](const std::string& name) { return shown.contains(name); });
  std::string& names = report.scores.header.more["scenes"];
  for (const ReportScene& scene : report.scenes) names += (names.empty() ? "" : " ") + scene.name;
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
  const auto results = run_jobs(context, out, list_splats(context, out));
  SeedsReport report =
      titled("Cousin: bench splats",
             "Gaussian splatting on a CPU: core time of each blended pair, wall time of a training "
             "step, and held-out PSNR against wall time on photographs that are not Cousin's.",
             scores_of_shards(results, "splats", context.options.seed));
  note_missing(context, results, report);
  return finish(std::move(report), context, out);
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
  const auto results = run_jobs(context, out, list_sfm(context, out));
  SeedsReport report =
      titled("Cousin: bench sfm",
             "Poses by COLMAP 3.8 before and after our adjustment, against exact ones. COLMAP's "
             "results vary with its threads, whose number is fixed here, and with its build.",
             scores_of_shards(results, "sfm", context.options.seed));
  note_missing(context, results, report);
  return finish(std::move(report), context, out);
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

struct Suite {
  const char* name;
  ScoreFile (*run)(const JobContext&, const fs::path&);
  std::array<std::string_view, 8> takes;  ///< the options that it reads, of those not all do
  /// What it runs in jobs; null: it does not, and has no --list.
  std::vector<ShardJob> (*jobs)(const JobContext&, const fs::path&) = nullptr;
};
constexpr std::array<Suite, 14> kSuites = {
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

/// The jobs that suites would run, one a line, with what --out holds of them.
void print_jobs(const JobContext& context, const std::vector<const Suite*>& suites,
                const fs::path& folder) {
  nlohmann::json list = nlohmann::json::array();
  std::string lines;
  for (const Suite* suite : suites) {
    if (suite->jobs == nullptr) continue;
    const fs::path out = folder / suite->name;
    const std::vector<ShardJob> jobs = jobs_named(suite->jobs(context, out), context.options.only);
    const auto [first, end] =
        shard_range(parse_shard(context.options.shard), static_cast<int>(jobs.size()));
    for (int i = first; i < end; ++i) {
      const ShardJob& job = jobs[static_cast<std::size_t>(i)];
      const bool is_begun = !job.unfinished.empty() && fs::exists(job.unfinished);
      const std::string state = is_finished(out / "shards", job) ? "finished"
                                : is_begun                       ? "begun"
                                                                 : "";
      list.push_back({{"suite", suite->name}, {"job", job.name}, {"state", state}});
      lines +=
          std::string(suite->name) + " " + job.name + (state.empty() ? "" : " ") + state + "\n";
    }
  }
  std::printf("%s", context.options.json ? (list.dump(2) + "\n").c_str() : lines.c_str());
}

/// @throws std::invalid_argument naming an option that is given and that the suite does not read.
void check_takes(const Suite& suite, const Options& o) {
  const std::pair<std::string_view, bool> given[] = {{"--quick", o.quick},
                                                     {"--set", !o.sets.empty()},
                                                     {"--captures", !o.captures.empty()},
                                                     {"--shard", !o.shard.empty()},
                                                     {"--only", !o.only.empty()},
                                                     {"--list", o.list},
                                                     {"--lpips", !o.lpips.empty()},
                                                     {"--runs", o.runs > 0},
                                                     {"--attribution", o.attribution}};
  for (const auto& [option, is_given] : given) {
    const bool is_taken = option == "--list" ? suite.jobs != nullptr
                                             : std::find(suite.takes.begin(), suite.takes.end(),
                                                         option) != suite.takes.end();
    if (!is_given || is_taken) continue;
    throw std::invalid_argument("suite \"" + std::string(suite.name) + "\" takes no " +
                                std::string(option));
  }
}

}  // namespace

ExitCode command_bench(const JobContext& context) {
  const Options& o = context.options;
  std::vector<std::string> names = o.arguments;
  if (names.empty() && (!o.only.empty() || !o.shard.empty())) {
    throw std::invalid_argument(std::string(o.only.empty() ? "--shard" : "--only") +
                                " is of the suites that run in jobs: name the suite");
  }
  if (names.empty()) {
    for (const Suite& suite : kSuites) names.emplace_back(suite.name);
  }
  std::vector<const Suite*> wanted;
  for (const std::string& name : names) {
    const auto suite = std::find_if(kSuites.begin(), kSuites.end(),
                                    [&](const Suite& s) { return name == s.name; });
    if (suite == kSuites.end()) {
      std::string all;
      for (const Suite& other : kSuites) all += (all.empty() ? "" : ", ") + std::string(other.name);
      throw std::invalid_argument("suite \"" + name + "\" is not one of " + all);
    }
    if (!o.arguments.empty()) check_takes(*suite, o);
    wanted.push_back(&*suite);
  }
  SeedsRunConfig config = seeds_run_config(o.sets);  // a wrong key ends here, not hours later
  if (o.keys) {
    std::printf("%s", describe(fields(config)).c_str());
    return ExitCode::done;
  }
  parse_shard(o.shard);
  const fs::path folder = o.out.empty() ? fs::path("out") / "bench" : fs::path(o.out);
  if (o.list) {
    print_jobs(context, wanted, folder);
    return ExitCode::done;
  }
  for (const Suite* suite : wanted) require_writable(folder / suite->name);
  if (!o.captures.empty()) require_writable(o.captures);
  bool failed = false;
  const bool list = o.json && wanted.size() > 1;
  for (const Suite* suite : wanted) {
    const fs::path out = folder / suite->name;
    const ScoreFile file = suite->run(context, out);
    if (o.json) {
      if (list) std::printf("%s", suite == wanted.front() ? "[" : ",");
      std::printf("%s", to_json(file).c_str());
      if (list && suite == wanted.back()) std::printf("]\n");
    } else if (std::string_view(suite->name) == "seeds") {
      std::printf("%s", summary_table(file.scores).c_str());
      print_papers_tables(file.scores);
    } else if (std::string_view(suite->name) == "seedlings") {
      print_papers_tables(file.scores);
    } else {
      print_scores(file.scores);
    }
    failed = failed || std::any_of(file.scores.begin(), file.scores.end(), [](const ScoreRow& row) {
               return row.status == ScoreStatus::fail || row.status == ScoreStatus::error;
             });
  }
  return failed ? ExitCode::gate_failed : ExitCode::done;
}

ExitCode command_report(const JobContext& context) {
  const fs::path folder = context.options.arguments.at(0);
  SeedsReport report = read_report_folder(folder);
  add_plots(report);
  if (context.options.out.empty() && report.title == kRealTitle) {
    throw std::invalid_argument(folder.string() +
                                ": the page of `bench real` shows pictures that only that command "
                                "makes; give --out to have its tables alone on another page");
  }
  const fs::path file = context.options.out.empty() ? folder / "report.html"
                                                    : fs::path(context.options.out) / "report.html";
  write_report(file, report);
  if (context.options.json) {
    std::printf("%s\n", nlohmann::json{{"report", file.string()}}.dump(2).c_str());
  }
  context.progress.line("report: " + file.string());
  return ExitCode::done;
}

}  // namespace cousin
