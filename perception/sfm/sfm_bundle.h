#pragma once

// Private to sfm: what refine_sfm passes between its steps.

#include <vector>

#include "calibration/bundle/bundle_adjustment.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/geometry/similarity.h"

namespace cousin {

/// An adjustment's start and what came of it. `images`: which of the frames each image is, those of
/// the model first.
struct SfmBundle {
  double sighting_px = 1;  ///< by which the deviations of sightings in `input` were multiplied
  std::vector<int> images;
  BundleAdjustmentInput input;
  BundleAdjustmentResult result;
};

/// The lens of each image, with its own focal lengths.
std::vector<Camera> image_lenses(const SfmBundle& bundle);

/// COLMAP's own poses and lenses as if they were an adjustment's.
SfmBundle as_it_is(const SfmModel& model);

/// What an adjustment that did not succeed makes of the estimate.
void take_failure(const BundleAdjustmentResult& result, SfmEstimate& estimate);

/// The whole bundle in the world `board_from_model` leads to. The start's lenses stay.
void move_bundle(const WorldSimilarity& board_from_model, SfmBundle& bundle);

/// A scale that is off moves cameras along their translations.
void add_scale_covariance(double sigma_share, BundleAdjustmentResult& result);

/// The bundle's poses, lens and points into the estimate.
void report_poses(const SfmBundle& bundle, const SfmModel& model, bool good, SfmEstimate& estimate);

/// The lens as all images share it, with its covariance.
void report_lens(const BundleAdjustmentResult& result, SfmEstimate& estimate);

/// Frames without a place, and what the estimate says of them.
void lose_frames(const SfmBundle& bundle, const std::vector<int>& frames, SfmEstimate& estimate);

}  // namespace cousin
