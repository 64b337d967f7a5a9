#pragma once

#include <cstdint>

#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// The pinhole image that is wanted. Zeros: as the lens has it.
struct UndistortConfig {
  enum class Interpolation {
    nearest,  ///< the pixel itself: for labels and depth, which must not mix
    bilinear,
    cubic  ///< Catmull-Rom: sharper; eight-bit values are clamped to 0..255
  };
  int width_px = 0;     ///< 0 = the lens's image
  int height_px = 0;    ///< 0 = the lens's image
  double focal_px = 0;  ///< of square pixels; 0 = the lens's own fx and fy at its centre, scaled
                        ///< with the size
  Interpolation interpolation = Interpolation::bilinear;
  /// The wanted camera itself, in place of the three above: views of lenses that differ become ones
  /// of the same camera. No width = not given.
  Camera pinhole;
};
/// @throws std::invalid_argument naming field, value and limit.
void validate(const UndistortConfig& config);

/// The pinhole camera of the undistorted image. Its principal point stays at the same share of
/// width and height, counted from the image's corner.
Camera undistorted_camera(const Camera& lens, const UndistortConfig& config = {});

template <class Pixel>
struct Undistorted {
  Camera camera;  ///< pinhole
  Image<Pixel> image;
  Image<std::uint8_t> valid;  ///< 255 where the lens's image shows the ray, else 0
};

/// The image as a pinhole camera in the same place would have taken it: each pixel's ray goes
/// through the lens model to where the given image is sampled. A pixel is valid if its ray lands
/// between centres of pixels; where not, or where the model gives no pixel (beyond its fold), it
/// has the value `border`. Rays that the pinhole image leaves out are lost, and an image made much
/// smaller than the given one aliases: scale that first. Eight-bit colours are sampled in their
/// codes; a NaN spreads to the pixels that touch it. TBB over rows; the same bytes on any number of
/// threads.
/// @throws std::invalid_argument if the lens or the configuration is invalid, or the image has
/// another size than the lens, or 16-bit values are asked to mix.
Undistorted<Rgb8> undistort(const Image<Rgb8>& image, const Camera& lens,
                            const UndistortConfig& config = {}, Rgb8 border = {});
Undistorted<std::uint8_t> undistort(const Image<std::uint8_t>& image, const Camera& lens,
                                    const UndistortConfig& config = {}, std::uint8_t border = 0);
Undistorted<float> undistort(const Image<float>& image, const Camera& lens,
                             const UndistortConfig& config = {}, float border = 0);
/// Sixteen bits are ids or depth: `nearest` alone.
Undistorted<std::uint16_t> undistort(
    const Image<std::uint16_t>& image, const Camera& lens,
    const UndistortConfig& config = {.interpolation = UndistortConfig::Interpolation::nearest},
    std::uint16_t border = 0);

}  // namespace cousin
