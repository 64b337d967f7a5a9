#pragma once

#include <span>

#include "benchmarks/score/trait_statistics.h"
#include "sim/types/image.h"
#include "sim/types/rng.h"

namespace cousin {

double luminance(const Rgbf& color);
double mean_luminance(const Image<Rgbf>& image);

/// A renderer's own converged image, as the mean of independent passes.
struct Reference {
  Image<Rgbf> mean;
  Image<float> luminance_variance;  ///< of the mean, by the spread of the passes
};
/// @throws std::invalid_argument for fewer than two passes, or of unequal sizes.
Reference merge_passes(std::span<const Image<Rgbf>> passes);

/// Relative error of one image: the root of the mean over pixels of (error of luminance)^2 / (its
/// true luminance + a tenth of the image's mean)^2, with a 95 % interval by bootstrap over tiles of
/// 16 x 16 pixels.
///
/// Against a reference: the squared difference less the reference's own variance, so that what is
/// left is the image's variance and its bias.
WithInterval reference_error(const Image<Rgbf>& image, const Reference& reference, Rng rng);
/// From two images of independent draws: half the squared difference. The same without a bias
/// common to both.
WithInterval pair_error(const Image<Rgbf>& a, const Image<Rgbf>& b, Rng rng);

}  // namespace cousin
