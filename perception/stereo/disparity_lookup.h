#pragma once

#include <Eigen/Core>

#include "sim/types/image.h"
#include "sim/types/no_value.h"

namespace cousin {

/// A disparity with its standard deviation.
struct KnownDisparity {
  float disparity_px = kNone, sigma_px = kNone;
};

/// Between an image's pixels, where those about it lie on one surface; else the nearest's, which
/// may have none.
/// @param sigma_px  of the same size, or empty
KnownDisparity disparity_at(const Image<float>& disparity_px, const Image<float>& sigma_px,
                            const Eigen::Vector2d& pixel);

}  // namespace cousin
