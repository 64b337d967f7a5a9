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
/// Those beyond one pixel are wrong matches: they count as `wrong`, not in the spreads.
struct WallScores {
  double fill = 0;         ///< share of pixels with a depth
  double wrong = 0;        ///< share of those that are wrong
  double bias_px = 0;      ///< mean error of the disparity
  double spatial_px = 0;   ///< RMS over the image of what stays from frame to frame, about its mean
  double temporal_px = 0;  ///< RMS over pixels of the standard deviation over frames
  double sigma_px = 0;     ///< RMS of one frame about its mean
  double sigma_m = 0;      ///< the same of the 16-bit depth
  double ripple_px = 0;    ///< amplitude of the error that goes as sin(2 pi d)
  double neighbours = 0;   ///< correlation of the fixed error with that 3 px beside it
  double band_px = 0;      ///< mean over rows of the first column with a depth
  double log2_snr = 0;     ///< median of the pattern's signal-to-noise ratio
  // Medians of the pattern's light, for fits of the margin's weight.
  double signal_e = 0, noise_e2 = 0, margin_e = 0;
  double slope = 0;         ///< mean |grad d|
  double disparity_px = 0;  ///< mean true one
  std::int64_t pixels = 0;
};

/// A wall, rendered once, for both models.
struct WallView {
  WallCase wall;
  InfraredPair pair;
  DepthModelInputs inputs;
};
WallView see_wall(const WallCase& wall, const ActiveStereoConfig& config,
                  const ActiveStereoUnit& unit, const Rng& rng);

/// @param frames  exposures of the same scene, at least 1; temporal noise takes 2.
WallScores score_full_model(const WallView& view, const ActiveStereoConfig& config,
                            const ActiveStereoUnit& unit, int frames, const Rng& rng);
WallScores score_fast_model(const WallView& view, const ActiveStereoConfig& config,
                            const ActiveStereoUnit& unit, int frames, const Rng& rng);

}  // namespace cousin
