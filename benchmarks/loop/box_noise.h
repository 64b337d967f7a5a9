#pragma once

#include <cstdint>

#include "benchmarks/loop/box_noise_config.h"
#include "sim/types/seams.h"

namespace cousin {

/// What such a detector makes of true boxes with masks:
/// - a box of `px` pixels is found with the chance (1 - missed) / (1 + (half_px / px)^2);
/// - its mask grows or shrinks, its box with it; one that shrinks to nothing is not found;
/// - boxes of nothing are discs of the sizes of those that are there, anywhere in an image that has
///   some; score and category are those of the box whose size they have.
/// Ids are given anew. @param seed  the same gives the same errors
Boxes detected_boxes(const Boxes& truth, const BoxNoiseConfig& config, std::uint64_t seed);

}  // namespace cousin
