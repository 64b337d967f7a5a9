#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "perception/splats/view_exposures.h"

namespace cousin {

inline constexpr int kLeastSharingViews = 2;  ///< that show a point, or are linked

/// A surface point's light in a view.
struct LightSighting {
  int view, pixel;   ///< of it the nearest, row by row
  double log_light;  ///< ln of the sum of linear channels
  double r2;         ///< squared distance from the principal point over the half diagonal's
};

/// Sightings of one point after another.
struct LightSightings {
  std::vector<LightSighting> all;
  std::vector<std::size_t> first{0};  ///< of each point, and the end

  std::size_t points() const { return first.size() - 1; }
  std::span<const LightSighting> of(std::size_t point) const {
    return std::span(all).subspan(first[point], first[point + 1] - first[point]);
  }
  void append(const LightSightings& other) {
    const std::size_t from = all.size();
    all.insert(all.end(), other.all.begin(), other.all.end());
    for (std::size_t p = 1; p < other.first.size(); ++p) first.push_back(from + other.first[p]);
  }
};

/// What estimate_exposures() says of such sightings: views that enough common points link, ln of
/// light = point + view + vignetting, by least squares with Cauchy's weights.
ViewExposures fit_exposures(const LightSightings& sightings, std::size_t views,
                            int least_sightings);

}  // namespace cousin
