#pragma once

#include <cstdint>
#include <vector>

#include "sim/sensors/camera_sensor.h"

namespace cousin {

/// A camera of 640 x 480 with the photosites of `config` and a lens that leaves a flat field flat.
CameraSensorConfig flat_camera(const CameraSensorConfig& config);

/// Straight line through half the variance of the difference of two frames against their mean less
/// the black level, of the green (or grey) photosites of flat fields, weighted by its sampling
/// variance [EMVA 1288 photon transfer]. Codes.
struct PhotonTransfer {
  double slope = 0;             ///< K, codes an electron
  double intercept = 0;         ///< K^2 (read^2 + row^2) + 1/12, codes^2
  std::int64_t photosites = 0;  ///< an exposure
  struct Point {
    double mean = 0, variance = 0;  ///< less the black level, codes; codes^2
  };
  std::vector<Point> points;  ///< one an exposure
};
/// Exposures are spread evenly in the logarithm from where the noise spans 0.7 codes (below,
/// rounding is no noise of variance 1/12), but 10 electrons at least, to 80 % of full well.
PhotonTransfer photon_transfer(const CameraSensorConfig& flat, const CameraUnit& unit,
                               int exposures, std::uint64_t seed);
/// The intercept that the model states.
double expected_intercept(const PhotositesConfig& photosites);

/// Spatial nonuniformity after EMVA 1288 from stacks of frames at two lights, what is left of the
/// temporal noise taken off: s^2 = K^2 (DSNU^2 + PRNU^2 e^2). The lower light is not darkness but
/// where the noise spans 0.7 codes: below, rounding hides offsets that are smaller than a code. And
/// that of the unit's own maps over the same photosites.
struct FixedPattern {
  double prnu = 0, dsnu_e = 0;
  double prnu_sigma = 0,
         dsnu_sigma_e = 0;  ///< standard errors from the temporal noise that is left
  double true_prnu = 0, true_dsnu_e = 0;
  std::int64_t photosites = 0;
};
FixedPattern fixed_pattern(const CameraSensorConfig& flat, const CameraUnit& unit, int frames,
                           std::uint64_t seed);

/// Largest deviation, over 16 rings of equal width, of the mean signal of a flat field from the
/// model's gain times PRNU over the same photosites, both relative to the innermost ring; with the
/// optics of `config` at 640 px width. That ring has 980 green photosites at a signal-to-noise
/// ratio of 60 or more, so 16 frames know it to 1.3e-4.
double vignetting_deviation(const CameraSensorConfig& config, int frames, std::uint64_t seed);

}  // namespace cousin
