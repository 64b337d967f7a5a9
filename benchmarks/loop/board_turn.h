#pragma once

#include "perception/pipelines/seeds.h"
#include "sim/dataset/truth_io.h"

namespace cousin {

/// A plain checkerboard looks the same after a quarter turn, so the world frame that perception
/// builds on it is one of four. The estimate in the one whose cameras lie nearest to the true ones
/// (without a posed view: whose centroids lie nearest to true specimens). Board corners keep their
/// numbers; other boards fix the frame and the estimate comes back as it is.
Estimate turned_to_truth(const Estimate& estimate, const SceneTruth& truth);

}  // namespace cousin
