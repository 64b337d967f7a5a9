#include "calibration/boards/seed_board_target.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "calibration/boards/board_detection.h"
#include "calibration/boards/target_grid.h"
#include "sim/imaging/color.h"

namespace cousin {
namespace {

/// 8-bit grey as colour, the brightest near white.
Image<Rgb8> grey_picture(const Image<float>& light) {
  std::vector<float> values;
  for (const float v : light) {
    if (std::isfinite(v)) values.push_back(v);
  }
  constexpr double kBright = 0.995;
  float white = 1;
  if (!values.empty()) {
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(kBright * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    white = std::max(*at, 1e-6F);
  }
  Image<Rgb8> picture(light.width(), light.height());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const float v = light.data()[i];
    const std::uint8_t grey = srgb8_from_linear(std::isfinite(v) ? 0.9F * v / white : 0.0F);
    picture.data()[i] = {grey, grey, grey};
  }
  return picture;
}

SeedBoard seed_board(const CalibrationTarget& target) {
  SeedBoard board;
  board.squares = target.columns;
  board.square_m = target.pitch_m;
  board.plate_m = print_size_m(target).x();
  board.marker_m = target.mark_share * target.pitch_m;
  return board;
}

/// One frame of a lens without distortion.
Capture pinhole_capture(const Image<float>& light) {
  Capture capture;
  SensorFrame frame;
  frame.color = grey_picture(light);
  frame.reported.model = LensModel::pinhole;
  frame.reported.width_px = light.width();
  frame.reported.height_px = light.height();
  frame.reported.fx_px = frame.reported.fy_px = light.width();
  frame.reported.cx_px = 0.5 * (light.width() - 1);
  frame.reported.cy_px = 0.5 * (light.height() - 1);
  capture.rig.resize(1);
  capture.frames.resize(1);
  capture.frames.front().sensors = {std::move(frame)};
  return capture;
}

}  // namespace

TargetView find_seed_board(const Image<float>& light, const CalibrationTarget& target,
                           const TargetDetectionConfig& config) {
  if (target.kind != TargetKind::seed_board)
    throw std::invalid_argument("target: a " + std::string(to_string(target.kind)) +
                                " is no seed board");
  TargetView view;
  if (!(target.mark_share > 0)) {
    view.status = TargetStatus::wrong_target;
    view.reason = "a seed board without markers looks the same after a quarter turn";
    return view;
  }
  BoardDetectionConfig detection;
  detection.max_sigma_px = config.max_sigma_px;
  const FrameCorners found =
      detect_board(pinhole_capture(light), seed_board(target), detection).front();
  switch (found.status) {
    case BoardStatus::ok:
      break;
    case BoardStatus::too_few_corners:
      view.status = TargetStatus::too_few_points;
      view.reason = "fewer than " + std::to_string(detection.min_corners) + " corners of the board";
      return view;
    case BoardStatus::ambiguous:
      view.status = TargetStatus::disordered;
      view.reason = "two places of the print on the picture do nearly as well";
      return view;
    case BoardStatus::not_seen:
    case BoardStatus::no_image:
      view.reason = "no seed board is seen";
      return view;
  }
  const TargetGrid grid(target);
  for (const CornerObservation& c : found.corners) {
    const int index = grid.at(c.column, c.row);
    if (index < 0) continue;
    view.points.push_back(
        {grid.points()[static_cast<std::size_t>(index)].id, c.pixel_px,
         c.covariance_px2 + config.floor_px * config.floor_px * Eigen::Matrix2d::Identity()});
  }
  std::sort(view.points.begin(), view.points.end(),
            [](const TargetObservation& a, const TargetObservation& b) { return a.id < b.id; });
  const int least = std::max(
      detection.min_corners,
      static_cast<int>(std::ceil(config.least_share * static_cast<double>(grid.points().size()))));
  if (static_cast<int>(view.points.size()) < least) {
    view.status = TargetStatus::too_few_points;
    view.reason =
        std::to_string(view.points.size()) + " points; the least is " + std::to_string(least);
    view.points.clear();
    return view;
  }
  view.status = TargetStatus::ok;
  return view;
}

}  // namespace cousin
