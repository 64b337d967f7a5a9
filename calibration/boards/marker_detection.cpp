#include "calibration/boards/marker_detection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string_view>

#include "calibration/boards/homography.h"

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

std::vector<PlanePoint> plane_points(const CalibrationTarget& target, CharucoLayout layout,
                                     const SeenMarker& marker) {
  const auto at_m = marker_corners_m(target, layout, marker.id);
  std::vector<PlanePoint> points;
  for (std::size_t k = 0; k < 4; ++k) points.push_back({at_m[k], marker.corners_px[k], 1});
  return points;
}

/// A quadrilateral whose black has lost `lost_px` along x and y to white that grew by a square.
std::array<Eigen::Vector2d, 4> with_edges_back(const std::array<Eigen::Vector2d, 4>& corners,
                                               double lost_px) {
  std::array<Eigen::Vector3d, 4> edges;  // lines: normal outward, less the distance
  const Eigen::Vector2d centre = middle(corners);
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d along = corners[(k + 1) % 4] - corners[k];
    Eigen::Vector2d normal = Eigen::Vector2d(along.y(), -along.x()).normalized();
    if (normal.dot(corners[k] - centre) < 0) normal = -normal;
    edges[k] << normal, -normal.dot(corners[k]) - lost_px * normal.lpNorm<1>();
  }
  std::array<Eigen::Vector2d, 4> back = corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d at = edges[(k + 3) % 4].cross(edges[k]);
    const Eigen::Vector2d moved = at.head<2>() / at.z();
    if (moved.allFinite() && (moved - corners[k]).norm() < 4 * lost_px) back[k] = moved;
  }
  return back;
}

/// cv::aruco with what Kalibr's tags need.
class MarkerFinder {
 public:
  explicit MarkerFinder(const CalibrationTarget& target)
      : dictionary_(dictionary_of(target)),
        parameters_(cv::aruco::DetectorParameters::create()),
        has_tags_(target.kind == TargetKind::april_grid) {
    if (has_tags_) parameters_->markerBorderBits = 2;
    parameters_->adaptiveThreshWinSizeMax = 43;
    parameters_->minMarkerPerimeterRate = 0.02;
  }
  /// All, also those seen again in copies of the image. Tags touch the squares between them, and
  /// outlines run on from one to the next: they come apart where white grows by a pixel or two.
  std::vector<SeenMarker> operator()(const Image<std::uint8_t>& image) const {
    const cv::Mat source(image.height(), image.width(), CV_8U,
                         const_cast<std::uint8_t*>(image.data()));
    std::vector<SeenMarker> markers;
    for (const int size : has_tags_ ? std::vector<int>{1, 3, 5} : std::vector<int>{1}) {
      cv::Mat grown = source;
      if (size > 1)
        cv::dilate(source, grown, cv::getStructuringElement(cv::MORPH_RECT, {size, size}));
      std::vector<std::vector<cv::Point2f>> corners;
      std::vector<int> ids;
      cv::aruco::detectMarkers(grown, dictionary_, corners, ids, parameters_);
      for (std::size_t i = 0; i < ids.size(); ++i) {
        SeenMarker marker{ids[i], {}};
        for (std::size_t k = 0; k < 4; ++k) {
          marker.corners_px[k] = Eigen::Vector2d(static_cast<double>(corners[i][k].x),
                                                 static_cast<double>(corners[i][k].y));
        }
        if (size > 1) marker.corners_px = with_edges_back(marker.corners_px, (size - 1) / 2);
        markers.push_back(marker);
      }
    }
    return markers;
  }

 private:
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  bool has_tags_;
};

}  // namespace

std::vector<SeenMarker> find_markers(std::span<const Image<std::uint8_t>* const> images,
                                     const CalibrationTarget& target) {
  const MarkerFinder find(target);
  std::map<int, std::vector<std::array<Eigen::Vector2d, 4>>> seen;
  for (const Image<std::uint8_t>* image : images) {
    if (static_cast<int>(seen.size()) >= marker_count(target)) break;
    for (const SeenMarker& marker : find(*image)) {
      auto& places = seen[marker.id];
      const bool known = std::any_of(places.begin(), places.end(), [&](const auto& other) {
        return (middle(other) - middle(marker.corners_px)).norm() <
               0.5 * (marker.corners_px[0] - marker.corners_px[2]).norm();
      });
      if (!known) places.push_back(marker.corners_px);
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

std::array<Eigen::Vector2d, 4> marker_corners_m(const CalibrationTarget& target,
                                                CharucoLayout layout, int id) {
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
    const int first = (row % 2 == 0) == is_first_square_black(target, layout) ? 1 : 0;
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

MarkerOrder marker_order(const CalibrationTarget& target, CharucoLayout layout,
                         const std::vector<SeenMarker>& markers) {
  constexpr double kNear = 2.3, kFar = 0.5;  // of a pitch apart; of a marker's side off
  MarkerOrder order;
  for (const SeenMarker& a : markers) {
    const HomographyFit fit = fit_homography(plane_points(target, layout, a));
    if (!fit.ok) continue;
    const Eigen::Vector2d a_m = middle(marker_corners_m(target, layout, a.id));
    for (const SeenMarker& b : markers) {
      const Eigen::Vector2d b_m = middle(marker_corners_m(target, layout, b.id));
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

FoundPixels points_from_markers(const TargetGrid& grid, CharucoLayout layout,
                                const std::vector<SeenMarker>& markers) {
  const CalibrationTarget& target = grid.target();
  FoundPixels found(grid.points().size());
  // Of a tag's own, its side neighbours' and the one across the corner: outlines of tags lie a
  // pixel or two inside, which about a corner where four tags meet evens out.
  const double reach_m = target.pitch_m * (target.kind == TargetKind::april_grid
                                               ? 0.5 * std::numbers::sqrt2 + 1.5 * target.mark_share
                                               : 0.8);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Eigen::Vector2d& at_m = grid.points()[i].at_m;
    std::vector<PlanePoint> near;
    for (const SeenMarker& marker : markers) {
      if ((middle(marker_corners_m(target, layout, marker.id)) - at_m).norm() > reach_m) continue;
      for (const PlanePoint& p : plane_points(target, layout, marker)) near.push_back(p);
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
