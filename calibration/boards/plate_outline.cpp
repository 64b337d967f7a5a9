#include "calibration/boards/plate_outline.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "calibration/boards/homography.h"

namespace cousin {
namespace {

constexpr double kPixelsPerSquare = 10;

/// 255 where a pixel is not green: neither red nor blue falls well short of green.
cv::Mat not_green(const Image<Rgb8>& color) {
  constexpr int kLead = 25;  // of 255, of green over the larger of red and blue
  cv::Mat mask(color.height(), color.width(), CV_8U);
  for (int y = 0; y < color.height(); ++y) {
    auto* row = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < color.width(); ++x) {
      const Rgb8 c = color(x, y);
      row[x] = c.g > std::max(c.r, c.b) + kLead ? 0 : 255;
    }
  }
  return mask;
}

/// The largest region's outline as four corners, clockwise in the image; empty if it has not four
/// sides.
std::vector<cv::Point2f> plate_quad(const cv::Mat& mask) {
  constexpr double kMinArea = 400;  // px^2
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto largest = std::max_element(
      outlines.begin(), outlines.end(),
      [](const auto& a, const auto& b) { return cv::contourArea(a) < cv::contourArea(b); });
  if (largest == outlines.end() || cv::contourArea(*largest) < kMinArea) return {};
  std::vector<cv::Point> hull, quad;
  cv::convexHull(*largest, hull, true);
  const double length = cv::arcLength(hull, true);
  for (double tolerance = 0.01; tolerance < 0.1; tolerance *= 1.25) {
    cv::approxPolyDP(hull, quad, tolerance * length, true);
    if (quad.size() <= 4) break;
  }
  if (quad.size() != 4) return {};
  // The signed area says which way round; a print that is laid round the same way is not mirrored.
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f a = quad[i], b = quad[(i + 1) % 4];
    area += a.x * b.y - a.y * b.x;
  }
  if (area < 0) std::reverse(quad.begin(), quad.end());
  return {quad.begin(), quad.end()};
}

/// Homography from the plate's four corners, `turn` quarters on; no fit where they do not span a
/// plane.
HomographyFit fit_corners_of_plate(const std::vector<Eigen::Vector2d>& normalized, std::size_t turn,
                                   double half_m) {
  // Clockwise as seen from above.
  const std::array<Eigen::Vector2d, 4> corners = {
      Eigen::Vector2d(-half_m, half_m), Eigen::Vector2d(half_m, half_m),
      Eigen::Vector2d(half_m, -half_m), Eigen::Vector2d(-half_m, -half_m)};
  std::vector<PlanePoint> points;
  for (std::size_t i = 0; i < 4; ++i) {
    points.push_back({corners[(i + turn) % 4], normalized[i], 1e-3});
  }
  return fit_homography(points);
}

/// The outline's corners without the plate's side: a corner whose lower end sticks out of the upper
/// face is seen too low by what the side measures there.
/// @param h  normalized from plate, of the whole outline
std::vector<Eigen::Vector2d> upper_face(const std::vector<Eigen::Vector2d>& outline,
                                        const Eigen::Matrix3d& h, double thickness_m) {
  const double scale = std::sqrt(h.col(0).norm() * h.col(1).norm());
  const Eigen::Vector3d up = h.col(0).cross(h.col(1)) / (scale * scale);
  std::vector<cv::Point2f> face;
  for (const Eigen::Vector2d& p : outline)
    face.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector2d& corner : outline) {
    const Eigen::Vector3d in_plane = h.inverse() * corner.homogeneous();
    const Eigen::Vector3d top = h * (in_plane / in_plane.z()) / scale;
    const Eigen::Vector2d side = (top - thickness_m * up).hnormalized() - top.hnormalized();
    const Eigen::Vector2d low = corner + side;
    const double inside = cv::pointPolygonTest(
        face, {static_cast<float>(low.x()), static_cast<float>(low.y())}, true);
    const double length = side.norm();
    const double out = length > 0 ? std::clamp(-inside / length, 0.0, 1.0) : 0.0;
    corners.push_back(corner - out * side);
  }
  return corners;
}

}  // namespace

std::vector<LatticeCorner> lattice_of_upright_plate(const Image<Rgb8>& color,
                                                    const Image<float>& perceptual,
                                                    const SeedBoard& board, double smoothing_px,
                                                    double contrast) {
  const std::vector<cv::Point2f> quad = plate_quad(not_green(color));
  if (quad.empty()) return {};
  const int side = static_cast<int>(std::lround(kPixelsPerSquare * board.plate_m / board.square_m));
  const float low = -0.5F, high = static_cast<float>(side) - 0.5F;
  const std::vector<cv::Point2f> upright = {{low, low}, {high, low}, {high, high}, {low, high}};
  const cv::Mat upright_from_image = cv::getPerspectiveTransform(quad, upright);
  Image<float> warped(side, side);
  cv::Mat to(side, side, CV_32F, warped.data());
  cv::warpPerspective(cv::Mat(perceptual.height(), perceptual.width(), CV_32F,
                              const_cast<float*>(perceptual.data())),
                      to, upright_from_image, to.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  std::vector<LatticeCorner> lattice =
      grow_lattice(warped, find_saddles(warped, smoothing_px, contrast), board.squares - 1);
  const cv::Mat back = upright_from_image.inv();
  for (LatticeCorner& c : lattice) {
    std::vector<cv::Point2d> point = {{c.pixel_px.x(), c.pixel_px.y()}}, image;
    cv::perspectiveTransform(point, image, back);
    c.pixel_px = {image[0].x, image[0].y};
  }
  return lattice;
}

std::vector<std::vector<Eigen::Matrix3d>> boards_in_outline(const Image<Rgb8>& color,
                                                            const Camera& camera,
                                                            const SeedBoard& board) {
  constexpr std::array<double, 5> kThicknesses_m = {0, 0.001, 0.002, 0.003, 0.004};
  constexpr float kBorder_px = 2;  // a corner nearer to it may be where the image cuts the plate
  const double half_m = 0.5 * board.plate_m;
  std::vector<Eigen::Vector2d> outline;
  for (const cv::Point2f& corner : plate_quad(not_green(color))) {
    const bool whole = corner.x >= kBorder_px && corner.y >= kBorder_px &&
                       corner.x <= static_cast<float>(color.width() - 1) - kBorder_px &&
                       corner.y <= static_cast<float>(color.height() - 1) - kBorder_px;
    const auto ray = unproject(camera, {corner.x, corner.y});
    if (!whole || !ray || ray->z() < 1e-3) return {};
    outline.push_back(ray->head<2>() / ray->z());
  }
  if (outline.empty()) return {};
  const HomographyFit fit = fit_corners_of_plate(outline, 0, half_m);
  if (!fit.ok) return {};
  std::vector<std::vector<Eigen::Matrix3d>> turns(board.has_markers ? 4 : 1);
  for (const double thickness_m : kThicknesses_m) {
    const auto corners = upper_face(outline, fit.normalized_from_plane, thickness_m);
    for (std::size_t turn = 0; turn < turns.size(); ++turn) {
      const HomographyFit face = fit_corners_of_plate(corners, turn, half_m);
      if (face.ok) turns[turn].push_back(face.normalized_from_plane);
    }
  }
  return turns;
}

}  // namespace cousin
