#pragma once

#include "perception/fruit/fruit_fit.h"
#include "sim/types/seams.h"

namespace cousin {

/// How much of a fruit's surface is red. Red is what reflects at least so many times as much red as
/// green; the camera's white balance is taken for right.
struct RedShareConfig {
  double red_over_green = 1.9;  ///< in linear light; the truth's 2, less what glare adds to green
  double least_cosine = 0.2;  ///< of the surface against the view; more slanted pixels are left out
  int inset_px = 1;           ///< of the mask
  int least_pixels = 20;      ///< fewer are no share
  double sigma = 0.04;        ///< of the share that is seen, by colours
  double sigma_hidden = 0.6;  ///< of the hidden side's share over sqrt(p (1 - p))
};
Fields fields(RedShareConfig& config);
/// @throws std::invalid_argument naming key, value and limit
void validate(const RedShareConfig& config);

/// The share of what is seen, each pixel with the area of the surface that it shows, for the whole:
/// half of a fruit is hidden always, and its share is taken for the same. NaN with too few pixels.
/// @param color  of the box's camera, sRGB
FruitMeasure red_share_seen(const Image<Rgb8>& color, const Camera& camera, const DetectedBox& box,
                            const FruitShape& shape, const RedShareConfig& config = {});

}  // namespace cousin
