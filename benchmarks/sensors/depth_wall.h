#pragma once

#include <cstdint>

#include "sim/sensors/active_stereo.h"

namespace cousin {

/// A flat wall before a depth camera.
struct WallCase {
  double distance_m = 1;     ///< along the optical axis
  double incidence_rad = 0;  ///< the wall is turned about the vertical
  double albedo = 0.5;       ///< at 850 nm
  double light = 0.02;       ///< irradiance of the wall by an even sky, before the infrared's share
  double texture = 0;        ///< contrast of a fine print, as a share of the albedo
};

/// The wall, the rig at the origin looking at it, and an even sky of that irradiance.
struct WallScene {
  Scene scene;
  Pose rig_from_world;
};
WallScene make_wall(const WallCase& wall);

/// Errors of the disparities in the middle half of the image, where the right imager sees the wall.
struct WallScores {
  double fill = 0;         ///< share of pixels with a depth
  double bias_px = 0;      ///< mean error of the disparity
  double spatial_px = 0;   ///< RMS over the image of the mean over frames, about its mean
  double temporal_px = 0;  ///< median over pixels of the standard deviation over frames
  double sigma_px = 0;     ///< RMS of one frame about its mean
  double sigma_m = 0;      ///< the same of the 16-bit depth
  std::int64_t pixels = 0;
};
/// @param frames  exposures of the same scene, at least 1; temporal noise takes 2.
WallScores score_wall(const WallCase& wall, const ActiveStereoConfig& config,
                      const ActiveStereoUnit& unit, int frames, Rng rng);

}  // namespace cousin
