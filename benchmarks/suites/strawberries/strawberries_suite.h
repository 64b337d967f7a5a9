#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/loop/bench_suite.h"

namespace cousin {

struct StrawberriesSuiteConfig {
  std::uint64_t seed = 1;
  /// One run of each, 3 views; but for the camera jobs the sensor's law in place of matched images.
  bool quick = false;
  int runs = 0;  ///< stretches of bed; 0 = 10. Family and cameras take a third of them, near one
  std::vector<std::string> sets;
};

/// Stretches of a strawberry bed before a D457 at 0.3 to 0.6 m, measured by all methods of the
/// pipeline strawberries; run N is stretch N, which nothing was tuned on for seeds below 100:
///   bed_runN            as it grows
///   family_runN         fruits of another shape family
///   near_runN           0.15 to 0.3 m, at and below the sensor's least distance
///   camera_NAME_runN    the first jobs' stretches by another camera or depth mode
std::vector<ShardJob> strawberries_suite_jobs(const StrawberriesSuiteConfig& config);

/// fruit_pooled_rows with what the project aims at as limits.
std::vector<ScoreRow> strawberries_pooled_rows(const ScoreFile& jobs, std::uint64_t seed);

/// Curves of what is reported, and what each camera comes to.
void add_strawberries_plots(SeedsReport& report);

}  // namespace cousin
