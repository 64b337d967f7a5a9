#pragma once

#include "sim/config/fields.h"
#include "sim/types/capture.h"

namespace cousin {

/// HSV box of the green screen; defaults are the Seeds paper's in OpenCV's 8-bit HSV (hue 0..179,
/// half degrees). Both ends belong to the box. A low end above its high end makes an empty box:
/// nothing is green.
struct GreenConfig {
  int hue_low = 35, saturation_low = 25, value_low = 25;
  int hue_high = 77, saturation_high = 255, value_high = 255;
};
Fields fields(GreenConfig& config);
void validate(const GreenConfig& config);

/// 8-bit HSV exactly as OpenCV's COLOR_RGB2HSV makes it, rounding included.
struct Hsv8 {
  std::uint8_t hue = 0;  ///< half degrees, 0..179; 0 for grey
  std::uint8_t saturation = 0;
  std::uint8_t value = 0;
  bool operator==(const Hsv8&) const = default;
};
Hsv8 hsv8(Rgb8 color);

/// Whether a colour lies in the box.
bool is_green(Rgb8 color, const GreenConfig& config);

/// 255 where the pixel is not green screen, 0 where it is; the complement of cv::inRange on the HSV
/// image.
Image<std::uint8_t> remove_green(const Image<Rgb8>& image, const GreenConfig& config = {});

/// The same with specks filled: what is removed is only where a square of 3 x 3 pixels is green
/// (beyond the border everything is), every pixel of it. In noise, dark grey in green light is now
/// green, now not.
Image<std::uint8_t> without_specks(const Image<std::uint8_t>& kept);

}  // namespace cousin
