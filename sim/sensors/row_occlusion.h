#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

/// What a device beside a rectified camera cannot see of its depth image, row by row: 1 where a
/// surface nearer to the device's side lies before the pixel's there, else 0. Surfaces that only
/// the device sees are unknown to the image and hide nothing.
/// @param x_m  of the device on the camera's x axis, either sign
Image<std::uint8_t> hidden_along_rows(const Image<float>& depth_m, double focal_px, double x_m);

}  // namespace cousin
