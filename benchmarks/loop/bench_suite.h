#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/loop/seeds_report.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/study/shard_scores.h"

namespace cousin {

/// What the user asks of a suite. What a row does not name in `takes` is as it is here.
struct SuiteRun {
  std::filesystem::path out;        ///< the suite's own folder
  std::filesystem::path real_data;  ///< real captures; may be absent
  std::uint64_t seed = 1;
  bool quick = false;
  int runs = 0;                    ///< of each point; 0 = the suite's own number
  int threads = 0;                 ///< 0 = all cores
  std::vector<std::string> sets;   ///< key=value
  bool attribution = false;        ///< truth in place of each seam in turn
  std::filesystem::path captures;  ///< keeps what is rendered; empty = nowhere
  std::filesystem::path lpips;     ///< network that scores images too; empty = none
  std::string command_line;
  Progress progress;

  /// Folder of trainings that were stopped.
  std::filesystem::path unfinished() const { return out / "unfinished"; }
};

/// A suite's scores, and what its page has beside tables and plots.
struct SuitePage {
  SeedsReport report;  ///< its title is the suite's, and so is its summary if it has none
  /// Writes report.html in place of the usual page; empty: nothing does.
  std::function<void(const ScoreFile& scores)> write_own;
};

/// One suite: a row of the table that `cousin bench` runs by name.
struct BenchSuite {
  std::string name;
  std::string old_name = {};       ///< what earlier versions called it; still taken
  std::string help;                ///< below the page's title
  std::vector<std::string> takes;  ///< options that it reads, of those not all do
  /// The jobs of its grid (grid.h); null: it measures at once, and has no --list.
  std::vector<ShardJob> (*jobs)(const SuiteRun& run) = nullptr;
  /// What becomes of its jobs' results, or what it measures at once; null: the jobs' rows alone.
  SuitePage (*page)(const SuiteRun& run, const std::vector<ShardResult>& results) = nullptr;
  /// Gives the rows that have a limit the status pass or fail; null: they come with it.
  void (*limits)(const SuiteRun& run, ScoreFile& scores) = nullptr;
  /// Adds curves, lines and tables that are made of rows of the suite; of others none.
  void (*plots)(SeedsReport& report) = nullptr;
  /// Printed with the tables in place of the rows; null: the rows are.
  std::string (*text)(const std::vector<ScoreRow>& rows) = nullptr;
};

/// A page with these scores and nothing else.
SuitePage suite_page(ScoreFile scores);
SuitePage suite_page(std::vector<ScoreRow> rows);
/// Keeps pictures for the page and notes which it shows.
void keep_scene(SeedsReport& report, const ReportScene& scene, const std::filesystem::path& out);
/// The pictures of the jobs on this page, which are in `folder` by their names: a --quick run and a
/// full one share it.
void show_scenes(const std::vector<ShardResult>& results, const std::filesystem::path& folder,
                 SeedsReport& report);
/// Puts things after those that are there.
template <typename T>
void add_all(std::vector<T> more, std::vector<T>& to) {
  for (T& one : more) to.push_back(std::move(one));
}

}  // namespace cousin
