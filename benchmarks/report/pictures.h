#pragma once

#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// Each pixel of the smaller image is the mean of what it covers.
Image<Rgb8> scaled_image(const Image<Rgb8>& image, int width, int height);
/// At most `most_px` wide and high, at the same aspect; never enlarged.
Image<Rgb8> shrunk(const Image<Rgb8>& image, int most_px);
/// The part from (x0, y0) that lies in the image.
Image<Rgb8> cropped(const Image<Rgb8>& image, int x0, int y0, int width, int height);
/// On white, `gap_px` apart, tops level.
Image<Rgb8> side_by_side(const std::vector<Image<Rgb8>>& images, int gap_px = 8);

/// Near is red, far is blue, none is dark grey: inverse depth between its 2 % and 98 % points
/// through a polynomial fit to the map "Turbo" [Mikhailov, Google AI Blog 2019].
Image<Rgb8> depth_in_color(const Image<float>& depth_m);

}  // namespace cousin
