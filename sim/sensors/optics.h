#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// Radial map of one colour against green's: what green images at r, this colour images at
/// r (scale + cubic r^2), r from the principal point over the half diagonal [lensfun's "poly3"
/// without its even term].
struct RadialColour {
  double scale = 1;
  double cubic = 0;
  bool operator==(const RadialColour&) const = default;
};

/// What a lens does to an image that a pinhole of its distortion would take.
struct Optics {
  double vignetting_a = 0, vignetting_b = 0,
         vignetting_c = 0;   ///< gain = 1 + a r^2 + b r^4 + c r^6, r as above
  RadialColour red, blue;    ///< lateral chromatic aberration
  double blur_sigma_px = 0;  ///< Gaussian part of the lens and pixel response; 0 = none
};

/// Normalised Gaussian weights from -radius to radius, cut at four sigmas.
std::vector<float> gaussian_weights(double sigma_px);

/// Lateral colour, vignetting and the blur along rows; `blurred_row` does the columns. Red and blue
/// are resampled from the given image by Catmull-Rom, borders repeated: where they move by half a
/// pixel, contrast at half of the Nyquist frequency falls to 0.88. TBB over rows.
/// @param name  of the sensor, for messages
/// @throws std::invalid_argument if a radiance is not finite.
Image<Rgbf> shade_and_blur_rows(const Image<Rgbf>& radiance, const Optics& optics,
                                const Camera& camera, std::span<const float> weights,
                                const std::string& name);

/// Row y of the image blurred along columns: red, green, blue of each pixel in turn; borders
/// repeat.
void blurred_row(const Image<Rgbf>& image, std::span<const float> weights, int y,
                 std::vector<float>& out);

/// Gain at a place in the image, by the polynomial above.
double vignetting_gain(const Optics& optics, const Camera& camera, double x_px, double y_px);

}  // namespace cousin
