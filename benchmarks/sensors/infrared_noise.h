#pragma once

#include "benchmarks/sensors/depth_wall.h"

namespace cousin {

/// Variance of the rendering over that of the imager's own noise, both of one exposure's electrons
/// behind the blur, means over the image: half the square of the difference between two renders of
/// different streams, without speckle, against photons and read noise.
double monte_carlo_share(const WallCase& wall, const ActiveStereoConfig& config,
                         const ActiveStereoUnit& unit, const Rng& rng);

}  // namespace cousin
