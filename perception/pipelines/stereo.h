#pragma once

#include <cstdint>

#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/stereo/stereo_depth.h"

namespace cousin {

/// Depth of anything that two cameras see, without a projector.
struct StereoPipelineConfig {
  PairMatcher method = PairMatcher::ours;
  StereoDepthConfig stereo;
  int cloud_points = 1'000'000;  ///< about, of all frames together, spread evenly; 0: no cloud
  double cloud_sigma = 0.02;     ///< over the depth: points known worse are left out of the cloud
};
Fields fields(StereoPipelineConfig& config);
void validate(const StereoPipelineConfig& config);

PipelineNeeds needs(const StereoPipelineConfig& config);
/// A sentence for each setting that the method does not use.
std::vector<std::string> unused_settings(const StereoPipelineConfig& config);
/// @throws as check_stereo_rig
void check_capture(const Capture& capture, const StereoPipelineConfig& config);

/// Stages depth and cloud.
///
/// Depth is of the first camera's pixels, with its deviation (measure_stereo). A frame whose images
/// are no pair, or of which too little is found, has none, and a note says why; without any the
/// stage fails and says why. What is doubted of a pair is a note too.
///
/// The cloud is in the world where the rig says where it is; else it is the first frame's that has
/// depth, in the axes of its first camera. Its sigma is along the normal of what the depths' own
/// slope says, which is the point's normal.
Stages stages_for(const StereoPipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch);
struct PipelineRow;
const PipelineRow& row_of(const StereoPipelineConfig& config);

}  // namespace cousin
