#include "perception/stereo/opencv_matching.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>
#include <string>

#include "sim/types/no_value.h"

namespace cousin {
namespace {

cv::Mat as_codes(const Image<float>& image) {
  cv::Mat codes(image.height(), image.width(), CV_8U);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x)
      codes.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::clamp(std::lround(image(x, y)), 0L, 255L));
  }
  return codes;
}

}  // namespace

Image<float> match_by_opencv(const Image<float>& left, const Image<float>& right, int range_px) {
  if (left.empty() || left.width() != right.width() || left.height() != right.height() ||
      range_px < 1) {
    throw std::invalid_argument(
        "match_by_opencv: images of " + std::to_string(left.width()) + " x " +
        std::to_string(left.height()) + " and " + std::to_string(right.width()) + " x " +
        std::to_string(right.height()) + ", range_px = " + std::to_string(range_px));
  }
  constexpr int kFirst = 0, kBlock = 5, kP1 = 600, kP2 = 2400, kLeftRight = 1, kPreFilter = 0,
                kUniqueness = 10, kSpeckle = 100, kSpeckleRange = 2;
  const int count = (range_px + 15) / 16 * 16;
  const auto matcher =
      cv::StereoSGBM::create(kFirst, count, kBlock, kP1, kP2, kLeftRight, kPreFilter, kUniqueness,
                             kSpeckle, kSpeckleRange, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat sixteenths;
  matcher->compute(as_codes(left), as_codes(right), sixteenths);
  Image<float> disparity_px(left.width(), left.height(), kNone);
  for (int y = 0; y < left.height(); ++y) {
    for (int x = 0; x < left.width(); ++x) {
      const std::int16_t value = sixteenths.at<std::int16_t>(y, x);
      if (value > 0) disparity_px(x, y) = static_cast<float>(value) / 16;
    }
  }
  return disparity_px;
}

}  // namespace cousin
