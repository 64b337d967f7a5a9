#pragma once

#include "sim/config/fields.h"
#include "sim/imaging/stereo_matching.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// Depth from the two colour cameras of a rig, without a projector.
struct StereoDepthConfig {
  StereoMatchConfig match = {.margin = 3, .range_px = 190};  ///< of luma codes, 0..255
  double nearest_m = 0;  ///< disparities end there if it is not 0, in place of match.range_px
};
/// Keys of the range alone; the matcher's others are as match_stereo has them.
Fields fields(StereoDepthConfig& config);
/// @throws std::invalid_argument naming field, value and limit.
void validate(const StereoDepthConfig& config);

/// Depth of the first camera's pixels in one frame: both images are rectified by the reported
/// calibration, matched, and each pixel of the first image looks its depth up where the rectified
/// image shows it. Along the first camera's axis, in metres; NaN = no match.
/// @throws std::invalid_argument if the frame has not two sensors with colour, the second at the
/// right of the first, or the configuration is invalid.
FrameDepth depth_of_stereo(const Capture& capture, std::size_t frame,
                           const StereoDepthConfig& config = {});

}  // namespace cousin
