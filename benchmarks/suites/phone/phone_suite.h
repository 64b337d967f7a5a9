#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct PhoneSuiteConfig {
  std::uint64_t seed = 1;
  bool quick = false;
  int runs = 0;  ///< of each cultivar and way; 0 = 2
  std::vector<std::string> sets;
};

/// Seeds on a printed board before a phone that nobody has calibrated: each way of taking and
/// keeping the pictures measures the same seeds.
///   calibrated  the lens as the simulated phone reports it, pictures as they are
///   blind       a focal length of 0.85 of the width, then the board's lens
///   video       blind, and the pictures are H.264 of 8 Mbit/s, 10 a second: each is of another
///               place and gets the bits of a key frame
///   video_30    the same at 30 a second: a third of the bits a picture
///   sheet       video, and the board is a sheet with 0.5 mm of sag
std::vector<ShardJob> phone_suite_jobs(const PhoneSuiteConfig& config);

/// Statistics of each way over all runs, and each way's RMSE over the calibrated one's on the same
/// seeds; `sheet` and `video` are held to 1.5.
std::vector<ScoreRow> phone_pooled_rows(const std::vector<SpecimenRow>& specimens,
                                        std::uint64_t seed);

}  // namespace cousin
