#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/study/shard_scores.h"

namespace cousin {

/// What `cousin bench` runs by name.
struct BenchSuite {
  const char* name;
  /// Measures what the folder holds no result of, writes tables and page there.
  ScoreFile (*run)(const JobContext& context, const std::filesystem::path& out);
  std::array<std::string_view, 8> takes;  ///< the options that it reads, of those not all do
  /// What it runs in jobs; null: it does not, and has no --list.
  std::vector<ShardJob> (*jobs)(const JobContext& context,
                                const std::filesystem::path& out) = nullptr;
};
/// All, in the order in which `cousin bench` without a name runs them.
std::span<const BenchSuite> bench_suites();

}  // namespace cousin
