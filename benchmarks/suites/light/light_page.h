#pragma once

#include <vector>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"
#include "sim/types/image.h"

namespace cousin {

/// Error over seconds of both renderers, plain and adaptive: against their own converged images,
/// and from pairs. Of rows of other suites: none.
std::vector<ErrorTimeCurve> light_curves(const std::vector<ScoreRow>& rows);

/// Both images under one exposure and their difference, in which grey is none and black and white
/// are a tenth of the luminance and more.
void add_light_pictures(ReportScene& scene, const Image<Rgbf>& ours, const Image<Rgbf>& theirs);

/// Depth's relative difference: black 1e-7 and less, white 1e-2 and more, logarithmic; red where
/// the instances differ, blue where neither sees any.
void add_depth_picture(ReportScene& scene, const Image<float>& our_depth_m,
                       const Image<float>& their_depth_m, const Image<std::int32_t>& our_instance,
                       const Image<std::int32_t>& their_instance);

}  // namespace cousin
