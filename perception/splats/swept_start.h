#pragma once

#include <span>
#include <vector>

#include "perception/mvs/plane_sweep.h"
#include "perception/splats/splat_start.h"
#include "perception/splats/splat_views.h"
#include "perception/splats/view_exposures.h"

namespace cousin {

struct SweptStartConfig {
  /// Photographs are halved until their longer side is at most this, or a side is below 32: a start
  /// needs no more, and half the side takes an eighth of the time.
  int largest_side_px = 128;
  MvsConfig mvs = {.neighbours = 4, .window_px = 5, .consistency_depth = 0.01, .max_references = 0};
  double voxel_px = 0.5;    ///< points nearer than this are one, in pixels at the median depth
  double agreement_px = 1;  ///< along the normal: farther off is another surface
  ExposureConfig exposures;
  int most_points = 5000;  ///< evenly taken of those found; >= 0
  double opacity = 0.5;    ///< of the points, 0..1 exclusive
};
void validate(const SweptStartConfig& config);  ///< throws std::invalid_argument

/// What Gaussians of posed photographs may begin from in place of points drawn in a box.
struct SweptStart {
  std::vector<StartPoint> points;  ///< with normals; coloured as at the views' mean exposure
  ViewExposures exposures;         ///< of the views
};

/// Sweeps the volume at a small size and fuses the depths; correlation, by which depths are found,
/// does not mind exposures, which are then measured on these surfaces. Surfaces without texture
/// give no points. The same bytes on any number of threads.
/// @throws std::invalid_argument if the configuration is invalid.
SweptStart swept_start(std::span<const SplatView> views, const SweepVolume& volume,
                       const SweptStartConfig& config = {});

}  // namespace cousin
