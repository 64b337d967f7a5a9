#pragma once

#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/study/grid.h"

namespace cousin {

/// Part `index` (from 0) of `count` of a list of work.
struct Shard {
  int index = 0;
  int count = 1;
};
/// "i/n"; empty = everything. @throws std::invalid_argument naming the text and the form.
Shard parse_shard(const std::string& text);
/// The half-open range of a list of `size` items that belongs to the shard; sizes differ by one at
/// most.
std::pair<int, int> shard_range(const Shard& shard, int size);

/// One piece of long work, minutes at most: a pure function of `key` whose result is text (JSON).
struct ShardJob {
  std::string name;  ///< file name below the folder: letters, digits, . _ -
  std::string
      key;  ///< everything the result depends on; a finished result with another key is made anew
  std::function<std::string()> run;
  /// Where the job keeps what it would go on from, if anywhere; removed when its result is written.
  std::filesystem::path unfinished = {};
  GridJob grid = {};  ///< where the job is in its suite's grid; of no name: its list has no grid
};
/// The piece of work of a grid's job, in the file NAME.json.
ShardJob shard_of(GridJob job, std::string key, std::function<std::string()> run,
                  std::filesystem::path unfinished = {});
/// A piece of work for each job of a grid, which makes `run` of it. Its key is `prefix` (the
/// program, the suite, the seed), the job's name, its own configuration keys and the user's.
std::vector<ShardJob> shards_of(const Grid& grid, const std::string& prefix,
                                const std::vector<std::string>& sets,
                                const std::function<std::string(const GridJob&)>& run);
struct ShardResult {
  std::string name;
  std::string text;   ///< empty if the job threw or belongs to another shard and is not there yet
  std::string error;  ///< what a failed job threw, or why its result could not be written
  std::exception_ptr failure;  ///< the same, to be thrown on
  bool reused = false;
};
/// Whether the job belongs to another shard that has not written its result yet.
bool is_missing(const ShardResult& result);

/// The jobs whose names hold one of `parts`, which commas divide; empty = all. @throws
/// std::invalid_argument if there is none, naming some that there are.
std::vector<ShardJob> jobs_named(std::vector<ShardJob> jobs, const std::string& parts);

/// Whether `folder` holds the job's result, made with its key.
bool is_finished(const std::filesystem::path& folder, const ShardJob& job);

/// Runs the jobs of `shard` that `folder` holds no result for, in order, and writes each result at
/// once, under its final name only when whole: a run that was stopped goes on where it was. Jobs of
/// other shards are read if they are there when this shard's are done. A job that throws is
/// recorded and the rest goes on.
std::vector<ShardResult> run_shards(
    const std::filesystem::path& folder, const std::vector<ShardJob>& jobs, const Shard& shard,
    const std::function<void(const std::string& name, int done, int total)>& progress = {});

}  // namespace cousin
