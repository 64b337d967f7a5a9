#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/study/grid.h"
#include "benchmarks/suites/seedlings/field_training.h"
#include "benchmarks/suites/seedlings/sample_capture.h"

namespace cousin {

struct SeedlingsSuiteConfig {
  std::uint64_t seed = 1;
  int samples = 3;               ///< trays, each under every light
  bool quick = false;            ///< one tray, small photographs, few steps: minutes
  std::filesystem::path report;  ///< folder for pictures of the page; empty: none
  /// Trainings that were stopped go on from here, in a folder a job; empty: none do.
  std::filesystem::path unfinished;
  std::filesystem::path lpips;  ///< network that images are scored by too; empty: none
};

/// Steps of ours after which sets of more photographs are scored, beside 30 after as many.
inline constexpr int kMoreViewsSteps = 2000;

/// One method on one set of photographs of one sample.
struct SeedlingsJob {
  GridJob grid;  ///< its name as "D1_0_20_reference_400px"
  SeedlingsSample sample;
  ViewSet set;
  FieldPlan plan;
  int noise_views = 4;
  bool shown = false;  ///< the page has pictures of it
  /// Which of the method's trainings, where other jobs have the rest: "between" those of minutes,
  /// "long", up to an hour, "shape", of whose last model only surfaces are scored; empty: the
  /// first, of which the reference's says what the photographs are like.
  std::string part;

  /// "sample 0, 20 views, 400x300"; rows of a snapshot add its steps
  std::string case_name() const;
};

/// All jobs, those of one capture one after another.
std::vector<SeedlingsJob> seedlings_jobs(const SeedlingsSuiteConfig& config);
/// What decides a job's result but the seed: all that is configured, and a word for what the code
/// of ours decides by constants, to be changed with them.
std::string key_of(const SeedlingsJob& job);

/// Keeps the last capture of each plan, since neighbouring jobs share it.
class LastCaptures {
 public:
  const SampleCapture& of(const SeedlingsSample& sample, SamplePlan plan, int noise_views,
                          std::uint64_t seed);

 private:
  struct Kept {
    std::string key;
    SampleCapture capture;
  };
  Kept kept_[2];
};

/// Photographs, trains, scores: rows of this sample (seedlings_rows.h).
/// @param report  folder for pictures if the job is shown; empty: none
/// @param unfinished  of this job alone: a training that was stopped goes on from here; empty: none
ScoreFile run_seedlings_job(const SeedlingsJob& job, std::uint64_t seed, LastCaptures& captures,
                            const std::filesystem::path& report = {},
                            const std::filesystem::path& unfinished = {},
                            std::shared_ptr<const LearnedDistance> learned = {});

}  // namespace cousin
