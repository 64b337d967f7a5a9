#pragma once

#include <string_view>

#include "perception/stereo/pair_matching.h"
#include "sim/config/fields.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// Depth from the two cameras of a rig, without a projector.
struct StereoDepthConfig {
  PairMatchConfig pair;
  double nearest_m = 0;        ///< disparities end there if it is not 0, in place of pair.range_px
  double most_apart_s = 0.05;  ///< exposures farther apart are no pair
  /// Deviation of all disparities of a frame together by what the reported calibration is off,
  /// beside the rows' own offset: what is off along rows is as much.
  double calibration_px = 0.1;
};
/// All but the matcher, which a pipeline calls its method.
Fields fields(StereoDepthConfig& config);
TextField matcher_field(PairMatcher& matcher);
std::string_view to_string(PairMatcher matcher);
/// @throws std::invalid_argument naming field, value and limit.
void validate(const StereoDepthConfig& config);

/// One frame's depth, and how its pair was matched.
struct StereoMeasure {
  FrameDepth depth;  ///< empty where `findings.why_none` says why
  PairFindings findings;
};

/// Depth of the first camera's pixels in one frame: both images are rectified by the reported
/// calibration, matched, and each pixel of the first image looks its disparity up between the
/// rectified image's pixels. Along the first camera's axis, in metres; NaN = no match. sigma_m is
/// of the match and of the calibration; empty where the matcher says nothing of its own.
/// @throws std::invalid_argument if the capture is not of a stereo rig (stereo_pair.h), the
/// configuration is invalid, or nearest_m is nearer than the whole image's width of disparity
StereoMeasure measure_stereo(const Capture& capture, std::size_t frame,
                             const StereoDepthConfig& config = {});

/// Its depth alone. @throws std::invalid_argument also where the frame's images are no pair
FrameDepth depth_of_stereo(const Capture& capture, std::size_t frame,
                           const StereoDepthConfig& config = {});

}  // namespace cousin
