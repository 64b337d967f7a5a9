#pragma once

#include "sim/types/image.h"

namespace cousin {

/// OpenCV's semi-global block matching (cv::StereoSGBM, three-way), its parameters as the
/// comparator of the real pair has them: block 5, P1 600, P2 2400, uniqueness 10, speckles below
/// 100 pixels, left-right check of 1 px.
/// @param left, right  of a rectified pair, brightness 0..255
/// @param range_px     disparities 1 .. range, rounded up to a multiple of 16
/// @return             disparities of the left image's pixels; NaN = none
/// @throws std::invalid_argument for images of different or no size, or a range below 1
Image<float> match_by_opencv(const Image<float>& left, const Image<float>& right, int range_px);

}  // namespace cousin
