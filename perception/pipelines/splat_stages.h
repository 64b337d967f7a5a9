#pragma once

#include <cstdint>

#include "perception/pipelines/seeds.h"

namespace cousin {

/// Gaussians between poses and what is measured. `splats_paper`: trained as the reference does, and
/// their centres as the cloud. `splats`: trained our way from the closed surfaces that the method
/// `ours` finds (photographs alone leave Gaussians of plain surfaces where they begin), and their
/// depth in place of the plane sweep's. Private to perception/pipelines.
void take_splats(const SeedsPipelineConfig& config, std::uint64_t seed, const SplatWatch& watch,
                 Stages& stages);

}  // namespace cousin
