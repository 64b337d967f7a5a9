#pragma once

#include "perception/pipelines/pipeline_table.h"
#include "sim/config/fields.h"

namespace cousin {

/// How a detector errs that hands over true keypoints; without noise by default.
struct KeypointNoiseConfig {
  double sigma_px = 0;         ///< of each image on its own, each axis
  double common_sigma_px = 0;  ///< of what all images of a frame have in common
  double gross_share = 0;      ///< of the points of an image that are far beside, on their own
  double gross_sigma_px = 30;  ///< of those; the detector does not know of them
  double missed = 0;           ///< share of the points of an image that are not found
  double false_points = 0;     ///< mean count in an image about each object
  /// Points of one object that are nearer to each other in the first image are one to a detector:
  /// the first of the model stands for both. The object's first point is on its own.
  double least_apart_px = 6;
};
Fields fields(KeypointNoiseConfig& config);
/// @throws std::invalid_argument naming key, value and limit
void validate(const KeypointNoiseConfig& config);

/// Whether `run` makes keypoints for a pipeline.
bool takes_keypoints(const PipelineRow& row);

}  // namespace cousin
