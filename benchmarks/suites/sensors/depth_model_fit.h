#pragma once

#include <functional>
#include <vector>

#include "benchmarks/suites/sensors/depth_wall.h"

namespace cousin {

/// The walls that the fast model is fitted to, and others between them that it is scored on.
std::vector<WallCase> fit_walls(const ActiveStereoConfig& config);
std::vector<WallCase> test_walls(const ActiveStereoConfig& config);

/// One wall as the full and the fast model see it.
struct ModelComparison {
  WallCase wall;
  WallScores full, fast;
};

/// The fast model's numbers for a configuration: curves over the matcher's contrast,
/// waves over the fraction of the disparity and slopes from walls (`fit_depth_curves`), band and
/// grain from their statistics, fattening from a plate before a wall.
DepthModelConfig fit_depth_model(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                                 int frames, const Rng& rng,
                                 const std::function<void(int, int)>& progress = {});

std::vector<ModelComparison> compare_models(const std::vector<WallCase>& walls,
                                            const ActiveStereoConfig& config,
                                            const ActiveStereoUnit& unit, int frames,
                                            const Rng& rng);

/// How the edges of a plate before a wall look in the full model's image: mean over its left,
/// right, upper and lower edge, in pixels.
struct PlateEdges {
  double growth_px = 0;  ///< of the plate's measured area over its true one
  double rim_px = 0;  ///< width about its edges without a depth, less what the right imager misses
};
PlateEdges plate_edges(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                       const Rng& rng);

}  // namespace cousin
