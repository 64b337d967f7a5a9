#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/equal_time.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/suites/seedlings/seedlings_jobs.h"

namespace cousin {

inline constexpr const char* kSeedlingsSuite = "seedlings";

/// Rows of one job. After each of its steps ("CASE, 7000 steps"): train.psnr, .psnr_exposed,
/// .ssim, .flip, .psnr_seedlings, .ssim_seedlings, .flip_seedlings, the same of held_out,
/// gaussians; held_out.psnr_pooled, .psnr_covered and .psnr_uncovered, which pool the squares of
/// all views where the others are means of the views' PSNR. The reference's say of their
/// photographs how much of the held-out pixels' surface is seen by 1 and by kEnoughViews of them
/// (coverage.seen_by_3); on the full set also noise_floor.psnr and .psnr_seedlings.
std::vector<ScoreRow> sample_rows(const SeedlingsJob& job, std::uint64_t seed,
                                  const TrainedField& field, const FieldViews& views,
                                  const SampleCapture& whole);

/// Rows of a job whose surfaces are scored (field_shape.h), with the seconds of its training.
std::vector<ScoreRow> shape_job_rows(const SeedlingsJob& job, std::uint64_t seed,
                                     const TrainedField& field, const FieldViews& views);

/// Means over the samples of rows whose cases differ in "sample N" alone ("mean, 30 views, 400x300,
/// 7000 steps"), with Student's 95 % interval where there are two samples; n = samples. Samples
/// for which not every method of the case has a number are left out. Seconds are means.
std::vector<ScoreRow> mean_rows(const std::vector<ScoreRow>& rows);

/// Ours less the reference, PSNR in dB: the reference at its last but at most `steps` steps, ours
/// after the last of its trainings that takes no more seconds of wall time; and the same of CPU
/// time. Two rows a sample and metric, none where none of ours ends by then on the same machine.
std::vector<ScoreRow> equal_time_rows(const std::vector<ScoreRow>& rows, int steps,
                                      const TrainingMachines& machines = {});

}  // namespace cousin
