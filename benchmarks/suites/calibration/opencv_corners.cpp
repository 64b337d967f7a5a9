#include "benchmarks/suites/calibration/opencv_corners.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

namespace cousin {

TargetView find_corners_by_opencv(const Image<Rgb8>& picture, const CalibrationTarget& target) {
  if (target.kind != TargetKind::chessboard)
    throw std::invalid_argument("corners by OpenCV: the target is no chessboard");
  cv::Mat color(picture.height(), picture.width(), CV_8UC3), grey;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Rgb8& p = picture(x, y);
      color.at<cv::Vec3b>(y, x) = cv::Vec3b(p.r, p.g, p.b);
    }
  }
  cv::cvtColor(color, grey, cv::COLOR_RGB2GRAY);
  const cv::Size size(target.columns - 1, target.rows - 1);
  std::vector<cv::Point2f> corners;
  TargetView view;
  if (!cv::findChessboardCorners(grey, size, corners)) {
    view.status = TargetStatus::not_seen;
    view.reason = "OpenCV finds no chessboard";
    return view;
  }
  cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 30, 0.001});
  view.status = TargetStatus::ok;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    view.points.push_back({static_cast<int>(i),
                           {static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)}});
  }
  return view;
}

}  // namespace cousin
