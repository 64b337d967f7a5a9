// bench: runs suites and says what they found.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/bench_output.h"
#include "benchmarks/app/bench_suites.h"
#include "benchmarks/app/commands.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/seeds_run.h"
#include "sim/dataset/output_folder.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// The jobs that suites would run, one a line, with what --out holds of them.
void print_jobs(const JobContext& context, const std::vector<const BenchSuite*>& suites,
                const fs::path& folder) {
  nlohmann::json list = nlohmann::json::array();
  std::string lines;
  for (const BenchSuite* suite : suites) {
    if (suite->jobs == nullptr) continue;
    const fs::path out = folder / suite->name;
    const std::vector<ShardJob> jobs =
        jobs_named(suite->jobs(suite_run(context, out)), context.options.only);
    const auto [first, end] =
        shard_range(parse_shard(context.options.shard), static_cast<int>(jobs.size()));
    for (int i = first; i < end; ++i) {
      const ShardJob& job = jobs[static_cast<std::size_t>(i)];
      const bool is_begun = !job.unfinished.empty() && fs::exists(job.unfinished);
      const std::string state = is_finished(out / "shards", job) ? "finished"
                                : is_begun                       ? "begun"
                                                                 : "";
      nlohmann::json factors = nlohmann::json::object();
      for (const GridJob::Place& place : job.grid.places) factors[place.factor] = place.word;
      list.push_back({{"suite", suite->name},
                      {"job", job.name},
                      {"state", state},
                      {"factors", factors},
                      {"sets", job.grid.sets}});
      lines += suite->name + " " + job.name + (state.empty() ? "" : " ") + state + "\n";
    }
  }
  if (context.options.json)
    print_json(list);
  else
    print_result_lines(lines);
}

/// @throws std::invalid_argument naming an option that is given and that the suite does not read.
void check_takes(const BenchSuite& suite, const Options& o) {
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
    throw std::invalid_argument("suite \"" + suite.name + "\" takes no " + std::string(option));
  }
}

/// The folder of a suite, which may be absent.
/// @throws std::invalid_argument if it is a link: --out itself may be one, what lies in it not
fs::path suite_folder(const fs::path& out, const BenchSuite& suite) {
  const fs::path folder = out / suite.name;
  if (fs::is_symlink(fs::symlink_status(folder))) {
    throw std::invalid_argument(folder.string() +
                                " is in the way: it is a link, and links are not followed. Move it "
                                "away, or choose another --out");
  }
  return folder;
}

/// Shards of a suite, and the same suite with other options, add to one folder.
FolderClaim bench_claim() {
  return {.verb = "bench",
          .version = COUSIN_VERSION,
          .config = {},
          .names = report_names(),
          .sharing = FolderClaim::Sharing::shards};
}

/// @throws std::invalid_argument naming a suite that there is not, or an option that one does not
/// read
std::vector<const BenchSuite*> wanted_suites(const Options& o) {
  std::vector<std::string> names = o.arguments;
  if (names.empty() && (!o.only.empty() || !o.shard.empty())) {
    throw std::invalid_argument(std::string(o.only.empty() ? "--shard" : "--only") +
                                " is of the suites that run in jobs: name the suite");
  }
  if (names.empty()) {
    for (const BenchSuite& suite : bench_suites()) names.push_back(suite.name);
  }
  const std::vector<BenchSuite>& suites = bench_suites();
  std::vector<const BenchSuite*> wanted;
  for (const std::string& name : names) {
    const auto suite = std::find_if(suites.begin(), suites.end(), [&](const BenchSuite& s) {
      return name == s.name || (!name.empty() && name == s.old_name);
    });
    if (suite == suites.end()) {
      std::string all;
      for (const BenchSuite& other : suites) all += (all.empty() ? "" : ", ") + other.name;
      throw std::invalid_argument("suite \"" + name + "\" is not one of " + all);
    }
    if (!o.arguments.empty()) check_takes(*suite, o);
    wanted.push_back(&*suite);
  }
  return wanted;
}

}  // namespace

ExitCode command_bench(const JobContext& context) {
  const Options& o = context.options;
  const std::vector<const BenchSuite*> wanted = wanted_suites(o);
  RunConfig config = seeds_run_config(o.sets);  // a wrong key ends here, not hours later
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
  for (const BenchSuite* suite : wanted) require_writable(suite_folder(folder, *suite));
  for (const BenchSuite* suite : wanted)
    check_output_folder(suite_folder(folder, *suite), bench_claim());
  if (!o.captures.empty()) require_writable(o.captures);
  bool failed = false;
  const bool list = o.json && wanted.size() > 1;
  for (const BenchSuite* suite : wanted) {
    const fs::path out = suite_folder(folder, *suite);
    const OutputFolder guard(out, bench_claim());
    const ScoreFile file = run_suite(*suite, context, out);
    if (o.json) {
      if (list) std::printf("%s", suite == wanted.front() ? "[" : ",");
      std::printf("%s", to_json(file).c_str());
      if (list && suite == wanted.back()) std::printf("]\n");
    } else {
      print_suite(*suite, file.scores);
    }
    failed = failed || std::any_of(file.scores.begin(), file.scores.end(), [](const ScoreRow& row) {
               return row.status == ScoreStatus::fail || row.status == ScoreStatus::error;
             });
  }
  return failed ? ExitCode::gate_failed : ExitCode::done;
}

}  // namespace cousin
