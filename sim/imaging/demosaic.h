#pragma once

#include <string_view>

#include "sim/types/image.h"
#include "sim/types/mosaic.h"

namespace cousin {

enum class Demosaic {
  bilinear,          ///< mean of the nearest samples of the colour
  malvar_he_cutler,  ///< the same corrected by the Laplacian of the pixel's own colour, 5 x 5
                     ///< [Malvar, He & Cutler, ICASSP 2004]
};
std::string_view to_string(Demosaic method);
/// @throws std::invalid_argument naming the text and the names that exist.
Demosaic demosaic_from_string(std::string_view text);

/// All three colours at every pixel of a Bayer image (a grey one is spread). Linear in the samples,
/// which are kept where they are; borders mirror about their pixels, so that the pattern goes on.
/// TBB over rows; the same bytes on any number of threads.
/// @throws std::invalid_argument for an image smaller than 3 x 3.
Image<Rgbf> demosaic(const Image<float>& samples, Mosaic mosaic, Demosaic method);

}  // namespace cousin
