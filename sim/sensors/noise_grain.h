#pragma once

#include "sim/types/image.h"
#include "sim/types/rng.h"

namespace cousin {

/// Normal noise of unit variance that is alike over about `grain_px`: white noise averaged over
/// squares of the odd width nearest to that, scaled back. Row y draws from rng.fork(y).
Image<float> noise_grain(int width, int height, double grain_px, const Rng& rng);

/// Share of a standard normal below x: the distribution function to 7.5e-8 [Abramowitz & Stegun
/// 26.2.17].
float normal_share(float x);

}  // namespace cousin
