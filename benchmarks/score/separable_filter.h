#pragma once

#include <vector>

#include "sim/types/image.h"

namespace cousin {

enum class FilterBorder { zero, replicate };

/// Taps from -radius to +radius: an odd count.
using FilterTaps = std::vector<double>;

/// The image filtered along its rows by `along_x`, then along its columns by `along_y`; the value
/// at a pixel is the sum over k of taps[k] * image at k - radius away. TBB over rows; the same
/// bytes on any number of threads.
Image<double> filtered(const Image<double>& image, const FilterTaps& along_x,
                       const FilterTaps& along_y, FilterBorder border);

/// exp(-x^2 / (2 sigma^2)) at -radius..radius, summing to one.
FilterTaps gaussian_taps(double sigma, int radius);

}  // namespace cousin
