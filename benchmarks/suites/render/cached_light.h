#pragma once

#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"

namespace cousin {

/// How the radiance pass, which shares cached irradiance between views, differs from unbiased paths
/// on what one category of instances shows.
struct CachedLightError {
  std::string category;     ///< Instance::category, "specimens", or "all" for the whole image
  std::int64_t pixels = 0;  ///< in whole blocks of the category
  double mean_ratio = 0;    ///< mean radiance, cached over paths
  double rms = 0;  ///< of blocks' relative difference, without what the paths' own noise adds
};

/// One view by both; blocks of 8 x 8 pixels that show a single category at all their centres.
/// @param samples  paths a pixel
std::vector<CachedLightError> compare_cached_light(const Simulation& simulation, int frame,
                                                   int samples, int max_bounces);

}  // namespace cousin
