#pragma once

#include <filesystem>

#include "benchmarks/suites/real/real_rows.h"

namespace cousin {

/// Middlebury's cones of 2003 [Scharstein & Szeliski, CVPR 2003], 450 x 375 pixels, rectified, with
/// disparities by structured light to a quarter of a pixel: matched by both methods of the pipeline
/// stereo. Of pixels that both images show, "visible", and of all that have truth, "all": share
/// without a disparity, shares of the others off by more than 1 and 2 px, their mean error, and how
/// many of them lie within 1.96 sigma.
RealPart cones_stereo(const std::filesystem::path& real_data, const std::filesystem::path& out,
                      bool quick);

}  // namespace cousin
