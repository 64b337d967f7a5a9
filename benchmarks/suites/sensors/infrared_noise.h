#pragma once

#include "benchmarks/suites/sensors/depth_wall.h"

namespace cousin {

/// Squared error of the rendering over the variance of the imager's own noise, both of one
/// exposure's electrons behind the blur, means over the image, without speckle: a render against
/// one of 36 times the samples and another stream; photons and read noise.
double render_noise_share(const WallCase& wall, const ActiveStereoConfig& config,
                          const ActiveStereoUnit& unit, const Rng& rng);

}  // namespace cousin
