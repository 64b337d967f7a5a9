#pragma once

#include <vector>

#include "perception/splats/splat_render.h"
#include "sim/types/image.h"

namespace cousin {

struct PhotometricConfig {
  enum class Kernel {
    fastest,  ///< AVX2 with FMA where this machine has it
    portable
  };
  double ssim_share = 0.2;  ///< s in (1 - s) L1 + s (1 - SSIM), 0..1
  Kernel kernel = Kernel::fastest;
};
void validate(const PhotometricConfig& config);  ///< throws std::invalid_argument

/// What a rendered image costs against its photograph, and which way it is to change. Means are
/// over channels and weighted pixels.
struct LossAndGradient {
  double value = 0;      ///< (1 - s) l1 + s (1 - ssim)
  double l1 = 0;         ///< mean absolute difference
  double ssim = 0;       ///< mean structural similarity
  ColorPlanes gradient;  ///< of `value` with respect to each value of the rendered image
};

/// The loss that 3DGS trains with [Kerbl et al., ACM TOG 42(4), 2023, eq. 7], and its gradient.
/// SSIM [Wang et al., IEEE TIP 13(4), 2004] has a Gaussian window of 11 x 11 and sigma 1.5,
/// C1 = 0.01^2 and C2 = 0.03^2; windows see zeros beyond the border, as the reference's do. Keeps
/// its buffers, so calls after the first of a size allocate nothing. TBB over channels and bands of
/// rows; the same bytes on any number of threads. One object serves one call at a time.
class PhotometricLoss {
 public:
  explicit PhotometricLoss(const PhotometricConfig& config = {});

  /// @param weight  empty: every pixel counts once. Else of the images' size, finite and not
  /// negative: a pixel's term is multiplied by its weight, and the means divide by the sum of the
  /// weights. A pixel of weight zero counts as beyond the border: windows see zeros there in both
  /// images, and its gradient is zero. If all are zero, so are value and gradient.
  /// @returns a reference that holds until the next call. A NaN in an image makes the value NaN.
  /// @throws std::invalid_argument if sizes differ, images are empty, or a weight is invalid.
  const LossAndGradient& operator()(const ColorPlanes& rendered, const ColorPlanes& photograph,
                                    const Image<float>& weight = {});

 private:
  PhotometricConfig config_;
  LossAndGradient result_;
  std::vector<float> scratch_;  ///< rows of each task
  std::vector<double>
      row_sums_;  ///< absolute differences and similarities, of each channel and row
};

}  // namespace cousin
