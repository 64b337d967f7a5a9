#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "benchmarks/loop/box_noise_config.h"
#include "benchmarks/loop/keypoint_noise_config.h"
#include "benchmarks/loop/simulate.h"

namespace cousin {

/// What such a detector finds in all images of a run. Each object gives one entry an image. Its
/// place 0 is the point of the first word, missing or not; points of the other words follow in
/// random order. A point is of a word if its name is the word or begins with it and a space.
/// Without words, all points follow in their order. Points behind others are found too; those
/// outside the image are missing. Entries do not say which object they are of.
/// @param seed  the same gives the same errors
Keypoints detected_keypoints(const SimulatedRun& run, std::span<const std::string_view> words,
                             const KeypointNoiseConfig& config, std::uint64_t seed);

/// True seams for the stages that a pipeline has not (PipelineRow::from_outside), keypoints and
/// boxes with noise. The run must outlive them.
Stages outside_stages(const SimulatedRun& run, const PipelineRow& row,
                      const KeypointNoiseConfig& config, std::uint64_t seed,
                      const BoxNoiseConfig& boxes = {});

}  // namespace cousin
