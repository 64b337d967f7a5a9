#pragma once

#include <filesystem>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/suites/real/real_rows.h"

namespace cousin {

struct RealResult {
  ScoreFile file;
  RealPart page;  ///< pictures, shapes and distributions of all parts; its rows are in `file`
};

/// Real captures through our readers and stages: a real maize plant carved from silhouettes against
/// the published carvings, a nerfstudio capture through undistortion and multi-view stereo,
/// photographs of rice grains with rulers. Folders that are absent give rows with status
/// not_solved. Pictures and clouds are written below `out`.
RealResult real_suite(const std::filesystem::path& real_data, const std::filesystem::path& out,
                      bool quick, const Progress& progress = {});

}  // namespace cousin
