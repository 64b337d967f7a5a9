#pragma once

#include <cstdint>
#include <vector>

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

/// The distance near `z_m` at which a facing wall's disparity has this fraction.
double at_fraction_m(const ActiveStereoConfig& config, double z_m, double fraction);

/// The wall, the rig at the origin looking at it, and an even sky of that irradiance.
struct WallScene {
  Scene scene;
  Pose rig_from_world;
};
WallScene make_wall(const WallCase& wall);

/// Light and geometry of one pixel of a wall, as the fast model knows them.
struct WallPixel {
  float signal_e = 0, ambient_e = 0, rise = 0;
  float disparity_px = 0, slope = 0;  ///< true; |grad d|
};

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
  double slope = 0;        ///< mean |grad d|
  double disparity_px = 0;  ///< mean true one
  std::int64_t pixels = 0;
  // For fits: every 16th pixel of every 16th row, and what they have in common.
  std::vector<WallPixel> samples;
  PatternLight light;  ///< without its images
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
/// @param scenes  of which each draws holes and fixed noise anew: the means are over them, so that
/// what is left of chance is less than the full model's. Spatial noise is that of one.
WallScores score_fast_model(const WallView& view, const ActiveStereoConfig& config,
                            const ActiveStereoUnit& unit, int frames, const Rng& rng,
                            int scenes = 1);

}  // namespace cousin
