#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

/// Centre-symmetric census transform [Spangenberg, Langner & Rojas, CAIP 2013]: one bit for each
/// pair of pixels opposite each other about the centre, set where the upper (or left) one is
/// brighter. Half as many bits as the census of Zabih & Woodfill [ECCV 1994] for the same window,
/// and blind to any monotone change of brightness. Pixels beyond the border repeat the border's.
/// @param width_px, height_px  odd, with at most 32 pairs: 7 x 7 has 24, 9 x 7 has 31.
/// @throws std::invalid_argument for another window.
Image<std::uint32_t> census_transform(const Image<float>& image, int width_px, int height_px);
Image<std::uint32_t> census_transform(const Image<std::uint16_t>& image, int width_px,
                                      int height_px);

/// Number of pairs of a window. @throws std::invalid_argument as above.
int census_bits(int width_px, int height_px);

}  // namespace cousin
