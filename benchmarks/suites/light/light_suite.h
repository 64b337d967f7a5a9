#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"
#include "sim/config/fields.h"

namespace cousin {

struct LightConfig {
  std::uint64_t seed = 1;
  std::filesystem::path folder;  ///< for Blender's files (cycles/) and references (references/)
  int threads = 2;               ///< of Cycles
  int width_px = 640, height_px = 480;
  std::vector<double> samples = {4, 16, 64};             ///< a pixel, of both renderers
  std::vector<double> adaptive_samples = {32, 64, 128};  ///< a pixel on average, of ours
  std::vector<double> thresholds = {0.05, 0.02, 0.01};   ///< of Cycles' adaptive sampling
  int most_samples = 1024;                               ///< a pixel, of Cycles' adaptive sampling
  int reference_passes = 4;     ///< of each renderer's converged image; below 2: none
  int reference_samples = 256;  ///< a pixel of a pass
  int closed_form_samples = 1 << 20;
};
Fields fields(LightConfig& config);
/// Fewer samples, no reference.
LightConfig quick(LightConfig config);

struct LightResult {
  ScoreFile file;
  ReportScene pictures;  ///< ours, Cycles', their differences in light and in depth
};

/// The path tracer against closed forms, and beside Cycles on the leafy scene: agreement of
/// geometry and mean radiance, error against seconds at several sample counts, plain and adaptive,
/// and the ratio of the times to one error. An image's error is against its renderer's own
/// converged image, which shows noise and bias, and beside it from pairs of images, which shows
/// noise alone. The converged images' passes are kept in references/ and rendered once; a pass is
/// minutes. Without Blender the rows beside it say `not_built`.
LightResult light_suite(const LightConfig& config, const Progress& progress = {});

}  // namespace cousin
