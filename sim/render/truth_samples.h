#pragma once

#include "sim/render/truth_pass.h"

namespace cousin {

/// Share of each pixel's area that shows a specimen, from `samples` stratified rays where a pixel
/// and its eight neighbours do not agree; 0 or 1 elsewhere. Private to sim/render.
/// @param is_specimen  at pixel centres: 1 = specimen first hit.
Image<float> specimen_coverage(const RayScene& rays, const PreparedRays& prepared,
                               const Image<std::uint8_t>& is_specimen, int samples);

/// Full masks and visible fractions of all specimens, by id. @param instance  ids at pixel centres.
void add_visibility(const RayScene& rays, const TrueView& view, const PreparedRays& prepared,
                    const Image<std::int32_t>& instance, TruthImages& truth);

}  // namespace cousin
