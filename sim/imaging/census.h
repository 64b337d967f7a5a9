#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

/// Centre-symmetric census transform [Spangenberg, Langner & Rojas, CAIP 2013] of three values, as
/// in local ternary patterns [Tan & Triggs, TIP 2010]: pixels opposite each other about the centre
/// are compared, two bits a pair: 01 if the upper (or left) one is brighter by more than `margin`,
/// 10 if it is darker by more, else 00. So noise below the margin leaves even areas empty, and the
/// Hamming distance of two codes counts pairs that differ, opposite ones twice. Half as many pairs
/// as the census of Zabih & Woodfill [ECCV 1994] for the same window. Pixels beyond the border
/// repeat the border's.
/// @param width_px, height_px  odd, with at most 32 pairs: 7 x 7 has 24, 9 x 7 has 31.
/// @throws std::invalid_argument for another window or a negative margin.
Image<std::uint64_t> census_transform(const Image<float>& image, int width_px, int height_px,
                                      double margin = 0);
Image<std::uint64_t> census_transform(const Image<std::uint16_t>& image, int width_px,
                                      int height_px, double margin = 0);

/// Number of pairs of a window. @throws std::invalid_argument as above.
int census_pairs(int width_px, int height_px);

}  // namespace cousin
