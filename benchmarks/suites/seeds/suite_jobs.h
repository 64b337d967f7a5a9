#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/study/grid.h"
#include "benchmarks/suites/seeds/suite.h"

namespace cousin {

/// Models that are trained on all views of a capture, and the steps after which they are measured
/// beside their ends; none of a method without steps.
struct TrainedJob {
  bool splats = false;    ///< any of these
  bool reference = true;  ///< the paper's way
  bool ours = true;       ///< ours for surfaces
  std::vector<int> reference_at, ours_at, ngp_at;
  /// Of trainings of ours for surfaces and for images, each one of its own: they are on small
  /// photographs first, so that one on its way is not one that ends there.
  std::vector<int> ours_steps, images_steps;
};

/// What is measured on a capture.
struct SeedsWork {
  std::vector<int> view_counts;  ///< evenly spread subsets of the views, beside all of them
  bool pooled = false;           ///< its specimens (all views) enter a table of many runs
  bool attribution = false;
  TrainedJob trained;
  bool only_trained = false;  ///< all views by trained models, and by nothing else
  int noise_views = 0;        ///< at most so many are photographed twice; then nothing else is done
};

/// One capture and what is measured on it.
struct SuiteJob {
  GridJob grid;  ///< its own keys come before the user's
  RunConfig config;
  std::uint64_t seed = 0;
  int run = 0;
  SeedsWork work;      ///< its last view count is all of them
  bool shown = false;  ///< the page has pictures of it
};

/// The suite's jobs in the order in which they run; equal ones once.
std::vector<SuiteJob> seeds_jobs(const SeedsSuiteConfig& suite);

/// What decides the trainings of a job, beside its configuration; empty: it has none.
std::string training_text(const TrainedJob& job, RunConfig config);

}  // namespace cousin
