// Runs a suite: its jobs, its page.
#include "benchmarks/app/bench_suites.h"

#include <algorithm>
#include <string>
#include <utility>

#include "benchmarks/app/suite_plots.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "perception/sfm/colmap_run.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

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

/// Says on the terminal and on the page how many jobs have no result yet, if any.
void note_missing(const JobContext& context, const std::vector<ShardResult>& results,
                  SeedsReport& report) {
  const auto missing = std::count_if(results.begin(), results.end(), is_missing);
  if (missing == 0) return;
  const std::string note =
      std::to_string(missing) + " of " + std::to_string(results.size()) + " jobs are not there yet";
  context.progress.line(note);
  report.scores.header.more["note"] = note;
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

}  // namespace

SuiteRun suite_run(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  return {.out = out,
          .real_data = COUSIN_REAL_DATA,
          .seed = o.seed,
          .quick = o.quick,
          .runs = o.runs,
          .threads = o.threads,
          .sets = o.sets,
          .attribution = o.attribution,
          .captures = o.captures,
          .lpips = o.lpips,
          .command_line = context.command_line,
          .progress = context.progress.function()};
}

ScoreFile run_suite(const BenchSuite& suite, const JobContext& context, const fs::path& out) {
  const SuiteRun run = suite_run(context, out);
  std::vector<ShardResult> results;
  if (suite.jobs != nullptr) results = run_jobs(context, out, suite.jobs(run));
  SuitePage page = suite.page != nullptr
                       ? suite.page(run, results)
                       : suite_page(scores_of_shards(results, suite.name, run.seed));
  page.report.title = "Cousin: bench " + suite.name;
  if (page.report.summary.empty()) page.report.summary = suite.help;
  if (suite.limits != nullptr) suite.limits(run, page.report.scores);
  note_missing(context, results, page.report);
  const ScoreFile scores = finish(std::move(page.report), context, out);
  if (page.write_own) page.write_own(scores);
  return scores;
}

}  // namespace cousin
