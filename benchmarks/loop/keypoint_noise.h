#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "benchmarks/loop/keypoint_noise_config.h"
#include "benchmarks/loop/simulate.h"

namespace cousin {

/// What such a detector finds in all images of a run: of each object an entry with the point that
/// is first in `words` at its place 0, missing or not, and those of the other words behind it in
/// random order. A point is of a word if its name is that or begins with it and a space. Without
/// words all points in their order. Points hidden by others are found too; those outside the image
/// are missing. Entries' instances are not known to it, nor what is whose in another image.
/// @param seed  the same gives the same errors
Keypoints detected_keypoints(const SimulatedRun& run, std::span<const std::string_view> words,
                             const KeypointNoiseConfig& config, std::uint64_t seed);

/// True seams for the stages that a pipeline has not (PipelineRow::from_outside), keypoints with
/// noise. The run must outlive them.
Stages outside_stages(const SimulatedRun& run, const PipelineRow& row,
                      const KeypointNoiseConfig& config, std::uint64_t seed);

}  // namespace cousin
