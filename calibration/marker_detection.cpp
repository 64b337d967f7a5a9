#include "calibration/marker_detection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string_view>

#include "calibration/homography.h"

namespace cousin {
namespace {

/// In the order of cv::aruco::PREDEFINED_DICTIONARY_NAME.
constexpr std::array<std::string_view, 21> kDictionaries = {
    "DICT_4X4_50",         "DICT_4X4_100",       "DICT_4X4_250",       "DICT_4X4_1000",
    "DICT_5X5_50",         "DICT_5X5_100",       "DICT_5X5_250",       "DICT_5X5_1000",
    "DICT_6X6_50",         "DICT_6X6_100",       "DICT_6X6_250",       "DICT_6X6_1000",
    "DICT_7X7_50",         "DICT_7X7_100",       "DICT_7X7_250",       "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const CalibrationTarget& target) {
  const std::string name =
      target.kind == TargetKind::april_grid ? "DICT_APRILTAG_36h11" : target.dictionary;
  const auto found = std::find(kDictionaries.begin(), kDictionaries.end(), name);
  if (found == kDictionaries.end()) {
    std::string names;
    for (const std::string_view n : kDictionaries)
      names += (names.empty() ? "" : ", ") + std::string(n);
    throw std::invalid_argument("dictionary \"" + name + "\" is not one of " + names);
  }
  return cv::aruco::getPredefinedDictionary(static_cast<int>(found - kDictionaries.begin()));
}

Eigen::Vector2d middle(const std::array<Eigen::Vector2d, 4>& corners) {
  return 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
}

std::vector<PlanePoint> plane_points(const CalibrationTarget& target, const SeenMarker& marker) {
  const auto at_m = marker_corners_m(target, marker.id);
  std::vector<PlanePoint> points;
  for (std::size_t k = 0; k < 4; ++k) points.push_back({at_m[k], marker.corners_px[k], 1});
  return points;
}

}  // namespace

std::vector<SeenMarker> find_markers(const Image<std::uint8_t>& image,
                                     const CalibrationTarget& target) {
  const auto dictionary = dictionary_of(target);
  const auto parameters = cv::aruco::DetectorParameters::create();
  const bool tags = target.kind == TargetKind::april_grid;
  if (tags) parameters->markerBorderBits = 2;
  parameters->adaptiveThreshWinSizeMax = 43;
  parameters->minMarkerPerimeterRate = 0.02;
  const cv::Mat source(image.height(), image.width(), CV_8U,
                       const_cast<std::uint8_t*>(image.data()));
  // Tags touch the squares between them, and outlines run on from one to the next: they come apart
  // where white grows by a pixel or two.
  std::map<int, std::vector<std::array<Eigen::Vector2d, 4>>> seen;
  for (const int size : tags ? std::vector<int>{1, 3, 5} : std::vector<int>{1}) {
    cv::Mat grown = source;
    if (size > 1) {
      cv::dilate(source, grown, cv::getStructuringElement(cv::MORPH_RECT, {size, size}));
    }
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(grown, dictionary, corners, ids, parameters);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      std::array<Eigen::Vector2d, 4> at;
      for (std::size_t k = 0; k < 4; ++k) {
        at[k] = Eigen::Vector2d(static_cast<double>(corners[i][k].x),
                                static_cast<double>(corners[i][k].y));
      }
      auto& places = seen[ids[i]];
      const bool known = std::any_of(places.begin(), places.end(), [&](const auto& other) {
        return (middle(other) - middle(at)).norm() < 0.5 * (at[0] - at[2]).norm();
      });
      if (!known) places.push_back(at);
    }
  }
  std::vector<SeenMarker> markers;
  for (const auto& [id, places] : seen) {
    if (places.size() == 1) markers.push_back({id, places.front()});
  }
  return markers;
}

int marker_count(const CalibrationTarget& target) {
  const int cells = target.columns * target.rows;
  return target.kind == TargetKind::april_grid ? cells : cells / 2;
}

std::array<Eigen::Vector2d, 4> marker_corners_m(const CalibrationTarget& target, int id) {
  const double p = target.pitch_m;
  if (target.kind == TargetKind::april_grid) {
    // cv::aruco's upper left corner is, upright as Kalibr prints it, the lower right.
    const double step = p * (1 + target.mark_share);
    const Eigen::Vector2d low =
        step * Eigen::Vector2d(id % target.columns - 0.5 * (target.columns - 1),
                               id / target.columns - 0.5 * (target.rows - 1)) -
        Eigen::Vector2d::Constant(0.5 * p);
    return {low + Eigen::Vector2d(p, 0), low, low + Eigen::Vector2d(0, p),
            low + Eigen::Vector2d(p, p)};
  }
  // Numbered along the white squares, row by row from the top.
  int left = id, row = 0, column = 0;
  for (; row < target.rows; ++row) {
    const int first = row % 2 == 0 ? 1 : 0;  // white where column + row is odd
    const int whites = (target.columns - first + 1) / 2;
    if (left < whites) {
      column = first + 2 * left;
      break;
    }
    left -= whites;
  }
  const Eigen::Vector2d centre =
      p * Eigen::Vector2d(column + 0.5 - 0.5 * target.columns, 0.5 * target.rows - row - 0.5);
  const double h = 0.5 * target.mark_share * p;
  return {centre + Eigen::Vector2d(-h, h), centre + Eigen::Vector2d(h, h),
          centre + Eigen::Vector2d(h, -h), centre + Eigen::Vector2d(-h, -h)};
}

MarkerOrder marker_order(const CalibrationTarget& target, const std::vector<SeenMarker>& markers) {
  constexpr double kNear = 2.3, kFar = 0.5;  // of a pitch apart; of a marker's side off
  MarkerOrder order;
  for (const SeenMarker& a : markers) {
    const HomographyFit fit = fit_homography(plane_points(target, a));
    if (!fit.ok) continue;
    const Eigen::Vector2d a_m = middle(marker_corners_m(target, a.id));
    for (const SeenMarker& b : markers) {
      const Eigen::Vector2d b_m = middle(marker_corners_m(target, b.id));
      const double apart = (a_m - b_m).norm() / target.pitch_m;
      if (a.id == b.id || apart > kNear) continue;
      const double side_px = (b.corners_px[0] - b.corners_px[2]).norm();
      const double off =
          (transfer(fit.normalized_from_plane, b_m) - middle(b.corners_px)).norm() / side_px;
      ++(off < kFar * apart ? order.agree : order.differ);
    }
  }
  return order;
}

FoundPixels points_from_markers(const TargetGrid& grid, const std::vector<SeenMarker>& markers) {
  const CalibrationTarget& target = grid.target();
  FoundPixels found(grid.points().size());
  if (target.kind == TargetKind::april_grid) {
    for (const SeenMarker& marker : markers) {
      const auto at_m = marker_corners_m(target, marker.id);
      for (std::size_t k = 0; k < 4; ++k) {
        const int column = marker.id % target.columns * 2 + (k == 0 || k == 3 ? 1 : 0);
        const int row = marker.id / target.columns * 2 + (k >= 2 ? 1 : 0);
        const int index = grid.at(column, row);
        if ((grid.points()[static_cast<std::size_t>(index)].at_m - at_m[k]).norm() <
            1e-6 * target.pitch_m)
          found[static_cast<std::size_t>(index)] = marker.corners_px[k];
      }
    }
    return found;
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Eigen::Vector2d& at_m = grid.points()[i].at_m;
    std::vector<PlanePoint> near;
    for (const SeenMarker& marker : markers) {
      if ((middle(marker_corners_m(target, marker.id)) - at_m).norm() > 0.8 * target.pitch_m)
        continue;
      for (const PlanePoint& p : plane_points(target, marker)) near.push_back(p);
    }
    if (near.empty()) continue;
    const HomographyFit fit = fit_homography(near);
    if (!fit.ok) continue;
    const Eigen::Vector2d at = transfer(fit.normalized_from_plane, at_m);
    if (at.allFinite()) found[i] = at;
  }
  return found;
}

}  // namespace cousin
