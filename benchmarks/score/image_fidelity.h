#pragma once

#include <array>
#include <cstdint>

#include "sim/types/image.h"
#include "sim/types/seams.h"

namespace cousin {

/// How an image of a scene looks beside a photograph of it. Images are planar red, green and blue,
/// sRGB-encoded, 0..1; values beyond are clamped, as a screen does. NaN in an image makes the
/// scores of the pixels that it reaches NaN. A mask is empty, or of the images' size: then scores
/// are over its non-zero pixels, while windows and filters see the whole images. Scores over no
/// pixel are NaN. All throw std::invalid_argument if sizes differ.
using FidelityPlanes = std::array<Image<float>, 3>;
FidelityPlanes fidelity_planes(const Image<Rgb8>& image);
/// Back to codes, values beyond 0..1 clamped.
Image<Rgb8> rgb_of(const FidelityPlanes& planes);

/// The mask of a photograph some of whose pixels say nothing, as borders that undistorting leaves:
/// not zero where the weight is at least 0.999. No weights, no mask.
Image<std::uint8_t> counted_pixels(const Image<float>& weight);

/// The image, and the photograph's own pixels where `counted` is zero (of the images' size; empty:
/// all count): so windows of SSIM, FLIP's filters and a network see no difference there.
FidelityPlanes where_counted(FidelityPlanes image, const FidelityPlanes& photograph,
                             const Image<std::uint8_t>& counted);

/// 10 log10(1 / mean squared difference) over pixels and channels; infinite for equal images.
double psnr_db(const FidelityPlanes& image, const FidelityPlanes& photograph,
               const Image<std::uint8_t>& mask = {});

/// Mean over pixels and channels of structural similarity [Wang et al., IEEE TIP 13(4), 2004]: a
/// Gaussian window of 11 x 11 and sigma 1.5, C1 = 0.01^2, C2 = 0.03^2, zeros beyond the border, as
/// 3DGS reports it [Kerbl et al. 2023].
double ssim(const FidelityPlanes& image, const FidelityPlanes& photograph,
            const Image<std::uint8_t>& mask = {});

/// Pixels a degree of a screen 0.7 m wide and 3840 pixels across at a distance of 0.7 m: what
/// FLIP's authors take where nothing is known [Andersson et al. 2020].
inline constexpr double kUsualPixelsPerDegree = 67.02064327658226;

/// The difference that a viewer sees when two images alternate, at each pixel, 0..1: FLIP for
/// images of limited range [Andersson et al., Proc. ACM CGIT 3(2), 2020]: contrast sensitivity
/// filters, HyAB distances in Hunt-adjusted CIELAB, edges and points. TBB over rows; the same bytes
/// on any number of threads. @throws std::invalid_argument also if pixels_per_degree is not in
/// 1..1000.
Image<float> flip_map(const FidelityPlanes& image, const FidelityPlanes& photograph,
                      double pixels_per_degree = kUsualPixelsPerDegree);
/// Its mean.
double flip(const FidelityPlanes& image, const FidelityPlanes& photograph,
            const Image<std::uint8_t>& mask = {}, double pixels_per_degree = kUsualPixelsPerDegree);

/// All of them. LPIPS is not among them: its weights are a trained network's, which Cousin does not
/// have.
struct ImageFidelity {
  long long pixels = 0;  ///< that counted
  double psnr_db = kNaN;
  double ssim = kNaN;
  double flip = kNaN;
};
ImageFidelity score_fidelity(const FidelityPlanes& image, const FidelityPlanes& photograph,
                             const Image<std::uint8_t>& mask = {},
                             double pixels_per_degree = kUsualPixelsPerDegree);

}  // namespace cousin
