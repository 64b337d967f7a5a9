#pragma once

#include <cstdint>

#include "sim/config/fields.h"
#include "sim/types/image.h"
#include "sim/types/rng.h"

namespace cousin {

/// An infrared imager [EMVA 1288 linear model]: electrons = radiance * electrons_at_unit_radiance *
/// exposure, codes = electrons * gain over full well.
struct InfraredImagerConfig {
  double electrons_at_unit_radiance = 4e5;  ///< at the longest exposure
  double full_well_e = 10000;
  double read_noise_e = 6;
  double prnu = 0.01;
  int bits = 8;                    ///< 8 or 10
  double target = 0.7;             ///< automatic exposure: the brightest 0.5 % at this share
  double least_exposure = 0.0003;  ///< over the longest
  double largest_gain = 16;        ///< analogue; beyond the longest exposure
  double blur_sigma_px = 0.4;      ///< of lens and pixel
};
Fields fields(InfraredImagerConfig& config);
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const InfraredImagerConfig& config);

/// Exposure over the longest, and gain.
struct InfraredExposure {
  double share = 1;
  double gain = 1;
};
/// Automatic exposure for an image of radiance: exposure first, then gain.
InfraredExposure auto_exposure(const Image<float>& radiance, const InfraredImagerConfig& config);

/// Relative response of each pixel: mean 1, sigma prnu; row y draws from rng.fork(y).
Image<float> response_map(int width, int height, double prnu, const Rng& rng);

/// Codes 0 .. 2^bits - 1 of one exposure: blur, response, shot and read noise, clipping, rounding.
/// Shot noise is a normal with the Poisson's variance and skewness. Row y draws from rng.fork(y).
/// @throws std::invalid_argument if the sizes of radiance and response differ.
Image<std::uint16_t> expose_infrared(const Image<float>& radiance, const Image<float>& response,
                                     const InfraredExposure& exposure,
                                     const InfraredImagerConfig& config, Rng rng);

}  // namespace cousin
