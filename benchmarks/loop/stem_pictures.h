#pragma once

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/loop/simulate.h"
#include "perception/pipelines/estimate.h"

namespace cousin {

/// Adds the stems of a stereo pair (fits.json) to a page: both images side by side with the fitted
/// stems, keypoints, and in the right one the epipolar lines of the left points; and the stems of
/// the first frame as tubes (the page has the true plants). Nothing where there are none.
void show_stems(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);

/// The picture of one frame. @throws std::invalid_argument if it has not two colour images
Image<Rgb8> stem_picture(const Capture& capture, const Frame& frame, std::size_t place,
                         const Estimate& estimate);

}  // namespace cousin
