#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

float srgb_from_linear(float linear);  ///< IEC 61966-2-1, clamped to [0, 1]
float linear_from_srgb(float srgb);
/// 8-bit sRGB, rounded to nearest.
std::uint8_t srgb8_from_linear(float linear);
/// Linear value of each 8-bit code.
float linear_from_srgb8(std::uint8_t code);

Image<Rgbf> linear_from_srgb8(const Image<Rgb8>& image);
/// Luma of 8-bit sRGB codes (Rec. 601 weights) as float 0..255.
Image<float> luma(const Image<Rgb8>& image);

}  // namespace cousin
