#pragma once

#include "perception/sfm/colmap_run.h"
#include "sim/dataset/import.h"

namespace cousin {

/// The lens of photographs of one camera of which nothing is known: by self-calibration (COLMAP,
/// then our adjustment of its tracks) on at most 40 of them, where they determine it to 10 %; else
/// 0.85 of the larger side, with a deviation of 25 %, which phones and cameras of middle zoom lie
/// within.
/// @throws as run_colmap
AssumedLens unknown_lens(const Capture& photographs, const ColmapConfig& config = {});

}  // namespace cousin
